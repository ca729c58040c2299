//! A recording of either format.

use std::path::Path;

use toml::Value;

use crate::document::parse;
use crate::error::Error;
use crate::folder::Folder;
use crate::joints::{JOINT_FORMAT, JointRecording};
use crate::metadata::FORMAT;
use crate::recording::Recording;

/// A recording of a pushed object or of joints.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyRecording {
    /// A pushed object: `trundle-recording/1`.
    Object(Box<Recording>),
    /// A mechanism with joints: `trundle-recording/2`.
    Joints(Box<JointRecording>),
}

impl AnyRecording {
    /// Reads and validates the folder `path`, whichever format its `recording.toml` states.
    ///
    /// # Errors
    /// If a file cannot be read, or the recording is invalid.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let folder = Folder::open(path)?;
        let document = parse(&folder.text).map_err(|error| folder.locate(error))?;
        // A document without a known format is judged by its content, so that the error names its own keys.
        let has_joints = match document.get("format").and_then(Value::as_str) {
            Some(JOINT_FORMAT) => true,
            Some(FORMAT) => false,
            _ => document.contains_key("mechanism"),
        };
        match has_joints {
            true => JointRecording::from_folder(&folder).map(|found| Self::Joints(Box::new(found))),
            false => Recording::from_folder(&folder).map(|found| Self::Object(Box::new(found))),
        }
    }
}
