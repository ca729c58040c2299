//! Kinds of the columns of a table.

use std::collections::HashSet;

use crate::episode::NOTE_PREFIX;
use crate::fault::Fault;

/// Kind of a column, determined by its title.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ColumnKind {
    Number,
    Note,
}

/// Refuses the title of a numeric column, other than `t`, that the format does not define.
pub(crate) type CheckTitle<'a> = &'a dyn Fn(&str) -> Result<(), Fault>;

/// Kind of each column in a header.
///
/// # Errors
/// The first title that is unknown or a duplicate.
pub(super) fn column_kinds(
    titles: &[String],
    check: CheckTitle<'_>,
) -> Result<Vec<ColumnKind>, (String, Fault)> {
    let mut seen = HashSet::with_capacity(titles.len());
    let kind = |title: &String| {
        if !seen.insert(title.clone()) {
            Err((title.clone(), Fault::DuplicateColumn))
        } else if title.starts_with(NOTE_PREFIX) {
            Ok(ColumnKind::Note)
        } else if title == "t" {
            Ok(ColumnKind::Number)
        } else {
            check(title).map(|()| ColumnKind::Number).map_err(|fault| (title.clone(), fault))
        }
    };
    titles.iter().map(kind).collect()
}
