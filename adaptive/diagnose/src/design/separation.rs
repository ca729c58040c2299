//! Expected separation of two models by a push, after a refit of the second model.
//!
//! Under the first model a push gives the poses `y`. The second model predicts them one by one with the whitened
//! errors `r(z)` at its parameters `z`. Earlier data and priors give `z` the mean `z₀` and the precision `Λ`. The
//! separation is the expected log-likelihood ratio against the best refit,
//!
//! ```text
//! D = min_z ½|r(z)|² + ½ (z − z₀)ᵀ Λ (z − z₀) ≈ ½|r|² − ½ gᵀ (JᵀJ + Λ)⁻¹ g,   g = Jᵀ r
//! ```
//! (Box and Hill 1967; Atkinson and Fedorov 1975, "T-optimality"). The second form projects the columns of `J`
//! out of `r`: differences that the second model can absorb do not count. The quadratic forms of several pushes
//! add up.

use super::competing_model::{CompetingModel, inverse};
use super::setup::Instruments;
use nalgebra::{DMatrix, DVector};
use trundle_infer::{Channels, Coordinates, Fit, InferError, Likelihood, MotionLikelihood};
use trundle_model::Model;
use trundle_record::{Noise, Prepared};

/// Half the squared errors of a model on some pushes, to second order in its parameters.
#[derive(Clone, Debug)]
pub(super) struct QuadraticMisfit {
    misfit: f64,
    gradient: DVector<f64>,
    curvature: DMatrix<f64>,
}

impl QuadraticMisfit {
    /// The misfit without any push.
    pub fn none(model: &CompetingModel) -> Self {
        let n = model.free().len();
        Self { misfit: 0.0, gradient: DVector::zeros(n), curvature: DMatrix::zeros(n, n) }
    }

    /// The misfit of `model` at `point` to some episodes; `None` if it cannot be evaluated.
    pub fn evaluate(
        model: &CompetingModel,
        point: &DVector<f64>,
        episodes: &[Prepared],
        noise: &Noise,
    ) -> Result<Option<Self>, InferError> {
        let likelihood = MotionLikelihood::new(episodes, noise)?.with_channels(Channels::of(noise));
        let (values, slopes) = model.values(point);
        let Some(misfit) = misfit(&likelihood, model, &values)? else { return Ok(None) };
        let at = likelihood.linearise(model.model(), &values, model.free())?;
        let n = slopes.len();
        let gradient = DVector::from_fn(n, |k, _| at.gradient[k] * slopes[k]);
        let curvature = DMatrix::from_fn(n, n, |i, j| at.curvature[(i, j)] * slopes[i] * slopes[j]);
        let finite = misfit.is_finite() && gradient.iter().chain(&curvature).all(|v| v.is_finite());
        Ok(finite.then_some(Self { misfit, gradient, curvature }))
    }

    /// The misfit to both sets of pushes.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            misfit: self.misfit + other.misfit,
            gradient: &self.gradient + &other.gradient,
            curvature: &self.curvature + &other.curvature,
        }
    }

    /// Misfit after a refit within `precision`, nats, and the step of the refit.
    fn after_refit(&self, precision: &DMatrix<f64>) -> (f64, DVector<f64>) {
        match (&self.curvature + precision).cholesky() {
            Some(factor) => {
                let step = -factor.solve(&self.gradient);
                ((self.misfit + 0.5 * self.gradient.dot(&step)).max(0.0), step)
            }
            None => (self.misfit, DVector::zeros(self.gradient.len())),
        }
    }

    /// Misfit after a refit of `model`, nats.
    pub fn separation(&self, model: &CompetingModel) -> f64 {
        self.after_refit(model.precision()).0
    }
}

