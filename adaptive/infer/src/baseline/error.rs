//! Errors of regressions and of their data.

use thiserror::Error;
use trundle_model::ModelError;

/// Errors of regressions and of their data.
#[derive(Debug, Error)]
pub enum BaselineError {
    /// The model is incomplete.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The data are empty.
    #[error("no transitions to learn from: give at least one")]
    Empty,
    /// A value is invalid.
    #[error("{name} = {value}: {remedy}")]
    Value {
        /// The argument, and the transition if it belongs to one.
        name: String,
        /// The given value.
        value: f64,
        /// What to give instead.
        remedy: &'static str,
    },
}
