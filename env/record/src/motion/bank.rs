//! Causal filter: a bank of Kalman filters, one per jerk intensity, weighted by their recent predictive likelihood.
//!
//! A single maximum-likelihood intensity would depend on the whole episode, and therefore on future samples.

use super::intensity::grid;
use super::kalman::{Axis, Estimate};
use super::symmetric::Symmetric;

/// Time constant with which past predictions lose their weight, s. A push starts within a fraction of it.
const FORGETTING_TIME_S: f64 = 1.0;

/// Filters of different jerk intensities over the same samples.
pub(crate) struct Bank {
    jerk: Vec<f64>,
    state: Vec<Estimate>,
    score: Vec<f64>,
}

impl Bank {
    /// The mixture estimate after each sample.
    pub fn run(axis: &Axis) -> Vec<Estimate> {
        let jerk: Vec<f64> = grid().map(|exponent| 10f64.powf(exponent)).collect();
        let mut bank = Self { state: vec![axis.start(); jerk.len()], score: vec![0.0; jerk.len()], jerk };
        (0..axis.t.len()).map(|i| bank.step(axis, i)).collect()
    }

    fn step(&mut self, axis: &Axis, i: usize) -> Estimate {
        let forget = if i == 0 { 1.0 } else { (-(axis.t[i] - axis.t[i - 1]) / FORGETTING_TIME_S).exp() };
        for (k, jerk) in self.jerk.iter().enumerate() {
            let predicted = if i == 0 { self.state[k] } else { axis.predict(i, &self.state[k], *jerk) };
            let update = axis.update(i, predicted);
            self.score[k] = forget * self.score[k] + update.log_likelihood();
            self.state[k] = update.posterior();
        }
        self.mixture()
    }

    fn mixture(&self) -> Estimate {
        let best = self.score.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weight: Vec<f64> = self.score.iter().map(|s| (s - best).exp()).collect();
        let total: f64 = weight.iter().sum();
        let parts = || self.state.iter().zip(&weight).map(|(state, w)| (state, w / total));
        let mean = [0, 1, 2].map(|k| parts().map(|(state, w)| state.mean[k] * w).sum());
        let cov = parts().fold(Symmetric::default(), |sum, (state, w)| {
            let deviation = [0, 1, 2].map(|k| state.mean[k] - mean[k]);
            sum.add_scaled(&state.cov, w).add_scaled(&Symmetric::outer_product(deviation), w)
        });
        Estimate { mean, cov }
    }
}
