//! The factor on a noise that suits a recording best, by Brent's method (1973) of the crate basin.

use crate::InferError;
use basin::{
    BoxBounds, Brent, ConstraintDescription, ConstraintSet, ConstraintSolveError, Constraints, CostFunction,
    Executor, PointState,
};

/// Stands for an infinite cost: a parabola cannot go through one.
const WALL: f64 = 1e12;
/// How closely the logarithm of a factor is found, and evaluations at most. A factor that is off by 3 % costs a
/// thousandth of a nat per sample.
const CLOSE: f64 = 0.015;
const EVALUATIONS: u64 = 20;

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
        Ok((self.cost)(logarithm.exp())?.min(WALL))
    }
}

impl Constraints for Problem<'_> {
    type Set = ConstraintSet<BoxBounds<f64>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

/// The factor in a range around one that minimises a cost.
pub(crate) fn best_factor(
    cost: &dyn Fn(f64) -> Result<f64, InferError>,
    (low, high): (f64, f64),
) -> Result<f64, InferError> {
    let problem = Problem { cost, lower: low.ln(), upper: high.ln() };
    let solver = Brent::new().with_absolute_position_tolerance(CLOSE);
    let run = Executor::new(problem, solver, PointState::new(0.0)).max_iter(EVALUATIONS).run();
    let found = run.map_err(|error| match error {
        ConstraintSolveError::Evaluation(error) => error,
        // Bounds around one are in order; what is left is a cost that is nowhere.
        _ => InferError::NoStart { recording: "the recording".to_owned(), starts: 1 },
    })?;
    Ok(found.best_param().exp())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::best_factor;
    use std::cell::Cell;

    /// Cost of a noise of `true_factor` times what is assumed, with so many samples, and how often it was asked.
    fn found(true_factor: f64) -> (f64, usize) {
        let asked = Cell::new(0);
        let cost = |f: f64| {
            asked.set(asked.get() + 1);
            Ok(1000.0 * (f.ln() + 0.5 * (true_factor / f).powi(2)))
        };
        (best_factor(&cost, (0.02, 50.0)).unwrap(), asked.get())
    }

    #[test]
    fn finds_a_factor_to_three_per_cent_in_few_evaluations() {
        for truth in [0.1, 0.8, 1.0, 1.3, 20.0] {
            let (factor, asked) = found(truth);
            assert!((factor / truth - 1.0).abs() < 0.03 && asked < 21, "{truth}: {factor} after {asked}");
        }
    }

    #[test]
    fn goes_to_the_end_of_the_range_where_the_cost_falls() {
        assert!(best_factor(&|f| Ok(f), (0.3, 3.0)).unwrap() < 0.33);
        assert!(best_factor(&|f| Ok(if f < 1.0 { f64::INFINITY } else { -f }), (0.3, 3.0)).unwrap() > 2.7);
    }
}
