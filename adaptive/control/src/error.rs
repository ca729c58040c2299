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
}

impl ControlError {
    pub(crate) fn value(key: &'static str, value: impl Debug, remedy: &'static str) -> Self {
        Self::Value { key, value: format!("{value:?}"), remedy }
    }
}
