//! Levenberg–Marquardt minimisation with Gauss-Newton curvature.
//!
//! ```text
//! (H + λ diag(H)) δ = −g;   λ decreases after a decrease of the cost and increases otherwise      (Marquardt 1963)
//! ```

use crate::likelihood::Evaluation;
use crate::optimum::{Optimum, Stop};
use crate::{Density, InferError, Linearised, Watch};
use nalgebra::DVector;

/// Minimise −log density from `start`.
pub(crate) fn minimise(
    density: &dyn Density,
    start: Vec<f64>,
    clamp: impl Fn(usize, f64) -> f64,
    stop: Stop,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let at = density.linearise(&start)?;
    minimise_from(density, start, at, clamp, stop, watch)
}

/// Minimise from a start that is already linearised.
///
/// The gradient may be approximate: that of the filter neglects how gains and covariances depend on the
/// parameters. Where no step lowers the cost, the error of the gradient is measured by finite differences.
/// The same correction applies to later steps until it fails in turn.
pub(crate) fn minimise_from(
    density: &dyn Density,
    start: Vec<f64>,
    start_at: Linearised,
    clamp: impl Fn(usize, f64) -> f64,
    stop: Stop,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let search = Search { density, clamp: &clamp, stop, watch };
    let (mut point, mut at) = (start, start_at);
    let (mut damping, mut last_decrease) = (1e-3, f64::INFINITY);
    let mut correction = DVector::zeros(point.len());
    for _ in 0..stop.iterations {
        let (initial_damping, approximate) = (damping, at.gradient.clone());
        at.gradient += &correction;
        let trusted = if stop.measure_gradient { MAX_TRUSTED_ATTEMPTS } else { MAX_ATTEMPTS };
        let mut outcome = search.descend(&point, &at, &mut damping, trusted)?;
        if stop.measure_gradient && !matches!(outcome, Outcome::Lower { .. }) {
            at.gradient = measured_gradient(density, &point, &at)?;
            (correction, damping) = (&at.gradient - approximate, initial_damping);
            outcome = search.descend(&point, &at, &mut damping, MAX_ATTEMPTS)?;
        }
        let Outcome::Lower { trial, decrease, evaluation } = outcome else {
            return Ok(Optimum { point, at, converged: true, last_decrease: 0.0 });
        };
        (point, last_decrease) = (trial, decrease);
        at = evaluation.linearise()?;
        if decrease < stop.decrease {
            return Ok(Optimum { point, at, converged: true, last_decrease });
        }
    }
    Ok(Optimum { point, at, converged: false, last_decrease })
}

/// Maximum number of steps tried from a point, in all and before the gradient is measured.
const MAX_ATTEMPTS: usize = 8;
const MAX_TRUSTED_ATTEMPTS: usize = 2;

/// Factors on the damping after a rejected and after an accepted step.
const DAMPING_RISE: f64 = 6.0;
const DAMPING_FALL: f64 = 8.0;

/// Objective and stopping criteria of a search.
struct Search<'a, C> {
    density: &'a dyn Density,
    clamp: &'a C,
    stop: Stop,
    watch: &'a dyn Watch,
}

/// Result of the steps tried from a point.
enum Outcome<'a> {
    /// A step lowered the cost.
    Lower { trial: Vec<f64>, decrease: f64, evaluation: Evaluation<'a> },
    /// No step lowered the cost.
    NoDescent,
    /// The quadratic model predicts no significant decrease.
    AtOptimum,
}

impl<'a, C: Fn(usize, f64) -> f64> Search<'a, C> {
    /// Tries steps with increasing damping until one lowers the cost.
    fn descend(
        &self,
        point: &[f64],
        at: &Linearised,
        damping: &mut f64,
        attempts: usize,
    ) -> Result<Outcome<'a>, InferError> {
        for attempt in 0..attempts {
            if self.watch.cancelled() {
                return Err(InferError::Interrupted);
            }
            if let Some(step) = damped_step(at, *damping) {
                if attempt == 0 && predicted_decrease(at, &step) < MIN_PROMISED_SHARE * self.stop.decrease {
                    return Ok(Outcome::AtOptimum);
                }
                let moved = point.iter().zip(step.iter()).enumerate();
                let trial: Vec<f64> = moved.map(|(k, (p, s))| (self.clamp)(k, p + s)).collect();
                // The first attempt usually succeeds, and its derivatives are then required.
                let evaluation = self.density.evaluate(&trial, attempt == 0)?;
                if evaluation.cost < at.cost {
                    *damping = (*damping / DAMPING_FALL).max(1e-9);
                    return Ok(Outcome::Lower { trial, decrease: at.cost - evaluation.cost, evaluation });
                }
            }
            *damping *= DAMPING_RISE;
        }
        Ok(Outcome::NoDescent)
    }
}

