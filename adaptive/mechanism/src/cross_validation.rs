//! Prediction of left-out parts of the training episodes.
//!
//! The equations are nearly linear in the parameters, so that the fit without a part is one step from the fit to all
//! parts (the one-step jackknife; Efron 1982).
//!
//! A drive may saturate, or a joint meet a stop, in one part only. The other parts then tell nothing about the limit, and no
//! model could predict the part. Such a part is divided further, into blocks that are left out one at a time. Other laws act
//! everywhere: if only one part shows an effect, its cause is something else in this part.

use crate::fit::{Fit, bounded_step, variances};
use crate::model::Role;
use crate::problem::Problem;
use crate::rows::{JointRows, Place, Scope, evaluate, normal_equations, parts, weight};
use nalgebra::DVector;

/// Factor of a limit's variance without a fold from which on the fold alone determines it. It is 2 if two folds determine it
/// equally.
const MIN_VARIANCE_FACTOR: f64 = 10.0;
/// Compared samples of a block; neighbouring samples are nearly independent.
const SAMPLES_PER_BLOCK: usize = 5;

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
    let limits = limits(fit);
    let known = if limits.is_empty() { vec![] } else { known_with(&rows, fit, &|_| true) };
    let mut residuals = vec![vec![]; problem.joints.len()];
    for fold in 0..folds(problem) {
        let found = left_out_of(problem, fit, &rows, fold, (&limits, &known));
        residuals.iter_mut().zip(found).for_each(|(all, own)| all.push(own));
    }
    LeftOut { residuals }
}

/// Residuals of one fold by joint.
fn left_out_of(
    problem: &Problem,
    fit: &Fit,
    rows: &[JointRows],
    fold: usize,
    limits: (&[usize], &[f64]),
) -> Vec<Vec<f64>> {
    let is_alone = determines_alone(rows, fit, fold, limits);
    let block = |place: &Place| if is_alone { block(problem, place) } else { 0 };
    let all = || rows.iter().flat_map(|own| &own.places).filter(|place| place.fold == fold);
    let first = all().map(block).min().unwrap_or(0);
    let count = all().map(block).max().map_or(0, |last| last + 1 - first);
    let steps: Vec<Option<DVector<f64>>> = (0..count)
        .map(|k| step_without(rows, fit, &|place| place.fold == fold && block(place) == first + k))
        .collect();
    let mut residuals = vec![vec![]; problem.joints.len()];
    for own in rows {
        for (row, place) in own.places.iter().enumerate().filter(|(_, place)| place.fold == fold) {
            let change = |step: &DVector<f64>| -> f64 {
                let columns = own.columns.iter().enumerate();
                columns.map(|(column, k)| own.jacobian[(row, column)] * step[*k]).sum()
            };
            let moved = steps[block(place) - first].as_ref().map_or(0.0, change);
            residuals[own.joint].push(own.residual[row] + moved);
        }
    }
    residuals
}

/// Number of a place's block in its episode.
fn block(problem: &Problem, place: &Place) -> usize {
    let episode = &problem.episodes[place.episode];
    place.sample / (SAMPLES_PER_BLOCK * episode.spacing)
}

/// Slots of parameters beyond which laws act.
fn limits(fit: &Fit) -> Vec<usize> {
    let is_limit = |k: &usize| match fit.slots[*k].role {
        Role::Effect(effect, param) => fit.effects[effect].kind.params()[param].is_limit,
        Role::Nominal(_) => false,
    };
    (0..fit.slots.len()).filter(is_limit).collect()
}

/// Whether one fold alone determines one of the limits. `known` are the variances with all folds.
fn determines_alone(rows: &[JointRows], fit: &Fit, fold: usize, (limits, known): (&[usize], &[f64])) -> bool {
    if limits.is_empty() || known.is_empty() {
        return false;
    }
    let without = known_with(rows, fit, &|place| place.fold != fold);
    limits.iter().any(|&k| without.get(k).is_none_or(|variance| *variance > MIN_VARIANCE_FACTOR * known[k]))
}

/// Variances of all parameters given the rows that `keep` selects.
fn known_with(rows: &[JointRows], fit: &Fit, keep: &dyn Fn(&Place) -> bool) -> Vec<f64> {
    let (precision, _) = normal_equations(rows, &fit.sd, &fit.slots, &fit.values, keep);
    variances(&precision).unwrap_or_default()
}

fn step_without(rows: &[JointRows], fit: &Fit, is_left_out: &dyn Fn(&Place) -> bool) -> Option<DVector<f64>> {
    let (matrix, right) =
        normal_equations(rows, &fit.sd, &fit.slots, &fit.values, &|place| !is_left_out(place));
    bounded_step(&matrix, &right, &fit.slots, &fit.values, 0.0, &|_| true)
}
