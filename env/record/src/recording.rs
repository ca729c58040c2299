//! A recording in memory, and reading it from its folder.

use std::path::Path;

use crate::episode::{Episode, check_title};
use crate::error::Error;
use crate::folder::Folder;
use crate::metadata::Metadata;

/// A recording: its metadata and its episodes in chronological order.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Content of `recording.toml`.
    pub metadata: Metadata,
    /// Episodes, sorted by name.
    pub episodes: Vec<Episode>,
}

impl Recording {
    /// Creates a recording of `episodes`, sorts them by name, and validates it.
    ///
    /// # Errors
    /// As [`Recording::validate`].
    pub fn new(metadata: Metadata, mut episodes: Vec<Episode>) -> Result<Self, Error> {
        episodes.sort_by(|a, b| a.name.cmp(&b.name));
        let recording = Self { metadata, episodes };
        recording.validate()?;
        Ok(recording)
    }

    /// Reads and validates the folder `path`: `recording.toml` and each `NAME.csv` or `NAME.parquet`. Ignores all other
    /// files, and files whose name begins with a dot.
    ///
    /// # Errors
    /// If a file cannot be read, or the recording is invalid (see [`Recording::validate`]).
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::from_folder(&Folder::open(path)?)
    }

    pub(crate) fn from_folder(folder: &Folder) -> Result<Self, Error> {
        let read = || Self::new(Metadata::from_toml(&folder.text)?, folder.episodes(&check_title)?);
        read().map_err(|error| folder.locate(error))
    }
}
