//! One mode of the posterior, updated with each push.

use super::quadratic::Quadratic;
use crate::coordinates::clamp_to_prior;
use crate::{Coordinates, InferError, Likelihood};
use nalgebra::{DMatrix, DVector};
use trundle_model::Model;

/// Data shared by all hypotheses.
pub(super) struct Setting<'a> {
    pub model: &'a Model,
    pub coordinates: &'a Coordinates,
}

impl Setting<'_> {
    pub fn expand(&self, likelihood: &dyn Likelihood, z: &DVector<f64>) -> Result<Quadratic, InferError> {
        Quadratic::of(likelihood, self.model, self.coordinates, z)
    }

    /// `z` limited to the searched range.
    fn clamped(&self, z: DVector<f64>) -> DVector<f64> {
        DVector::from_fn(z.len(), |k, _| clamp_to_prior(z[k], self.coordinates.slot(k)))
    }
}

/// A mode, and the expansion of each push near it.
#[derive(Clone, Debug)]
pub(super) struct Hypothesis {
    pub z: DVector<f64>,
    /// Expansions of the retained pushes, in the order of [`super::Online`].
    pub terms: Vec<Quadratic>,
    /// Sum of the expansions of all other pushes.
    pub past: Quadratic,
    /// −log posterior density at `z`, not normalised.
    pub cost: f64,
    /// Curvature of the cost at `z`.
    pub precision: DMatrix<f64>,
}

impl Hypothesis {
    pub fn at(z: DVector<f64>) -> Self {
        let n = z.len();
        Self { z, terms: vec![], past: Quadratic::zero(n), cost: 0.0, precision: DMatrix::identity(n, n) }
    }

    /// Prior and all terms, expanded at `z`.
    fn prior_and_terms(&self, setting: &Setting<'_>, z: &DVector<f64>) -> Quadratic {
        let mut sum = Quadratic::of_prior(setting.coordinates, z);
        self.terms.iter().chain([&self.past]).for_each(|term| sum.add(term));
        sum
    }

    /// Moves the mode to include one more push, with at most `steps` linearisations of the push after the
    /// first. Returns the expansion of the push at the new mode; the term is not yet added.
    pub fn add_push(
        &mut self,
        setting: &Setting<'_>,
        push: &dyn Likelihood,
        steps: usize,
    ) -> Result<Quadratic, InferError> {
        const MIN_DECREASE_NATS: f64 = 0.05;
        let mut term = setting.expand(push, &self.z)?;
        let mut sum = self.prior_and_terms(setting, &self.z);
        sum.add(&term);
        let mut damping = 1e-6;
        for _ in 0..steps {
            let Some((step, predicted)) = newton(&sum, damping) else { break };
            if predicted < MIN_DECREASE_NATS {
                break;
            }
            let z = setting.clamped(&self.z + step);
            let trial = setting.expand(push, &z)?;
            let mut there = self.prior_and_terms(setting, &z);
            there.add(&trial);
            if there.cost < sum.cost {
                (self.z, term, sum) = (z, trial, there);
                damping = (damping / 10.0).max(1e-9);
            } else {
                damping = (damping * 100.0).max(1e-2);
            }
        }
        (self.cost, self.precision) = (sum.cost, sum.curvature);
        Ok(term)
    }

    /// Moves the mode to the minimum of the prior and all terms, without linearising a push.
    pub fn minimise(&mut self, setting: &Setting<'_>) {
        let mut sum = self.prior_and_terms(setting, &self.z);
        if let Some((step, _)) = newton(&sum, 0.0) {
            let z = setting.clamped(&self.z + step);
            let there = self.prior_and_terms(setting, &z);
            if there.cost < sum.cost {
                (self.z, sum) = (z, there);
            }
        }
        (self.cost, self.precision) = (sum.cost, sum.curvature);
    }

    /// −log of its share of the posterior, by Laplace's approximation.
    pub fn evidence_cost(&self) -> f64 {
        let half =
            self.precision.clone().cholesky().map(|c| c.l().diagonal().iter().map(|d| d.ln()).sum::<f64>());
        self.cost + half.unwrap_or(0.0)
    }

    /// Whether another hypothesis is the same mode: closer than the uncertainty.
    pub fn is_same(&self, other: &Self) -> bool {
        let d = &self.z - &other.z;
        d.dot(&(&self.precision * &d)) < self.z.len() as f64
    }
}

/// A damped Newton step and the decrease that it predicts.
fn newton(sum: &Quadratic, damping: f64) -> Option<(DVector<f64>, f64)> {
    let mut system = sum.curvature.clone();
    for k in 0..system.nrows() {
        system[(k, k)] += damping * system[(k, k)] + 1e-9;
    }
    let step = -system.cholesky()?.solve(&sum.gradient);
    let predicted = -0.5 * sum.gradient.dot(&step);
    step.iter().all(|s| s.is_finite()).then_some((step, predicted))
}
