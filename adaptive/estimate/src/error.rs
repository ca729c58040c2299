//! Errors of estimation requests.

use thiserror::Error;
use trundle_infer::InferError;
use trundle_model::ModelError;
use trundle_posterior::PosteriorError;
use trundle_sim::SimError;

/// Errors of estimation requests.
#[derive(Debug, Error)]
pub enum EstimateError {
    /// The estimation failed, or the user interrupted it.
    #[error(transparent)]
    Infer(#[from] InferError),
    /// A model or a prior is invalid.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The sampling failed, or the user interrupted it.
    #[error(transparent)]
    Posterior(#[from] PosteriorError),
    /// The obstacles or the object cannot be simulated.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// There is no recording.
    #[error("no recording is given: name at least one")]
    NoRecording,
    /// Two recordings show different objects.
    #[error(
        "{first:?} and {second:?} show different objects: {property} is {of_first} in the first and {of_second} in the second; correct recording.toml, or fit the recordings separately"
    )]
    DifferentObjects {
        /// Name of the first recording.
        first: String,
        /// Name of the second recording.
        second: String,
        /// The property that differs.
        property: &'static str,
        /// Its value in the first recording.
        of_first: String,
        /// Its value in the second recording.
        of_second: String,
    },
    /// An argument is not one of the known names.
    #[error("{argument} = {value:?}: choose one of {known}")]
    UnknownName {
        /// Name of the argument.
        argument: &'static str,
        /// Its value.
        value: String,
        /// The known names.
        known: String,
    },
    /// The chosen likelihood supports neither obstacles nor a user's simulator.
    #[error(
        "likelihood = {likelihood:?} supports neither obstacles nor a simulator: choose \"windows\", \"steps\" or \"final\", or obstacles = false"
    )]
    NoSimulation {
        /// Name of the likelihood.
        likelihood: &'static str,
    },
    /// The filter supports normal residuals only.
    #[error(
        "loss = \"student\": the filter requires normal residuals; choose another likelihood, such as \"windows\""
    )]
    StudentFilter,
    /// A start names a parameter that is not free.
    #[error("start: `{name}` is not a free parameter; free are {free}")]
    NotFree {
        /// The given name.
        name: String,
        /// The free parameters.
        free: String,
    },
    /// A start has no value for a free parameter.
    #[error("start: `{name}` is missing; give a value to each of {free}")]
    NoStartValue {
        /// The missing parameter.
        name: String,
        /// The free parameters.
        free: String,
    },
}

impl EstimateError {
    /// Whether the user interrupted the work.
    pub fn is_interrupt(&self) -> bool {
        match self {
            Self::Infer(error) => matches!(error, InferError::Interrupted),
            Self::Posterior(error) => error.is_interrupt(),
            _ => false,
        }
    }
}
