//! Validation of recordings of joints.

mod mechanism;
mod metadata;
mod refuse;
mod table;
mod values;

use super::files::check_files;
use super::recording::JointRecording;
use crate::error::Error;
use crate::validate::{check_known_episode, check_names, check_training};
pub(super) use metadata::check_metadata;

impl JointRecording {
    /// Checks metadata, tables and models against the format.
    ///
    /// # Errors
    /// The first fault found, with its file, row, column, value and remedy.
    pub fn validate(&self) -> Result<(), Error> {
        let metadata = &self.metadata;
        check_metadata(metadata)?;
        check_names(&self.episodes)?;
        for name in metadata.episode.keys() {
            check_known_episode(&self.episodes, name, &format!("episode.{name}"))?;
        }
        check_training(&self.episodes, &metadata.split)?;
        check_files(metadata, &self.files)?;
        self.episodes.iter().try_for_each(|episode| table::check(episode, metadata))
    }
}
