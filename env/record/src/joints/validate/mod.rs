//! Validation of recordings of joints.

mod mechanism;
mod table;
mod values;

use super::files::check_files;
use super::metadata::{JOINT_FORMAT, JointMetadata};
use super::recording::JointRecording;
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::validate::{check_known_episode, check_names, check_training, is_printable};

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

/// Checks all values that do not depend on the tables and models.
pub(super) fn check_metadata(metadata: &JointMetadata) -> Result<(), Error> {
    check_header(&metadata.format, &metadata.name)?;
    mechanism::check(&metadata.mechanism)?;
    values::check(metadata)
}

fn check_header(format: &str, name: &str) -> Result<(), Error> {
    if format != JOINT_FORMAT {
        let remedy = "set format = \"trundle-recording/2\"";
        return refuse("format", format!("{format:?}"), "is not a supported format", remedy);
    }
    if !name.chars().all(is_printable) {
        let problem = "contains control or invisible characters";
        let remedy = "use one line of letters, digits, spaces and punctuation";
        return refuse("name", format!("{name:?}"), problem, remedy);
    }
    Ok(())
}

fn refuse(key: &str, value: String, problem: &'static str, remedy: &'static str) -> Result<(), Error> {
    Err(Fault::Value { value, problem, remedy }.at(Place::field(key)))
}
