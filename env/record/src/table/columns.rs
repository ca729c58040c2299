//! Kinds of the columns of a table.

use std::collections::HashSet;

use crate::episode::{NOTE_PREFIX, known_columns};
use crate::fault::Fault;

/// Kind of a column, determined by its title.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ColumnKind {
    Number,
    Note,
}

/// Kind of each column in a header.
///
/// # Errors
/// The first title that is unknown or a duplicate.
pub(super) fn column_kinds(titles: &[String]) -> Result<Vec<ColumnKind>, (String, Fault)> {
    let mut seen = HashSet::with_capacity(titles.len());
    let kind = |title: &String| {
        if !seen.insert(title.clone()) {
            Err((title.clone(), Fault::DuplicateColumn))
        } else if title.starts_with(NOTE_PREFIX) {
            Ok(ColumnKind::Note)
        } else if title == "t" || known_columns().any(|known| known == title) {
            Ok(ColumnKind::Number)
        } else {
            Err((title.clone(), Fault::unknown_column(title)))
        }
    };
    titles.iter().map(kind).collect()
}
