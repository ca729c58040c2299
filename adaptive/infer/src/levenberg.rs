//! Levenberg–Marquardt on a cost with Gauss-Newton curvature.
//!
//! ```text
//! (H + λ diag(H)) δ = −g;   λ falls when the cost does, rises when not      (Marquardt 1963)
//! ```

use crate::likelihood::Look;
use crate::search::Optimum;
use crate::{Density, InferError, Linearised, Watch};
use nalgebra::DVector;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop {
    /// At most this many linearisations.
    pub iterations: usize,
    /// When an accepted step lowers the cost by less.
    pub decrease: f64,
    /// Whether the gradient is measured by differences where the given one leads no further down.
    pub measure_gradient: bool,
}

/// Minimise −log density from `start`.
pub(crate) fn minimise(
    density: &dyn Density,
    start: Vec<f64>,
    clamp: impl Fn(usize, f64) -> f64,
    stop: Stop,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let at = density.linearise(&start)?;
    from(density, start, at, clamp, stop, watch)
}

/// The same where the start is linearised already.
///
/// The gradient may be approximate, as that of the filter is, which leaves out how gains and covariances depend on the
/// parameters. Where it leads no further down, its error is measured. Later steps are corrected by the same error until one
/// of them leads no further down either.
pub(crate) fn from(
    density: &dyn Density,
    start: Vec<f64>,
    start_at: Linearised,
    clamp: impl Fn(usize, f64) -> f64,
    stop: Stop,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let search = Search { density, clamp: &clamp, stop, watch };
    let (mut point, mut at) = (start, start_at);
    let (mut damping, mut falling) = (1e-3, f64::INFINITY);
    let mut correction = DVector::zeros(point.len());
    for _ in 0..stop.iterations {
        let (begun, approximate) = (damping, at.gradient.clone());
        at.gradient += &correction;
        let trusted = if stop.measure_gradient { TRUSTED_ATTEMPTS } else { ATTEMPTS };
        let mut outcome = search.descend(&point, &at, &mut damping, trusted)?;
        if stop.measure_gradient && !matches!(outcome, Outcome::Lower { .. }) {
            at.gradient = measured_gradient(density, &point, &at)?;
            (correction, damping) = (&at.gradient - approximate, begun);
            outcome = search.descend(&point, &at, &mut damping, ATTEMPTS)?;
        }
        let Outcome::Lower { trial, decrease, look } = outcome else {
            return Ok(Optimum { point, at, converged: true, falling: 0.0 });
        };
        (point, falling) = (trial, decrease);
        at = look.linearise()?;
        if decrease < stop.decrease {
            return Ok(Optimum { point, at, converged: true, falling });
        }
    }
    Ok(Optimum { point, at, converged: false, falling })
}

/// Steps tried from a point, at most, and before the gradient is measured.
const ATTEMPTS: usize = 8;
const TRUSTED_ATTEMPTS: usize = 2;

/// Factors on the damping after a step that did not lower the cost, and after one that did.
const DAMPING_RISE: f64 = 6.0;
const DAMPING_FALL: f64 = 8.0;

/// What a search minimises, and when it stops.
struct Search<'a, C> {
    density: &'a dyn Density,
    clamp: &'a C,
    stop: Stop,
    watch: &'a dyn Watch,
}

/// Where the steps from a point lead.
enum Outcome<'a> {
    /// To a lower cost.
    Lower { trial: Vec<f64>, decrease: f64, look: Look<'a> },
    /// To none.
    NoDescent,
    /// The parabola promises no decrease that counts.
    AtOptimum,
}

impl<'a, C: Fn(usize, f64) -> f64> Search<'a, C> {
    /// Try steps with more and more damping until one lowers the cost.
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
                if attempt == 0 && promised(at, &step) < NOTHING * self.stop.decrease {
                    return Ok(Outcome::AtOptimum);
                }
                let moved = point.iter().zip(step.iter()).enumerate();
                let trial: Vec<f64> = moved.map(|(k, (p, s))| (self.clamp)(k, p + s)).collect();
                // The first attempt mostly succeeds, and then its derivatives are needed as well.
                let look = self.density.look(&trial, attempt == 0)?;
                if look.cost < at.cost {
                    *damping = (*damping / DAMPING_FALL).max(1e-9);
                    return Ok(Outcome::Lower { trial, decrease: at.cost - look.cost, look });
                }
            }
            *damping *= DAMPING_RISE;
        }
        Ok(Outcome::NoDescent)
    }
}

/// Step of a difference, standard deviations by the curvature.
const DIFFERENCE: f64 = 0.01;

/// The gradient by forward differences, less what the curvature adds over the step.
fn measured_gradient(
    density: &dyn Density,
    point: &[f64],
    at: &Linearised,
) -> Result<DVector<f64>, InferError> {
    let mut gradient = at.gradient.clone();
    for (k, slope) in gradient.iter_mut().enumerate() {
        let curvature = at.curvature[(k, k)];
        let h = DIFFERENCE / curvature.max(1.0).sqrt();
        let mut shifted = point.to_vec();
        shifted[k] += h;
        let measured = (density.cost(&shifted)? - at.cost) / h - 0.5 * curvature * h;
        if measured.is_finite() {
            *slope = measured;
        }
    }
    Ok(gradient)
}

/// Share of the decrease that counts below which a step is not tried.
const NOTHING: f64 = 0.1;

/// Decrease of the cost along a step, by its parabola.
fn promised(at: &Linearised, step: &DVector<f64>) -> f64 {
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

    /// Rosenbrock's valley as residuals (10 (y − x²), 1 − x).
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
    fn finds_the_end_of_rosenbrocks_valley() {
        let stop = Stop { iterations: 100, decrease: 1e-16, measure_gradient: false };
        let found = minimise(&Rosenbrock, vec![-1.2, 1.0], |_, x| x, stop, &Quiet).unwrap();
        assert!((found.point[0] - 1.0).abs() < 1e-6 && (found.point[1] - 1.0).abs() < 1e-6);
        assert!(found.converged);
    }

    /// A parabola about (3, −2) whose gradient is given as if it lay about the origin.
    struct Misled;

    impl Density for Misled {
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
    fn a_misleading_gradient_is_measured() {
        let end = |measure_gradient| {
            let stop = Stop { iterations: 60, decrease: 1e-9, measure_gradient };
            minimise(&Misled, vec![3.5, -2.5], |_, x| x, stop, &Quiet).unwrap().point
        };
        assert!(end(true).iter().zip([3.0, -2.0]).all(|(found, least)| (found - least).abs() < 1e-3));
        assert!((end(false)[1] + 2.0).abs() > 0.1);
    }
}
