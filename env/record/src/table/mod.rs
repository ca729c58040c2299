//! Episode tables on disk.

mod budget;
mod columns;
mod csv;
mod parquet_pages;
mod parquet_read;
mod parquet_types;
mod parquet_write;

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use crate::episode::Episode;
use crate::error::{Error, Place};
use crate::fault::Fault;
pub(crate) use budget::Budget;
pub(crate) use columns::CheckTitle;
pub use parquet_write::Column;

/// File format of an episode table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Table {
    /// Text, one line per row.
    Csv,
    /// Apache Parquet.
    Parquet,
}

impl Table {
    /// All formats.
    pub const ALL: [Self; 2] = [Self::Csv, Self::Parquet];

    /// File extension, which is also the name of the format in Python.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }

    /// The format of the table at `path`, by its extension.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?;
        Self::ALL.into_iter().find(|table| ending.eq_ignore_ascii_case(table.extension()))
    }

    /// Reads the table at `path` as the episode `name`, and reserves its memory from `budget`.
    pub(crate) fn read(
        self,
        path: &Path,
        name: &str,
        budget: &mut Budget,
        check: CheckTitle<'_>,
    ) -> Result<Episode, Error> {
        match self {
            // Each cell has at least one byte on disk, so the memory is at most a few times the file size.
            Self::Csv => csv::read(path, name, check),
            Self::Parquet => parquet_read::read(path, name, budget, check),
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
/// If the file cannot be written. A partially written file is not removed.
pub fn write_parquet(path: &Path, columns: &[(&str, Column<'_>)]) -> Result<(), Error> {
    let not_written = |source| Fault::Io { action: "written", source }.at(Place::path(path));
    let sink = BufWriter::new(File::create(path).map_err(not_written)?);
    parquet_write::write_columns(columns, sink).map_err(|error| not_written(error.into()))
}
