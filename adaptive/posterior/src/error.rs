//! Errors of sampling.

use thiserror::Error;
use trundle_infer::InferError;

/// Errors of sampling and calibration.
#[derive(Debug, Error)]
pub enum PosteriorError {
    /// The fit or the density failed.
    #[error(transparent)]
    Infer(#[from] InferError),
    /// A setting is invalid.
    #[error("{what} = {value}: {remedy}")]
    Setting {
        /// Name of the setting.
        what: &'static str,
        /// The given value.
        value: String,
        /// Valid values.
        remedy: &'static str,
    },
    /// There is no sampling method of this name.
    #[error("method = {name:?}: choose one of {known}")]
    UnknownMethod {
        /// The given name.
        name: String,
        /// The known names.
        known: String,
    },
    /// All parameters of the model have fixed values.
    #[error("no parameter of the model is free: remove the values to be sampled from model.toml")]
    NothingFree,
    /// The sampler failed.
    #[error("chain {chain}: {reason}; try --method metropolis, or increase --warmup")]
    Chain {
        /// Index of the chain.
        chain: usize,
        /// The sampler's message.
        reason: String,
    },
    /// A calibration file or a posterior is invalid.
    #[error("{what}: {reason}")]
    Config {
        /// The part of the file.
        what: String,
        /// What is wrong, and what to do.
        reason: String,
    },
}

impl PosteriorError {
    /// Whether the user interrupted the work.
    pub fn is_interrupt(&self) -> bool {
        matches!(self, Self::Infer(InferError::Interrupted))
    }
}
