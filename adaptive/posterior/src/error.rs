//! Why a posterior cannot be given.

use thiserror::Error;
use trundle_infer::InferError;

/// Why a posterior cannot be given.
#[derive(Debug, Error)]
pub enum PosteriorError {
    /// The fit before it, or the density itself, failed.
    #[error(transparent)]
    Infer(#[from] InferError),
    /// A setting makes no sense.
    #[error("{what} = {value}: {remedy}")]
    Setting {
        /// Its name.
        what: &'static str,
        /// What was given.
        value: String,
        /// What to give.
        remedy: &'static str,
    },
    /// Every parameter of the model has a value.
    #[error("no parameter of the model is free: leave out of model.toml the values that are to be sampled")]
    NothingFree,
    /// The sampler found no way on.
    #[error("chain {chain}: {reason}; try --method metropolis, or more --warmup")]
    Chain {
        /// Index of the chain.
        chain: usize,
        /// What the sampler says.
        reason: String,
    },
    /// A file of a calibration cannot be used.
    #[error("{what}: {reason}")]
    Config {
        /// The part of the file.
        what: String,
        /// What is wrong, and what to do.
        reason: String,
    },
}

impl PosteriorError {
    /// Whether the user asked it to stop.
    pub fn is_interrupt(&self) -> bool {
        matches!(self, Self::Infer(InferError::Interrupted))
    }
}
