//! Expected log-likelihood ratio of two models along a planned motion, after a refit of the model that is not true.
//!
//! The true model gives the recorded effort. The residual of the other model in standard deviations is r(z), its
//! parameters z have the value z₀ and the precision Λ from the recording and the priors. Then
//!
//! ```text
//! D = min_z ½|r(z)|² + ½ (z − z₀)ᵀ Λ (z − z₀)
//! ```
//! as for pushes (Atkinson and Fedorov 1975, "T-optimality", with a prior).

use crate::fit::{Fit, bounded_step, moved};
use crate::problem::Problem;
use crate::rows::{JointRows, Scope, evaluate};
use nalgebra::{DMatrix, DVector};

/// Most Gauss–Newton steps of a refit. The equations are nearly linear.
const MAX_STEPS: usize = 4;
/// Relative decrease of the misfit at which a refit ends.
const MIN_DECREASE: f64 = 1e-3;
/// Largest root mean square of the true model's residual, standard deviations, at which its command counts as found.
const MAX_TRUE_RESIDUAL_SDS: f64 = 1.0;

/// Misfit of `other` in nats after a refit, where `plan` has the commands of `truth`, for standard deviations of the
/// joints' samples. `None` if no command makes the true mechanism follow the motion.
pub(super) fn misfit_after_refit(
    plan: &Problem,
    [truth, other]: [&Fit; 2],
    noise: &[f64],
    information: &DMatrix<f64>,
) -> Option<f64> {
    let rest = rows(plan, truth, &truth.values, false);
    if !is_followed(&rest, noise) {
        return None;
    }
    let Fit { slots, values: start, .. } = other;
    let residual = |rows: &[JointRows]| -> Vec<DVector<f64>> {
        let one = |(own, rest): (&JointRows, &JointRows)| (&own.residual - &rest.residual) / noise[own.joint];
        rows.iter().zip(&rest).map(one).collect()
    };
    let misfit = |rows: &[JointRows], values: &[f64]| {
        let change = change(start, values);
        0.5 * residual(rows).iter().map(DVector::norm_squared).sum::<f64>()
            + 0.5 * change.dot(&(information * &change))
    };
    let mut values = start.clone();
    let mut found = misfit(&rows(plan, other, &values, false), &values);
    for _ in 0..MAX_STEPS {
        let at = rows(plan, other, &values, true);
        let mut matrix = information.clone();
        let mut right = -(information * change(start, &values));
        for (own, residual) in at.iter().zip(residual(&at)) {
            let jacobian = &own.jacobian / noise[own.joint];
            let (square, slope) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&residual));
            for (a, &i) in own.columns.iter().enumerate() {
                right[i] -= slope[a];
                own.columns.iter().enumerate().for_each(|(b, &k)| matrix[(i, k)] += square[(a, b)]);
            }
        }
        let Some(step) = bounded_step(&matrix, &right, slots, &values, 0.0, &|_| true) else { break };
        let next = moved(slots, &values, &step);
        let lower = misfit(&rows(plan, other, &next, false), &next);
        if lower.is_nan() || lower >= found {
            break;
        }
        let is_small = lower > (1.0 - MIN_DECREASE) * found;
        (values, found) = (next, lower);
        if is_small {
            break;
        }
    }
    found.is_finite().then_some(found)
}

fn rows(plan: &Problem, fit: &Fit, values: &[f64], with_derivatives: bool) -> Vec<JointRows> {
    evaluate(plan, &fit.effects, &fit.slots, values, Scope::Training, with_derivatives)
}

fn change(start: &[f64], values: &[f64]) -> DVector<f64> {
    DVector::from_iterator(start.len(), values.iter().zip(start).map(|(new, old)| new - old))
}

fn is_followed(rest: &[JointRows], noise: &[f64]) -> bool {
    rest.iter().all(|own| {
        let count = own.residual.len().max(1) as f64;
        (own.residual.norm_squared() / count).sqrt() <= MAX_TRUE_RESIDUAL_SDS * noise[own.joint]
    })
}
