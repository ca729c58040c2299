//! Levenberg–Marquardt on a cost with Gauss-Newton curvature.
//!
//! ```text
//! (H + λ diag(H)) δ = −g;   λ falls when the cost does, rises when not      (Marquardt 1963)
//! ```

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
pub(crate) fn from(
    density: &dyn Density,
    start: Vec<f64>,
    start_at: Linearised,
    clamp: impl Fn(usize, f64) -> f64,
    stop: Stop,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    const ATTEMPTS: usize = 8;
    let (mut point, mut at) = (start, start_at);
    let (mut damping, mut falling) = (1e-3, f64::INFINITY);
    for _ in 0..stop.iterations {
        let mut accepted = None;
        for attempt in 0..ATTEMPTS {
            if watch.cancelled() {
                return Err(InferError::Interrupted);
            }
            if let Some(step) = damped_step(&at, damping) {
                // Where even the parabola promises nothing there is nothing to look for.
                if attempt == 0 && promised(&at, &step) < NOTHING * stop.decrease {
                    return Ok(Optimum { point, at, converged: true, falling: 0.0 });
                }
                let trial: Vec<f64> =
                    point.iter().zip(step.iter()).enumerate().map(|(k, (p, s))| clamp(k, p + s)).collect();
                // The first attempt mostly succeeds, and then its derivatives are needed as well.
                let look = density.look(&trial, attempt == 0)?;
                if look.cost < at.cost {
                    accepted = Some((trial, at.cost - look.cost, look));
                    damping = (damping / 8.0).max(1e-9);
                    break;
                }
            }
            damping *= 6.0;
        }
        let Some((trial, decrease, look)) = accepted else {
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
        let stop = Stop { iterations: 100, decrease: 1e-16 };
        let found = minimise(&Rosenbrock, vec![-1.2, 1.0], |_, x| x, stop, &Quiet).unwrap();
        assert!((found.point[0] - 1.0).abs() < 1e-6 && (found.point[1] - 1.0).abs() < 1e-6);
        assert!(found.converged);
    }
}
