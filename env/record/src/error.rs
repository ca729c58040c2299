//! What is wrong with a recording: where, what, and what to do about it.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::fault::Fault;

/// One fault at one place.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {fault}")]
pub struct Error {
    /// File, row and column.
    pub place: Box<Place>,
    /// What is wrong there, and the remedy.
    pub fault: Box<Fault>,
}

/// Where a fault is.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The file, or what stands for it in memory.
    pub file: File,
    /// Data row, counted from 1, the header left out.
    pub row: Option<usize>,
    /// Column of a table.
    pub column: Option<String>,
    /// Key of `recording.toml`, as `wrench.precontact`.
    pub key: Option<String>,
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

impl Place {
    /// The table of episode `name`.
    pub fn episode(name: &str) -> Self {
        Self::file(File::Episode(name.to_owned()))
    }

    /// A key of `recording.toml`, as `wrench.precontact`; the whole file if `key` is empty.
    pub fn field(key: &str) -> Self {
        let key = (!key.is_empty()).then(|| key.to_owned());
        Self { key, ..Self::file(File::Metadata) }
    }

    /// A file or folder.
    pub fn path(path: &Path) -> Self {
        Self::file(File::Path(path.to_owned()))
    }

    /// The same place, at data row `row`, counted from 1.
    #[must_use]
    pub fn row(self, row: usize) -> Self {
        Self { row: Some(row), ..self }
    }

    /// The same place, in column `name`.
    #[must_use]
    pub fn column(self, name: &str) -> Self {
        Self { column: Some(name.to_owned()), ..self }
    }

    fn file(file: File) -> Self {
        Self { file, row: None, column: None, key: None }
    }
}

impl Error {
    /// The same error with the file's place on disk, where `path_of` knows it.
    pub(crate) fn on_disk(mut self, path_of: impl FnOnce(&File) -> Option<PathBuf>) -> Self {
        if let Some(path) = path_of(&self.place.file) {
            self.place.file = File::Path(path);
        }
        self
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            File::Metadata => write!(f, "recording.toml")?,
            File::Episode(name) => write!(f, "episode {}", Shown(name))?,
            File::Path(path) => write!(f, "{}", Shown(&path.to_string_lossy()))?,
        }
        if let Some(row) = self.row {
            write!(f, ", row {row}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ", column {}", Shown(column))?;
        }
        if let Some(key) = &self.key {
            write!(f, ", {}", Shown(key))?;
        }
        Ok(())
    }
}

/// A text from outside, with control characters escaped.
pub(crate) struct Shown<'a>(pub &'a str);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|c| match c.is_control() {
            true => write!(f, "{}", c.escape_default()),
            false => write!(f, "{c}"),
        })
    }
}
