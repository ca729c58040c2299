//! Errors of estimation.

use thiserror::Error;
use trundle_model::ModelError;

/// Errors of estimation.
#[derive(Debug, Error)]
pub enum InferError {
    /// The model is invalid.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The data are insufficient for the comparison.
    #[error("{recording}: {reason}; {remedy}")]
    NoData {
        /// The recording or episode.
        recording: String,
        /// What is missing.
        reason: String,
        /// What to do.
        remedy: String,
    },
    /// A named parameter is not estimated.
    #[error("'{name}' is not a free parameter of this model; free parameters: {free}")]
    NotFree {
        /// The given name.
        name: String,
        /// The free parameters.
        free: String,
    },
    /// No start led anywhere.
    #[error(
        "{recording}: the density is not finite at any of {starts} starts drawn from the prior; \
         check units and signs with `trundle check`"
    )]
    /// The density was not finite at any start.
    NoStart {
        /// The recording.
        recording: String,
        /// Number of starts.
        starts: usize,
    },
    /// A user-supplied simulator failed.
    #[error("{episode}, t = {t:.4} s: {reason}")]
    Step {
        /// The episode.
        episode: String,
        /// Time in the episode, s.
        t: f64,
        /// The cause, with the value.
        reason: String,
    },
    /// The user interrupted the work.
    #[error("interrupted")]
    Interrupted,
}
