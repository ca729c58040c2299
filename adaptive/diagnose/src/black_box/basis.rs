//! Linearised simulator that a fit used.

use super::likelihood::PathLikelihood;
use std::sync::Arc;

/// Linearised simulator that a fit used.
#[derive(Clone)]
pub(crate) struct Basis {
    pub(super) likelihood: Arc<PathLikelihood>,
    /// Values of the simulator's parameters in the fit.
    pub(super) parameters: Vec<f64>,
    /// Whether missing effects bias these values, so that effects are not screened around them.
    pub(super) is_biased: bool,
}
