//! How far apart two models are on a push: what is left of their difference when the second has absorbed all it can.
//!
//! Under the first model a push gives the poses `y`. The second predicts them one by one, and its whitened errors are
//! `r(z)` at its parameters `z`, which have come from `z₀` with the precision `Λ` of earlier data and priors. The
//! separation is the log-likelihood ratio to be expected against the best refit,
//!
//! ```text
//! D = min_z ½|r(z)|² + ½ (z − z₀)ᵀ Λ (z − z₀) ≈ ½|r|² − ½ gᵀ (JᵀJ + Λ)⁻¹ g,   g = Jᵀ r
//! ```
//! (Box and Hill 1967; Atkinson and Fedorov 1975, "T-optimality"). The second form projects the columns of `J` out of
//! `r`: what the second model could absorb does not count. It adds up over pushes.

use super::bench::Instruments;
use super::rival::{Rival, inverse};
use nalgebra::{DMatrix, DVector};
use trundle_infer::{Channels, Coordinates, Fit, InferError, Likelihood, MotionLikelihood};
use trundle_model::Model;
use trundle_record::{Noise, Prepared};

/// Half the squared errors of a model on some pushes, to second order in its parameters.
#[derive(Clone, Debug)]
pub(super) struct Quadratic {
    misfit: f64,
    gradient: DVector<f64>,
    curvature: DMatrix<f64>,
}

impl Quadratic {
    /// No push at all.
    pub fn none(rival: &Rival) -> Self {
        let n = rival.free().len();
        Self { misfit: 0.0, gradient: DVector::zeros(n), curvature: DMatrix::zeros(n, n) }
    }

    /// Of `rival` at `point` on episodes; `None` where it cannot be evaluated.
    pub fn of(
        rival: &Rival,
        point: &DVector<f64>,
        episodes: &[Prepared],
        noise: &Noise,
    ) -> Result<Option<Self>, InferError> {
        let likelihood = MotionLikelihood::new(episodes, noise)?.with_channels(Channels::of(noise));
        let (values, slopes) = rival.values(point);
        let Some(misfit) = misfit(&likelihood, rival, &values)? else { return Ok(None) };
        let at = likelihood.linearise(rival.model(), &values, rival.free())?;
        let n = slopes.len();
        let gradient = DVector::from_fn(n, |k, _| at.gradient[k] * slopes[k]);
        let curvature = DMatrix::from_fn(n, n, |i, j| at.curvature[(i, j)] * slopes[i] * slopes[j]);
        let finite = misfit.is_finite() && gradient.iter().chain(&curvature).all(|v| v.is_finite());
        Ok(finite.then_some(Self { misfit, gradient, curvature }))
    }

    /// Of both sets of pushes together.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            misfit: self.misfit + other.misfit,
            gradient: &self.gradient + &other.gradient,
            curvature: &self.curvature + &other.curvature,
        }
    }

    /// What a refit within `precision` leaves, nats, and the step to it.
    fn refitted(&self, precision: &DMatrix<f64>) -> (f64, DVector<f64>) {
        match (&self.curvature + precision).cholesky() {
            Some(factor) => {
                let step = -factor.solve(&self.gradient);
                ((self.misfit + 0.5 * self.gradient.dot(&step)).max(0.0), step)
            }
            None => (self.misfit, DVector::zeros(self.gradient.len())),
        }
    }

    /// What a refit of `rival` leaves, nats.
    pub fn separation(&self, rival: &Rival) -> f64 {
        self.refitted(rival.precision()).0
    }
}

/// What a refit of a fitted model within what is known of it leaves of half its squared errors `misfit`, nats; `None` where
/// the fit is not one of `model`, whose free parameters are those of the fit.
pub(crate) fn unabsorbed(
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
    Ok(Some(Quadratic { misfit, gradient, curvature }.refitted(&inverse(fit.spread.clone())).0))
}

/// Half the sum of the squared whitened errors.
fn misfit(likelihood: &MotionLikelihood, rival: &Rival, values: &[f64]) -> Result<Option<f64>, InferError> {
    let innovations = likelihood.innovations(rival.model(), values)?;
    let half = |i: &trundle_infer::Innovation| 0.5 * (i.whitener * i.error).norm_squared();
    Ok(innovations.map(|all| all.iter().flatten().map(half).sum()))
}

/// Steps of a refit that is not taken as linear, and halvings of each.
const STEPS: usize = 12;
const HALVINGS: usize = 4;

/// The separation with `rival` truly refitted to `episodes`: Gauss-Newton steps, each halved until it helps.
pub(super) fn refit(
    rival: &Rival,
    episodes: &[Prepared],
    instruments: &Instruments,
) -> Result<f64, InferError> {
    let noise = &instruments.noise;
    let likelihood = MotionLikelihood::new(episodes, noise)?.with_channels(Channels::of(noise));
    let penalty = |point: &DVector<f64>| {
        let away = point - rival.point();
        0.5 * away.dot(&(rival.precision() * &away))
    };
    let cost = |point: &DVector<f64>| -> Result<f64, InferError> {
        let misfit = misfit(&likelihood, rival, &rival.values(point).0)?;
        Ok(misfit.map_or(f64::INFINITY, |m| m + penalty(point)))
    };
    let mut point = rival.point().clone();
    let mut best = cost(&point)?;
    for _ in 0..STEPS {
        let Some(mut local) = Quadratic::of(rival, &point, episodes, noise)? else { break };
        local.misfit = best;
        local.gradient += rival.precision() * (&point - rival.point());
        let step = local.refitted(rival.precision()).1;
        let before = best;
        for halving in 0..HALVINGS {
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
    fn what_a_parameter_could_absorb_does_not_count() {
        // r = (3, 4), one column along (1, 0): the first component is absorbed but for what the prior costs.
        let quadratic = Quadratic {
            misfit: 12.5,
            gradient: DVector::from_vec(vec![300.0]),
            curvature: DMatrix::from_element(1, 1, 1e4),
        };
        let left = |precision: f64| quadratic.refitted(&DMatrix::from_element(1, 1, precision)).0;
        assert!((left(1e-9) - 8.0).abs() < 1e-6);
        assert!((left(1e12) - 12.5).abs() < 1e-6);
        // Half of the first component's 4.5 nats where prior and push know as much.
        assert!((left(1e4) - 10.25).abs() < 1e-6);
    }
}
