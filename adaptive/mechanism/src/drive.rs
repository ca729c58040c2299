//! What drives a joint.

use crate::error::MechanismError;
use trundle_record::{EffortSource, JointRecording};

/// What drives a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// Nothing.
    None,
    /// A recorded effort.
    Effort(EffortSource),
    /// A position target.
    Target,
}

impl Drive {
    /// Whether its record is a command, which is held until the next one.
    pub(crate) fn is_held(self) -> bool {
        matches!(self, Self::Target | Self::Effort(EffortSource::Commanded | EffortSource::Voltage))
    }

    /// What drives a joint, by its columns.
    ///
    /// # Errors
    /// If its effort has no sign and it has no target, or an episode has no samples of its drive.
    pub(crate) fn of(recording: &JointRecording, joint: &str) -> Result<Self, MechanismError> {
        let has = |stream: &str| recording.episodes.iter().any(|e| e.joint_stream(stream, joint).is_some());
        let missing = |stream: &str| {
            recording
                .episodes
                .iter()
                .find(|e| e.joint_stream(stream, joint).is_none())
                .map(|e| e.name.clone())
        };
        let first = recording.episodes.first().map_or("", |episode| episode.name.as_str());
        let settings = recording.metadata.effort_of(first, joint);
        let (found, stream) = match (has("effort"), has("target"), settings.signed) {
            (true, _, true) => (Self::Effort(settings.source), "effort"),
            (_, true, _) => (Self::Target, "target"),
            (true, false, false) => {
                return Err(MechanismError::Unsuitable {
                    recording: recording.metadata.name.clone(),
                    reason: format!(
                        "effort_{joint} has no sign (signed = false), and there is no target_{joint}, so that \
                         the direction of the drive's effort is unknown"
                    ),
                    remedy: format!("record a signed effort, or the commanded positions as target_{joint}"),
                });
            }
            (false, false, _) => return Ok(Self::None),
        };
        match missing(stream) {
            None => Ok(found),
            Some(episode) => Err(MechanismError::Unsuitable {
                recording: recording.metadata.name.clone(),
                reason: format!("episode {episode} has no samples of {stream}_{joint}, other episodes have"),
                remedy: "remove the episode, or record the stream in all episodes".to_owned(),
            }),
        }
    }
}
