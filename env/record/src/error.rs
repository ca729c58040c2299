//! What is wrong with a recording: where, what, and what to do about it.

use std::fmt;
use std::path::{Path, PathBuf};

/// One fault at one place.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {fault}")]
pub struct Error {
    /// File, row and column.
    pub place: Place,
    /// What is wrong there, and the remedy.
    #[source]
    pub fault: Fault,
}

/// Where a fault is.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The file, or what stands for it in memory.
    pub file: File,
    /// Data row, counted from 1, the header left out.
    pub row: Option<usize>,
    /// Column of a table, or key of `recording.toml`.
    pub column: Option<String>,
}

/// The file, or what stands for it in memory.
#[derive(Debug, Clone, PartialEq)]
pub enum File {
    /// `recording.toml`.
    Metadata,
    /// The table of the episode of this name.
    Episode(String),
    /// A file or folder on disk.
    Path(PathBuf),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            File::Metadata => write!(f, "recording.toml")?,
            File::Episode(name) => write!(f, "{name}")?,
            File::Path(path) => write!(f, "{}", path.display())?,
        }
        if let Some(row) = self.row {
            write!(f, ", row {row}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ", {column}")?;
        }
        Ok(())
    }
}

/// What is wrong, with the value that is, and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// The episode holds too little for what is asked of it.
    #[error("{reason}; {remedy}")]
    Unusable {
        /// What is missing or contradictory, with its figures.
        reason: String,
        /// What the person who records can do.
        remedy: String,
    },
}

impl Fault {
    /// This fault at the place where it is.
    pub fn at(self, place: Place) -> Error {
        Error { place, fault: self }
    }
}

impl Place {
    /// The table of episode `name`.
    pub fn episode(name: &str) -> Self {
        Self {
            file: File::Episode(name.to_owned()),
            row: None,
            column: None,
        }
    }

    /// A key of `recording.toml`, as `wrench.precontact`.
    pub fn field(key: &str) -> Self {
        Self {
            file: File::Metadata,
            row: None,
            column: Some(key.to_owned()),
        }
    }

    /// A file or folder.
    pub fn path(path: &Path) -> Self {
        Self {
            file: File::Path(path.to_owned()),
            row: None,
            column: None,
        }
    }

    /// The same place, at data row `row`, counted from 1.
    #[must_use]
    pub fn row(self, row: usize) -> Self {
        Self {
            row: Some(row),
            ..self
        }
    }

    /// The same place, in column `name`.
    #[must_use]
    pub fn column(self, name: &str) -> Self {
        Self {
            column: Some(name.to_owned()),
            ..self
        }
    }
}
