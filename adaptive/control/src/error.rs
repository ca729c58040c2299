//! What can be wrong with a plan that is asked for.

use std::fmt::Debug;

/// Why there is no plan.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum ControlError {
    /// A setting or an argument that makes no sense.
    #[error("{key} = {value}: {remedy}")]
    Value {
        /// Name of the setting or argument.
        key: &'static str,
        /// As given.
        value: String,
        /// What to give instead.
        remedy: &'static str,
    },
    /// No sampled plan has a finite cost.
    #[error("none of the {samples} sampled plans keeps the motion finite: check the model's values")]
    Diverged {
        /// How many were tried.
        samples: usize,
    },
}

impl ControlError {
    pub(crate) fn value(key: &'static str, value: impl Debug, remedy: &'static str) -> Self {
        Self::Value { key, value: format!("{value:?}"), remedy }
    }
}
