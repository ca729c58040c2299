//! L-BFGS with bounds, the optimiser of the paper (L-BFGS-B; Zhu et al. 1997, ACM TOMS 778), from the crate
//! basin.
//!
//! It uses the cost and its gradient but not the Gauss-Newton curvature. It applies to any cost, and requires
//! more evaluations than Levenberg–Marquardt on least squares.

use crate::optimum::{Optimum, Stop};
use crate::{Density, InferError, Watch};
use basin::{
    BoxBounds, ConstraintDescription, ConstraintSet, ConstraintSolveError, Constraints, CostFunction,
    Executor, FirstOrderState, Gradient, Lbfgsb, Termination,
};

/// Finite substitute for an infinite cost, because a line search cannot interpolate infinities.
const MAX_COST: f64 = 1e12;

/// A density as seen by basin. Coordinates are scaled by the root of the curvature at the start; otherwise
/// the first steps are too long along well-determined directions and too short along the others.
struct Problem<'a> {
    density: &'a dyn Density,
    scale: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    watch: &'a dyn Watch,
}

impl Problem<'_> {
    /// Point with the scaled coordinates `w`.
    fn point(&self, w: &[f64]) -> Vec<f64> {
        w.iter().zip(&self.scale).map(|(w, s)| w / s).collect()
    }

    fn check_cancelled(&self) -> Result<(), InferError> {
        if self.watch.cancelled() { Err(InferError::Interrupted) } else { Ok(()) }
    }
}

impl CostFunction for Problem<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = InferError;

    fn cost(&self, w: &Vec<f64>) -> Result<f64, InferError> {
        self.check_cancelled()?;
        Ok(self.density.cost(&self.point(w))?.min(MAX_COST))
    }
}

impl Gradient for Problem<'_> {
    type Gradient = Vec<f64>;

    fn gradient(&self, w: &Vec<f64>) -> Result<Vec<f64>, InferError> {
        Ok(self.cost_and_gradient(w)?.1)
    }

    fn cost_and_gradient(&self, w: &Vec<f64>) -> Result<(f64, Vec<f64>), InferError> {
        self.check_cancelled()?;
        let at = self.density.linearise(&self.point(w))?;
        Ok((at.cost.min(MAX_COST), at.gradient.iter().zip(&self.scale).map(|(g, s)| g / s).collect()))
    }
}

impl Constraints for Problem<'_> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

/// Minimise −log density from `start` within the bounds given by `clamp`.
///
/// A line search ends early where the gradient is not exactly that of the cost. The search is therefore
/// restarted from its end, scaled by the curvature there, until the cost no longer decreases.
pub(crate) fn minimise(
    density: &dyn Density,
    start: Vec<f64>,
    clamp: impl Fn(usize, f64) -> f64,
    stop: Stop,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let at = density.linearise(&start)?;
    let mut best = Optimum { point: start, at, converged: false, last_decrease: 0.0 };
    for _ in 0..MAX_SEARCHES {
        let found = search(density, &best, &clamp, stop, watch)?;
        let gain = best.at.cost - found.at.cost;
        if gain > 0.0 {
            best = found;
        }
        if gain < stop.decrease {
            best.converged = true;
            break;
        }
    }
    Ok(best)
}

/// One search from a point, scaled by the curvature there.
fn search(
    density: &dyn Density,
    from: &Optimum,
    clamp: impl Fn(usize, f64) -> f64,
    stop: Stop,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let scale: Vec<f64> = from.at.curvature.diagonal().iter().map(|c| c.max(1.0).sqrt()).collect();
    let bound = |far: f64| scale.iter().enumerate().map(|(k, s)| clamp(k, far) * s).collect();
    let (lower, upper) = (bound(f64::NEG_INFINITY), bound(f64::INFINITY));
    let start = from.point.iter().zip(&scale).map(|(z, s)| z * s).collect();
    let problem = Problem { density, scale: scale.clone(), lower, upper, watch };
    // The tolerance of basin is relative to the cost.
    let size = from.at.cost.abs().clamp(1.0, MAX_COST);
    let solver = Lbfgsb::new().with_relative_cost_reduction_tolerance(stop.decrease / size);
    let run =
        Executor::new(problem, solver, FirstOrderState::new(start)).max_iter(stop.iterations as u64).run();
    let result = run.map_err(|error| match error {
        ConstraintSolveError::Evaluation(error) => error,
        // The bounds contain the start, so any other error means an invalid start.
        _ => InferError::NoStart { recording: "the recording".to_owned(), starts: 1 },
    })?;
    let converged = !matches!(result.report.termination, Termination::Limit(_));
    let point: Vec<f64> = result.best_param().iter().zip(&scale).map(|(w, s)| w / s).collect();
    Ok(Optimum { at: density.linearise(&point)?, point, converged, last_decrease: 0.0 })
}

/// Maximum number of successive searches.
const MAX_SEARCHES: usize = 5;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levenberg::tests::Rosenbrock;
    use crate::{Linearised, Quiet};

    const STOP: Stop = Stop { iterations: 100, decrease: 1e-16, measure_gradient: false };

    #[test]
    fn finds_the_minimum_of_rosenbrock() {
        let found = minimise(&Rosenbrock, vec![-1.2, 1.0], |_, x| x, STOP, &Quiet).unwrap();
        assert!(
            (found.point[0] - 1.0).abs() < 1e-5 && (found.point[1] - 1.0).abs() < 1e-5,
            "{:?}",
            found.point
        );
        assert!(found.converged);
    }

    #[test]
    fn stays_within_bounds() {
        let found = minimise(&Rosenbrock, vec![-1.2, 1.0], |_, x| x.clamp(-2.0, 0.5), STOP, &Quiet).unwrap();
        assert!(
            (found.point[0] - 0.5).abs() < 1e-9 && (found.point[1] - 0.25).abs() < 1e-5,
            "{:?}",
            found.point
        );
    }

    /// A density that is not finite for x > 0.
    struct Cliff;

    impl Density for Cliff {
        fn dimension(&self) -> usize {
            2
        }

        fn cost(&self, p: &[f64]) -> Result<f64, InferError> {
            Ok(self.linearise(p)?.cost)
        }

        fn linearise(&self, p: &[f64]) -> Result<Linearised, InferError> {
            let mut at = Rosenbrock.linearise(&[p[0] + 1.05, p[1]])?;
            if p[0] > 0.0 {
                at.cost = f64::INFINITY;
                at.gradient.fill(0.0);
            }
            Ok(at)
        }
    }

    #[test]
    fn steps_back_from_an_infinite_cost() {
        let found = minimise(&Cliff, vec![-2.2, 1.0], |_, x| x, STOP, &Quiet).unwrap();
        assert!((found.point[0] + 0.05).abs() < 1e-4, "{:?}", found.point);
    }
}