/// Misfit of a fitted model after a refit within its posterior, nats; `misfit` is half its squared errors before.
/// `None` if the fit does not belong to `model`, whose free parameters must be those of the fit.
pub(crate) fn misfit_after_refit(
    likelihood: &dyn Likelihood,
    model: &Model,
    fit: &Fit,
    misfit: f64,
) -> Result<Option<f64>, InferError> {
    let slots = model.slots().into_iter().chain(likelihood.noise());
    let coordinates = Coordinates::of(slots.collect()).with_footprint(model);
    let n = coordinates.free().len();
    if n != fit.point.len() {
        return Ok(None);
    }
    let (values, slopes) = coordinates.values(&fit.point);
    let at = likelihood.linearise(model, &values, coordinates.free())?;
    let gradient = DVector::from_fn(n, |k, _| at.gradient[k] * slopes[k]);
    let curvature = DMatrix::from_fn(n, n, |i, j| at.curvature[(i, j)] * slopes[i] * slopes[j]);
    Ok(Some(QuadraticMisfit { misfit, gradient, curvature }.after_refit(&inverse(fit.spread.clone())).0))
}

/// Half the sum of the squared whitened errors.
fn misfit(
    likelihood: &MotionLikelihood,
    model: &CompetingModel,
    values: &[f64],
) -> Result<Option<f64>, InferError> {
    let innovations = likelihood.innovations(model.model(), values)?;
    let half = |i: &trundle_infer::Innovation| 0.5 * (i.whitener * i.error).norm_squared();
    Ok(innovations.map(|all| all.iter().flatten().map(half).sum()))
}

/// Maximum numbers of Gauss–Newton steps of a nonlinear refit, and of halvings of each.
const MAX_GAUSS_NEWTON_STEPS: usize = 12;
const MAX_STEP_HALVINGS: usize = 4;

/// The separation with a nonlinear refit of `model` to `episodes`: Gauss–Newton steps, each halved until the cost
/// decreases.
pub(super) fn refit(
    model: &CompetingModel,
    episodes: &[Prepared],
    instruments: &Instruments,
) -> Result<f64, InferError> {
    let noise = &instruments.noise;
    let likelihood = MotionLikelihood::new(episodes, noise)?.with_channels(Channels::of(noise));
    let penalty = |point: &DVector<f64>| {
        let departure = point - model.point();
        0.5 * departure.dot(&(model.precision() * &departure))
    };
    let cost = |point: &DVector<f64>| -> Result<f64, InferError> {
        let misfit = misfit(&likelihood, model, &model.values(point).0)?;
        Ok(misfit.map_or(f64::INFINITY, |m| m + penalty(point)))
    };
    let mut point = model.point().clone();
    let mut best = cost(&point)?;
    for _ in 0..MAX_GAUSS_NEWTON_STEPS {
        let Some(mut local) = QuadraticMisfit::evaluate(model, &point, episodes, noise)? else { break };
        local.misfit = best;
        local.gradient += model.precision() * (&point - model.point());
        let step = local.after_refit(model.precision()).1;
        let before = best;
        for halving in 0..MAX_STEP_HALVINGS {
            let trial = &point + &step * 0.5f64.powi(halving as i32);
            let reached = cost(&trial)?;
            if reached < best {
                (point, best) = (trial, reached);
                break;
            }
        }
        if before - best < 0.01 + 1e-3 * best {
            break;
        }
    }
    Ok(best.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refit_removes_what_a_parameter_can_absorb() {
        // With r = (3, 4) and one column along (1, 0), a refit absorbs the first component except for the prior's
        // cost.
        let quadratic = QuadraticMisfit {
            misfit: 12.5,
            gradient: DVector::from_vec(vec![300.0]),
            curvature: DMatrix::from_element(1, 1, 1e4),
        };
        let misfit = |precision: f64| quadratic.after_refit(&DMatrix::from_element(1, 1, precision)).0;
        assert!((misfit(1e-9) - 8.0).abs() < 1e-6);
        assert!((misfit(1e12) - 12.5).abs() < 1e-6);
        // With equal precision of prior and push, half of the first component's 4.5 nats remains.
        assert!((misfit(1e4) - 10.25).abs() < 1e-6);
    }
}
