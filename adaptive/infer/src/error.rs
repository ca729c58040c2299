//! Why an estimate cannot be given.

use thiserror::Error;
use trundle_model::ModelError;

/// Why an estimate cannot be given.
#[derive(Debug, Error)]
pub enum InferError {
    /// The model itself is wrong.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// There is nothing to compare the model with.
    #[error("{recording}: {reason}; {remedy}")]
    NoData {
        /// The recording.
        recording: String,
        /// What is missing.
        reason: String,
        /// What would help.
        remedy: String,
    },
    /// A parameter is named that is not estimated.
    #[error("'{name}' is not a free parameter of this model; free are: {free}")]
    NotFree {
        /// The name that was given.
        name: String,
        /// Those that exist.
        free: String,
    },
    /// No start led anywhere.
    #[error(
        "{recording}: the model cannot be evaluated anywhere near its prior \
         (the density was not finite at any of {starts} starts); check units and signs with `trundle check`"
    )]
    NoStart {
        /// The recording.
        recording: String,
        /// How many starts were tried.
        starts: usize,
    },
    /// A simulator that was handed in failed.
    #[error("{episode}, t = {t:.4} s: {reason}")]
    Step {
        /// The episode.
        episode: String,
        /// When in it, s.
        t: f64,
        /// What was wrong, with the value.
        reason: String,
    },
    /// The user stopped it.
    #[error("interrupted")]
    Interrupted,
}
