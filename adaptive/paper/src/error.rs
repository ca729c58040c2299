//! Errors of the experiments.

use thiserror::Error;
use trundle_infer::{BaselineError, InferError};
use trundle_sim::SimError;

/// Errors of the experiments.
#[derive(Debug, Error)]
pub enum PaperError {
    /// A fit failed, or the user interrupted it.
    #[error(transparent)]
    Infer(#[from] InferError),
    /// A regression failed.
    #[error(transparent)]
    Baseline(#[from] BaselineError),
    /// A simulation failed.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A model is incomplete.
    #[error(transparent)]
    Model(#[from] trundle_model::ModelError),
    /// An argument is not one of the known names.
    #[error("{name:?}: choose one of {known}")]
    UnknownName {
        /// The argument.
        name: String,
        /// The known names.
        known: &'static str,
    },
}

impl PaperError {
    /// Whether the user interrupted the work.
    pub fn is_interrupt(&self) -> bool {
        matches!(self, Self::Infer(InferError::Interrupted))
    }
}
