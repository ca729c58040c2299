//! Errors about recordings: the place, the fault and the remedy.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::escaped::Escaped;
use crate::fault::Fault;

/// A fault and its place.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {fault}")]
pub struct Error {
    /// File, row, column or key.
    pub place: Box<Place>,
    /// What is wrong, and the remedy.
    pub fault: Box<Fault>,
}

/// Place of a fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The file.
    pub file: File,
    /// Data row, counted from 1 without the header.
    pub row: Option<usize>,
    /// Column of a table.
    pub column: Option<String>,
    /// Dotted key of `recording.toml`, for example `wrench.precontact`.
    pub key: Option<String>,
}

/// A file of a recording. Recordings in memory have no paths, so two variants name the file by its role.
#[derive(Debug, Clone, PartialEq)]
pub enum File {
    /// `recording.toml`.
    Metadata,
    /// The table of the named episode.
    Episode(String),
    /// A file or folder on disk.
    Path(PathBuf),
}

impl Place {
    /// The table of episode `name`.
    pub fn episode(name: &str) -> Self {
        Self::file(File::Episode(name.to_owned()))
    }

    /// The dotted key `key` of `recording.toml`; the whole file if `key` is empty.
    pub fn field(key: &str) -> Self {
        let key = (!key.is_empty()).then(|| key.to_owned());
        Self { key, ..Self::file(File::Metadata) }
    }

    /// A file or folder.
    pub fn path(path: &Path) -> Self {
        Self::file(File::Path(path.to_owned()))
    }

    /// The same place with data row `row`, counted from 1.
    #[must_use]
    pub fn row(self, row: usize) -> Self {
        Self { row: Some(row), ..self }
    }

    /// The same place with column `name`.
    #[must_use]
    pub fn column(self, name: &str) -> Self {
        Self { column: Some(name.to_owned()), ..self }
    }

    fn file(file: File) -> Self {
        Self { file, row: None, column: None, key: None }
    }
}

impl Error {
    /// The same error with the path of its file, if `path_of` returns one.
    pub(crate) fn on_disk(mut self, path_of: impl FnOnce(&File) -> Option<PathBuf>) -> Self {
        if let Some(path) = path_of(&self.place.file) {
            self.place.file = File::Path(path);
        }
        self
    }
}

impl Fault {
    /// The error of this fault at `place`.
    pub fn at(self, place: Place) -> Error {
        Error { place: Box::new(place), fault: Box::new(self) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            File::Metadata => write!(f, "recording.toml")?,
            File::Episode(name) => write!(f, "episode {}", Escaped(name))?,
            File::Path(path) => write!(f, "{}", Escaped(&path.to_string_lossy()))?,
        }
        if let Some(row) = self.row {
            write!(f, ", row {row}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ", column {}", Escaped(column))?;
        }
        if let Some(key) = &self.key {
            write!(f, ", {}", Escaped(key))?;
        }
        Ok(())
    }
}
