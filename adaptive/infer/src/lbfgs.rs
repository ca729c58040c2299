//! L-BFGS, the paper's optimiser, with bounds (L-BFGS-B; Zhu et al. 1997, ACM TOMS 778), by the crate basin.
//!
//! It sees the cost and its gradient alone, not the Gauss-Newton curvature: it needs no least squares, and more
//! evaluations where there are some.

use crate::levenberg::Stop;
use crate::search::Optimum;
use crate::{Density, InferError, Watch};
use basin::{
    BoxBounds, ConstraintDescription, ConstraintSet, ConstraintSolveError, Constraints, CostFunction,
    Executor, FirstOrderState, Gradient, Lbfgsb, Termination,
};

/// Stands for an infinite cost: a line search cannot interpolate those.
const WALL: f64 = 1e12;

/// What basin sees of a density: coordinates stretched by the root of the curvature at the start, since without
/// that the first steps along well-known directions are too long, and along the others too short.
struct Problem<'a> {
    density: &'a dyn Density,
    stretch: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    watch: &'a dyn Watch,
}

impl Problem<'_> {
    /// The point whose stretched coordinates are `w`.
    fn point(&self, w: &[f64]) -> Vec<f64> {
        w.iter().zip(&self.stretch).map(|(w, s)| w / s).collect()
    }

    fn go_on(&self) -> Result<(), InferError> {
        if self.watch.cancelled() { Err(InferError::Interrupted) } else { Ok(()) }
    }
}

impl CostFunction for Problem<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = InferError;

    fn cost(&self, w: &Vec<f64>) -> Result<f64, InferError> {
        self.go_on()?;
        Ok(self.density.cost(&self.point(w))?.min(WALL))
    }
}

impl Gradient for Problem<'_> {
    type Gradient = Vec<f64>;

    fn gradient(&self, w: &Vec<f64>) -> Result<Vec<f64>, InferError> {
        Ok(self.cost_and_gradient(w)?.1)
    }

    fn cost_and_gradient(&self, w: &Vec<f64>) -> Result<(f64, Vec<f64>), InferError> {
        self.go_on()?;
        let at = self.density.linearise(&self.point(w))?;
        Ok((at.cost.min(WALL), at.gradient.iter().zip(&self.stretch).map(|(g, s)| g / s).collect()))
    }
}

impl Constraints for Problem<'_> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

/// Minimise −log density from `start`, within what `clamp` lets pass.
///
/// A search that comes to rest is begun anew there, stretched by the curvature of that place, until nothing is
/// gained: a line search fails early where the gradient is not exactly the cost's.
pub(crate) fn minimise(
    density: &dyn Density,
    start: Vec<f64>,
    clamp: impl Fn(usize, f64) -> f64,
    stop: Stop,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let at = density.linearise(&start)?;
    let mut best = Optimum { point: start, at, converged: false, falling: 0.0 };
    for _ in 0..RESTARTS {
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

/// One search, from a point and the curvature there.
fn search(
    density: &dyn Density,
    from: &Optimum,
    clamp: impl Fn(usize, f64) -> f64,
    stop: Stop,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let stretch: Vec<f64> = from.at.curvature.diagonal().iter().map(|c| c.max(1.0).sqrt()).collect();
    let bound = |far: f64| stretch.iter().enumerate().map(|(k, s)| clamp(k, far) * s).collect();
    let (lower, upper) = (bound(f64::NEG_INFINITY), bound(f64::INFINITY));
    let start = from.point.iter().zip(&stretch).map(|(z, s)| z * s).collect();
    let problem = Problem { density, stretch: stretch.clone(), lower, upper, watch };
    // basin's tolerance is relative to the cost.
    let size = from.at.cost.abs().clamp(1.0, WALL);
    let solver = Lbfgsb::new().with_relative_cost_reduction_tolerance(stop.decrease / size);
    let run =
        Executor::new(problem, solver, FirstOrderState::new(start)).max_iter(stop.iterations as u64).run();
    let result = run.map_err(|error| match error {
        ConstraintSolveError::Evaluation(error) => error,
        // Bounds around a start are in order; what is left is a start that is none.
        _ => InferError::NoStart { recording: "the recording".to_owned(), starts: 1 },
    })?;
    let converged = !matches!(result.report.termination, Termination::Limit(_));
    let point: Vec<f64> = result.best_param().iter().zip(&stretch).map(|(w, s)| w / s).collect();
    Ok(Optimum { at: density.linearise(&point)?, point, converged, falling: 0.0 })
}

/// Searches one after the other.
const RESTARTS: usize = 5;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levenberg::tests::Rosenbrock;
    use crate::{Linearised, Quiet};

    const STOP: Stop = Stop { iterations: 100, decrease: 1e-16, measure_gradient: false };

    #[test]
    fn finds_the_end_of_rosenbrocks_valley() {
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

    /// A density that is nowhere beyond x = 0, as a model that cannot be evaluated there.
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
    fn retreats_from_where_nothing_can_be_evaluated() {
        let found = minimise(&Cliff, vec![-2.2, 1.0], |_, x| x, STOP, &Quiet).unwrap();
        assert!((found.point[0] + 0.05).abs() < 1e-4, "{:?}", found.point);
    }
}
