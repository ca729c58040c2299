//! Episode tables on disk.

mod budget;
mod csv;
mod parquet_pages;
mod parquet_read;
mod parquet_types;
mod parquet_write;

use std::collections::HashSet;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use crate::episode::{Episode, NOTE_PREFIX, known_columns};
use crate::error::{Error, Place};
use crate::fault::Fault;
pub(crate) use budget::Budget;
pub use parquet_write::Column;

/// The two kinds of table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Table {
    /// Text, one line a sample.
    Csv,
    /// Binary columns.
    Parquet,
}

impl Table {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Csv, Self::Parquet];

    /// Ending of the file's name, which is also the kind's name in Python.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }

    /// The kind of the table at `path`, by its ending.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?;
        Self::ALL.into_iter().find(|table| ending.eq_ignore_ascii_case(table.extension()))
    }

    /// Reads the table at `path`; what it takes in memory is taken from `budget`.
    pub(crate) fn read(self, path: &Path, name: &str, budget: &mut Budget) -> Result<Episode, Error> {
        match self {
            // A cell has a byte and a comma at least: it cannot take more than a few times its size.
            Self::Csv => csv::read(path, name),
            Self::Parquet => parquet_read::read(path, name, budget),
        }
    }

    pub(crate) fn write(self, path: &Path, episode: &Episode) -> Result<(), Error> {
        let not_written = |source| Fault::Io { action: "written", source }.at(Place::path(path));
        let sink = BufWriter::new(File::create(path).map_err(not_written)?);
        match self {
            Self::Csv => csv::write(episode, sink).map_err(|error| not_written(error.into())),
            Self::Parquet => parquet_write::write(episode, sink).map_err(|error| not_written(error.into())),
        }
    }
}

/// Writes named columns of equal length as a Parquet file at `path`.
///
/// # Errors
/// When the file cannot be written; what was written of it stays.
pub fn write_parquet(path: &Path, columns: &[(&str, Column<'_>)]) -> Result<(), Error> {
    let not_written = |source| Fault::Io { action: "written", source }.at(Place::path(path));
    let sink = BufWriter::new(File::create(path).map_err(not_written)?);
    parquet_write::write_columns(columns, sink).map_err(|error| not_written(error.into()))
}

/// What a table's header says about a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Number,
    Note,
}

/// The kind of each column in a header.
///
/// # Errors
/// The first title that is unknown or that was there before.
fn kinds(titles: &[String]) -> Result<Vec<Kind>, (String, Fault)> {
    let mut seen = HashSet::with_capacity(titles.len());
    let kind = |title: &String| {
        if !seen.insert(title.clone()) {
            Err((title.clone(), Fault::DuplicateColumn))
        } else if title.starts_with(NOTE_PREFIX) {
            Ok(Kind::Note)
        } else if title == "t" || known_columns().any(|known| known == title) {
            Ok(Kind::Number)
        } else {
            Err((title.clone(), Fault::unknown_column(title)))
        }
    };
    titles.iter().map(kind).collect()
}
