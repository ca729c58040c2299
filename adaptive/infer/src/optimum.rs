//! End point and stopping criteria of a search.

use crate::Linearised;

/// End point of a search.
pub(crate) struct Optimum {
    pub point: Vec<f64>,
    pub at: Linearised,
    pub converged: bool,
    /// Decrease of the cost in the last step.
    pub last_decrease: f64,
}

/// Stopping criteria.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop {
    /// Maximum number of linearisations.
    pub iterations: usize,
    /// Stop when an accepted step lowers the cost by less.
    pub decrease: f64,
    /// Whether to measure the gradient by finite differences where the given one no longer leads to a
    /// decrease.
    pub measure_gradient: bool,
}

impl Stop {
    /// The same with the least decrease multiplied by `factor`.
    pub fn scaled(self, factor: f64) -> Self {
        Self { decrease: self.decrease * factor, ..self }
    }
}
