//! A parameter of the nominal model.

use serde::Serialize;

/// A parameter of the nominal model.
#[derive(Clone, Debug, Serialize)]
pub struct Parameter {
    /// Posterior mean; null if not identifiable.
    pub mean: Option<f64>,
    /// Posterior standard deviation; null if not identifiable.
    pub sd: Option<f64>,
    /// SI unit.
    pub unit: &'static str,
    /// Whether the data identify it.
    pub identifiable: bool,
}
