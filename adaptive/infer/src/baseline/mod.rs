//! Section V-B of the paper: models learned from transitions, and the score that compares them.
//!
//! A [`Transition`] is one row of eq. 7 with the state that followed. [`Linear`] and [`Local`] are the
//! paper's baselines for `x' = f(x, u)`: linear and locally weighted regression. [`Plant`] is a physical
//! model with the same interface. [`r2`] scores all of them.

mod checks;
mod error;
mod features;
mod from_episode;
mod linear;
mod local;
mod predictor;
mod transitions;

pub(crate) use checks::check;
pub use error::BaselineError;
pub use features::Features;
pub use from_episode::transitions_of;
pub use linear::Linear;
pub use local::Local;
pub use predictor::{Predictor, StateVector};
pub use transitions::{Pushes, SigmaReading, Transition, hold, noisy, transitions};

use trundle_model::Plant;

/// A physical model with its values in place: [`trundle_model::Model::plant`] at the values of a fit.
impl Predictor for Plant<f64> {
    fn predict(&self, x: &StateVector, u: &[f64; 3], dt: f64) -> StateVector {
        hold(self, x, u, dt)
    }
}

/// Predicts a constant velocity: the score without any learning.
#[derive(Clone, Copy, Debug)]
pub struct ConstantVelocity;

impl Predictor for ConstantVelocity {
    fn predict(&self, x: &StateVector, _u: &[f64; 3], dt: f64) -> StateVector {
        let [px, py, heading, vx, vy, spin] = *x;
        [px + vx * dt, py + vy * dt, heading + spin * dt, vx, vy, spin]
    }
}

/// Coefficient of determination of predicted next states, the paper's r².
///
/// For each of the six channels of `x'`, it is `1 − Σ(x̂' − x')² / Σ(x' − mean x')²` over the test
/// transitions. The result is the mean over the channels that vary. This equals one pooled coefficient after
/// each channel is divided by its standard deviation over the test, so that metres and radians have equal
/// weight. Returns `NaN` if nothing varies, and minus infinity if a prediction is not finite.
pub fn r2(predictor: &(impl Predictor + ?Sized), test: &[Transition]) -> f64 {
    let predicted: Vec<_> = test.iter().map(|t| predictor.predict(&t.before, &t.wrench, t.dt)).collect();
    let after: Vec<_> = test.iter().map(|t| t.after).collect();
    r2_of(&predicted, &after)
}

/// [`r2`] of given predictions, one for each of `after`.
pub fn r2_of(predicted: &[StateVector], after: &[StateVector]) -> f64 {
    let mut channels = vec![];
    for k in 0..6 {
        let mean = after.iter().map(|x| x[k]).sum::<f64>() / after.len().max(1) as f64;
        let spread: f64 = after.iter().map(|x| (x[k] - mean).powi(2)).sum();
        let error: f64 = after.iter().zip(predicted).map(|(x, p)| (p[k] - x[k]).powi(2)).sum();
        if spread > 0.0 {
            channels.push(if error.is_finite() { 1.0 - error / spread } else { f64::NEG_INFINITY });
        }
    }
    channels.iter().sum::<f64>() / channels.len() as f64
}

#[cfg(test)]
mod tests;
