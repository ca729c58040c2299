//! Errors of the planner.

use std::fmt::Debug;

/// Error of the planner.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum ControlError {
    /// A setting or an argument is out of its range.
    #[error("{key} = {value}: {remedy}")]
    Value {
        /// Name of the setting or argument.
        key: &'static str,
        /// The given value.
        value: String,
        /// Valid values.
        remedy: &'static str,
    },
    /// No sampled plan has a finite cost.
    #[error("none of the {samples} sampled plans keeps the motion finite: check the values of the model")]
    Diverged {
        /// Number of sampled plans.
        samples: usize,
    },
    /// The number of predicted states does not fit the sampled plans.
    #[error("{given} predicted states: must be a multiple of {expected}, a state for each step of each plan")]
    States {
        /// Number of states.
        given: usize,
        /// Number of states of one prediction.
        expected: usize,
    },
}

/// Error of [`crate::Planner::plan_in_batches`].
#[derive(Debug, PartialEq)]
pub enum BatchError<E> {
    /// Error of the planner.
    Planner(ControlError),
    /// Error of the simulator.
    Simulator(E),
}

impl<E> From<ControlError> for BatchError<E> {
    fn from(error: ControlError) -> Self {
        Self::Planner(error)
    }
}

impl ControlError {
    pub(crate) fn value(key: &'static str, value: impl Debug, remedy: &'static str) -> Self {
        Self::Value { key, value: format!("{value:?}"), remedy }
    }
}
