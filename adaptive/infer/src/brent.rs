//! Optimal factor on a noise level, by Brent's method (1973) from the crate basin.

use crate::InferError;
use basin::{
    BoxBounds, Brent, ConstraintDescription, ConstraintSet, ConstraintSolveError, Constraints, CostFunction,
    Executor, PointState,
};

/// Finite substitute for an infinite cost, because a parabola cannot interpolate infinities.
const MAX_COST: f64 = 1e12;
/// Tolerance of the logarithm of a factor, and maximum number of evaluations. An error of 3 % costs a
/// thousandth of a nat per sample.
const LOG_FACTOR_TOLERANCE: f64 = 0.015;
const MAX_EVALUATIONS: u64 = 20;

struct Problem<'a> {
    cost: &'a dyn Fn(f64) -> Result<f64, InferError>,
    lower: f64,
    upper: f64,
}

impl CostFunction for Problem<'_> {
    type Param = f64;
    type Output = f64;
    type Error = InferError;

    fn cost(&self, logarithm: &f64) -> Result<f64, InferError> {
        Ok((self.cost)(logarithm.exp())?.min(MAX_COST))
    }
}

impl Constraints for Problem<'_> {
    type Set = ConstraintSet<BoxBounds<f64>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

/// Factor within a range around one that minimises a cost.
pub(crate) fn best_factor(
    cost: &dyn Fn(f64) -> Result<f64, InferError>,
    (low, high): (f64, f64),
) -> Result<f64, InferError> {
    let problem = Problem { cost, lower: low.ln(), upper: high.ln() };
    let solver = Brent::new().with_absolute_position_tolerance(LOG_FACTOR_TOLERANCE);
    let run = Executor::new(problem, solver, PointState::new(0.0)).max_iter(MAX_EVALUATIONS).run();
    let found = run.map_err(|error| match error {
        ConstraintSolveError::Evaluation(error) => error,
        // The bounds contain one, so any other error means a cost that is never finite.
        _ => InferError::NoStart { recording: "the recording".to_owned(), starts: 1 },
    })?;
    Ok(found.best_param().exp())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::best_factor;
    use std::cell::Cell;

    /// Estimated factor of 1000 samples whose noise is `true_factor` times the assumed one, and the number of
    /// evaluations.
    fn found(true_factor: f64) -> (f64, usize) {
        let evaluations = Cell::new(0);
        let cost = |f: f64| {
            evaluations.set(evaluations.get() + 1);
            Ok(1000.0 * (f.ln() + 0.5 * (true_factor / f).powi(2)))
        };
        (best_factor(&cost, (0.02, 50.0)).unwrap(), evaluations.get())
    }

    #[test]
    fn finds_a_factor_to_three_per_cent_in_few_evaluations() {
        for truth in [0.1, 0.8, 1.0, 1.3, 20.0] {
            let (factor, evaluations) = found(truth);
            assert!(
                (factor / truth - 1.0).abs() < 0.03 && evaluations < 21,
                "{truth}: {factor} after {evaluations}"
            );
        }
    }

    #[test]
    fn goes_to_the_bound_of_a_monotone_cost() {
        assert!(best_factor(&|f| Ok(f), (0.3, 3.0)).unwrap() < 0.33);
        assert!(best_factor(&|f| Ok(if f < 1.0 { f64::INFINITY } else { -f }), (0.3, 3.0)).unwrap() > 2.7);
    }
}
