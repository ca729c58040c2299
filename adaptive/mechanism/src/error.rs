//! Errors of a diagnosis of joints.

use trundle_infer::InferError;

/// Why a recording of joints cannot be diagnosed.
#[derive(Debug, thiserror::Error)]
pub enum MechanismError {
    /// The recording does not have what a diagnosis needs.
    #[error("{recording}: {reason}; {remedy}")]
    Unsuitable {
        /// Name of the recording.
        recording: String,
        /// What is missing or wrong.
        reason: String,
        /// What to do.
        remedy: String,
    },
    /// Arrays of the dynamics do not fit the recording.
    #[error("dynamics of episode {episode}: {reason}")]
    Dynamics {
        /// Name of the episode.
        episode: String,
        /// What is wrong with the arrays.
        reason: String,
    },
    /// The user interrupted, or the estimation failed.
    #[error(transparent)]
    Infer(#[from] InferError),
}

impl MechanismError {
    /// Whether the user interrupted.
    #[must_use]
    pub fn is_interrupt(&self) -> bool {
        matches!(self, Self::Infer(InferError::Interrupted))
    }
}
