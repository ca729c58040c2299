//! Prediction of left-out parts of the training episodes.
//!
//! The equations are nearly linear in the parameters, so that the fit without a part is one step from the fit to all
//! parts (the one-step jackknife; Efron 1982).

use crate::fit::{Fit, bounded_step};
use crate::problem::Problem;
use crate::rows::{JointRows, Scope, evaluate, normal_equations, parts, weight};
use nalgebra::DVector;

/// Predicted residuals of every joint, in order of time within each fold.
#[derive(Clone, Debug)]
pub(crate) struct LeftOut {
    /// By joint, then by fold.
    pub residuals: Vec<Vec<Vec<f64>>>,
}

impl LeftOut {
    /// Mean of the robust squares of a joint's residuals. Residuals beyond the Huber limit count linearly.
    pub fn mean_square(&self, joint: usize, sd: f64) -> f64 {
        let all = || self.residuals[joint].iter().flatten();
        let count = all().count().max(1) as f64;
        all().map(|r| r * r * weight(*r, sd)).sum::<f64>() / count
    }
}

/// Number of folds.
pub(crate) fn folds(problem: &Problem) -> usize {
    problem.episodes.iter().filter(|e| !e.held_out).count() * parts(problem)
}

/// Residuals of every fold under the model fitted without it.
pub(crate) fn left_out(problem: &Problem, fit: &Fit) -> LeftOut {
    let rows = evaluate(problem, &fit.effects, &fit.slots, &fit.values, Scope::Training, true);
    let steps: Vec<Option<DVector<f64>>> =
        (0..folds(problem)).map(|fold| step_without(&rows, fit, fold)).collect();
    let mut residuals = vec![vec![vec![]; steps.len()]; problem.joints.len()];
    for own in &rows {
        for (fold, step) in steps.iter().enumerate() {
            let change = step.as_ref().map(|step| {
                let local = DVector::from_iterator(own.columns.len(), own.columns.iter().map(|k| step[*k]));
                &own.jacobian * local
            });
            for (row, _) in own.places.iter().enumerate().filter(|(_, place)| place.fold == fold) {
                let moved = change.as_ref().map_or(0.0, |change| change[row]);
                residuals[own.joint][fold].push(own.residual[row] + moved);
            }
        }
    }
    LeftOut { residuals }
}

fn step_without(rows: &[JointRows], fit: &Fit, fold: usize) -> Option<DVector<f64>> {
    let (matrix, right) =
        normal_equations(rows, &fit.sd, &fit.slots, &fit.values, &|place| place.fold != fold);
    bounded_step(&matrix, &right, &fit.slots, &fit.values, 0.0, &|_| true)
}