/// Step of a finite difference, in standard deviations given by the curvature.
const DIFFERENCE_STEP_SD: f64 = 0.01;

/// Gradient by forward differences, corrected for the curvature over the step.
fn measured_gradient(
    density: &dyn Density,
    point: &[f64],
    at: &Linearised,
) -> Result<DVector<f64>, InferError> {
    let mut gradient = at.gradient.clone();
    for (k, slope) in gradient.iter_mut().enumerate() {
        let curvature = at.curvature[(k, k)];
        let h = DIFFERENCE_STEP_SD / curvature.max(1.0).sqrt();
        let mut shifted = point.to_vec();
        shifted[k] += h;
        let measured = (density.cost(&shifted)? - at.cost) / h - 0.5 * curvature * h;
        if measured.is_finite() {
            *slope = measured;
        }
    }
    Ok(gradient)
}

/// Share of the stopping decrease below which a predicted decrease is not tried.
const MIN_PROMISED_SHARE: f64 = 0.1;

/// Decrease of the cost along a step predicted by the quadratic model.
fn predicted_decrease(at: &Linearised, step: &DVector<f64>) -> f64 {
    -(at.gradient.dot(step) + 0.5 * step.dot(&(&at.curvature * step)))
}

fn damped_step(at: &Linearised, damping: f64) -> Option<DVector<f64>> {
    let mut system = at.curvature.clone();
    for k in 0..system.nrows() {
        system[(k, k)] += damping * system[(k, k)].max(1e-12);
    }
    let step = -system.cholesky()?.solve(&at.gradient);
    step.iter().all(|s| s.is_finite()).then_some(step)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::Quiet;
    use nalgebra::{DMatrix, dvector};

    /// Rosenbrock's function as residuals (10 (y − x²), 1 − x).
    pub(crate) struct Rosenbrock;

    impl Density for Rosenbrock {
        fn dimension(&self) -> usize {
            2
        }

        fn cost(&self, p: &[f64]) -> Result<f64, InferError> {
            Ok(self.linearise(p)?.cost)
        }

        fn linearise(&self, p: &[f64]) -> Result<Linearised, InferError> {
            let residual = dvector![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]];
            let jacobian = DMatrix::from_row_slice(2, 2, &[-20.0 * p[0], 10.0, -1.0, 0.0]);
            Ok(Linearised {
                cost: 0.5 * residual.norm_squared(),
                gradient: jacobian.tr_mul(&residual),
                curvature: jacobian.tr_mul(&jacobian),
            })
        }
    }

    #[test]
    fn finds_the_minimum_of_rosenbrock() {
        let stop = Stop { iterations: 100, decrease: 1e-16, measure_gradient: false };
        let found = minimise(&Rosenbrock, vec![-1.2, 1.0], |_, x| x, stop, &Quiet).unwrap();
        assert!((found.point[0] - 1.0).abs() < 1e-6 && (found.point[1] - 1.0).abs() < 1e-6);
        assert!(found.converged);
    }

    /// A parabola about (3, −2) with the gradient of a parabola about the origin.
    struct BiasedGradient;

    impl Density for BiasedGradient {
        fn dimension(&self) -> usize {
            2
        }

        fn cost(&self, p: &[f64]) -> Result<f64, InferError> {
            Ok(0.5 * ((p[0] - 3.0).powi(2) + 4.0 * (p[1] + 2.0).powi(2)))
        }

        fn linearise(&self, p: &[f64]) -> Result<Linearised, InferError> {
            let curvature = DMatrix::from_diagonal(&dvector![1.0, 4.0]);
            Ok(Linearised { cost: self.cost(p)?, gradient: dvector![p[0], 4.0 * p[1]], curvature })
        }
    }

    #[test]
    fn a_biased_gradient_is_measured() {
        let end = |measure_gradient| {
            let stop = Stop { iterations: 60, decrease: 1e-9, measure_gradient };
            minimise(&BiasedGradient, vec![3.5, -2.5], |_, x| x, stop, &Quiet).unwrap().point
        };
        assert!(end(true).iter().zip([3.0, -2.0]).all(|(found, least)| (found - least).abs() < 1e-3));
        assert!((end(false)[1] + 2.0).abs() > 0.1);
    }
}
