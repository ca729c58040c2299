//! Residuals of the joints' equations at the compared samples, with their derivatives, and the normal equations.

use crate::drive::Drive;
use crate::dynamics::InverseDynamics;
use crate::equation::JointModel;
use crate::link_motion::inverse_dynamics_at;
use crate::model::{Effect, Slot};
use crate::problem::{EpisodeData, Problem};
use crate::shared_parameters;
use nalgebra::{DMatrix, DVector};
use trundle_model::{Dual, Real};

/// Derivatives that one pass over the samples computes.
const WIDTH: usize = 8;
/// Residuals beyond this number of standard deviations count linearly (Huber 1964).
const HUBER_SDS: f64 = 3.0;
/// Standard deviation that filters and integrators leave in the best case, as a share of the effort.
const MIN_NUMERICAL_ERROR: f64 = 1e-3;
/// The same with a drive, whose effort is sampled. Sensors and motor constants are no better.
const MIN_DRIVE_ERROR: f64 = 3e-3;
/// Fewest folds of the cross-validation; fewer episodes are divided in time.
const MIN_FOLDS: usize = 6;

/// A compared sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub episode: usize,
    /// Index in the motion of the episode.
    pub sample: usize,
    /// Part of the cross-validation.
    pub fold: usize,
}

/// Residuals of one joint with their derivatives by its slots.
#[derive(Clone, Debug)]
pub(crate) struct JointRows {
    pub joint: usize,
    pub places: Vec<Place>,
    pub residual: DVector<f64>,
    /// Derivative of each residual by the effort on the joint. Residuals are weighted, see [`crate::rest`].
    pub per_effort: Vec<f64>,
    pub jacobian: DMatrix<f64>,
    /// Slots of the columns.
    pub columns: Vec<usize>,
}

/// Which equations are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scope {
    /// All joints in the training episodes.
    Training,
    /// All joints in the held-out episodes.
    HeldOut,
    /// One joint in the training episodes; the equations of the others are approximated, see [`crate::quadratic_cost`].
    Joint(usize),
}

/// Number of parts into which each training episode is divided, so that there are enough folds.
pub(crate) fn parts(problem: &Problem) -> usize {
    let training = problem.episodes.iter().filter(|e| !e.held_out).count();
    MIN_FOLDS.div_ceil(training.max(1))
}

/// Residuals and derivatives.
pub(crate) fn evaluate(
    problem: &Problem,
    effects: &[Effect],
    slots: &[Slot],
    values: &[f64],
    scope: Scope,
    with_derivatives: bool,
) -> Vec<JointRows> {
    let joints: Vec<usize> = match scope {
        Scope::Joint(j) => vec![j],
        _ => (0..problem.joints.len()).collect(),
    };
    joints
        .into_iter()
        .map(|j| joint_rows(problem, effects, slots, values, (j, scope), with_derivatives))
        .collect()
}

fn joint_rows(
    problem: &Problem,
    effects: &[Effect],
    slots: &[Slot],
    values: &[f64],
    (j, scope): (usize, Scope),
    with_derivatives: bool,
) -> JointRows {
    let own: Vec<usize> = (0..slots.len()).filter(|k| slots[*k].joint == Some(j)).collect();
    let shared: Vec<usize> = (0..slots.len()).filter(|k| slots[*k].joint.is_none()).collect();
    let passes: Vec<&[usize]> = match (with_derivatives, own.is_empty()) {
        (false, _) => vec![],
        (true, true) => vec![&[]],
        (true, false) => own.chunks(WIDTH).collect(),
    };
    let parts = parts(problem);
    let (mut places, mut residual, mut columns) = (vec![], vec![], vec![vec![]; own.len() + shared.len()]);
    let mut sizes = vec![];
    let wants_inertia =
        !JointModel::new(problem, j, effects, slots, |slot| values[slot]).is_linear_in_inverse_dynamics();
    let mut first_fold = 0;
    for (index, episode) in problem.episodes.iter().enumerate() {
        if episode.held_out != (scope == Scope::HeldOut) {
            continue;
        }
        let series = &episode.joints[j];
        let known = (effects, slots, values);
        let needed = inverse_dynamics_at(problem, episode, j, known, wants_inertia);
        let mut per_effort = vec![];
        if !with_derivatives {
            let model = JointModel::new(problem, j, effects, slots, |slot| values[slot]);
            let found = model.residual(problem, j, episode, needed.as_ref());
            let at = |k: &usize| series.weight[*k] * episode.kernel.at(&found.values, *k);
            residual.extend(series.kept.iter().map(at));
            per_effort = found.per_effort;
        }
        for (pass, chunk) in passes.iter().enumerate() {
            let variable = |slot: usize| match chunk.iter().position(|own| *own == slot) {
                Some(place) => Dual::<WIDTH>::variable(values[slot], place),
                None => Dual::lift(values[slot]),
            };
            let model = JointModel::new(problem, j, effects, slots, variable);
            let found = model.residual(problem, j, episode, needed.as_ref().map(|n| varied(n, &[])).as_ref());
            for k in &series.kept {
                let compared = episode.kernel.at(&found.values, *k);
                let weight = series.weight[*k];
                if pass == 0 {
                    residual.push(weight * compared.re);
                }
                for place in 0..chunk.len() {
                    columns[pass * WIDTH + place].push(weight * compared.eps[place]);
                }
            }
            per_effort = found.per_effort;
        }
        sizes.extend(series.kept.iter().map(|k| series.weight[*k] * per_effort[*k]));
        if let (Some(dynamics), Some(needed), true) = (&episode.dynamics, &needed, with_derivatives) {
            let slope = |slot: &usize| {
                shared_parameters::slope(problem, dynamics, j, &slots[*slot], known, wants_inertia)
            };
            let slopes: Vec<InverseDynamics<f64>> = shared.iter().map(slope).collect();
            let changes = if wants_inertia {
                changes_by_inverse_dynamics(problem, (j, episode), known, needed, &slopes)
            } else {
                let change = |slope: &InverseDynamics<f64>| {
                    slope.effort.iter().zip(&per_effort).map(|(slope, factor)| -slope * factor).collect()
                };
                slopes.iter().map(change).collect()
            };
            for (column, change) in columns[own.len()..].iter_mut().zip(changes) {
                column.extend(series.kept.iter().map(|k| series.weight[*k] * episode.kernel.at(&change, *k)));
            }
        }
        let len = series.q.len();
        places.extend(series.kept.iter().map(|k| Place {
            episode: index,
            sample: *k,
            fold: first_fold + k * parts / len.max(1),
        }));
        first_fold += parts;
    }
    let rows = residual.len();
    let jacobian = if with_derivatives {
        DMatrix::from_fn(rows, columns.len(), |row, column| columns[column][row])
    } else {
        DMatrix::zeros(0, 0)
    };
    let columns = own.into_iter().chain(shared).collect();
    JointRows {
        joint: j,
        places,
        residual: DVector::from_vec(residual),
        per_effort: sizes,
        jacobian,
        columns,
    }
}

/// Changes of a joint's residual with parameters that change what the links need by `slopes`, at every time of an episode.
fn changes_by_inverse_dynamics(
    problem: &Problem,
    (j, episode): (usize, &EpisodeData),
    (effects, slots, values): (&[Effect], &[Slot], &[f64]),
    needed: &InverseDynamics<f64>,
    slopes: &[InverseDynamics<f64>],
) -> Vec<Vec<f64>> {
    let model = JointModel::new(problem, j, effects, slots, |slot| Dual::<WIDTH>::lift(values[slot]));
    let mut changes = vec![];
    for chunk in slopes.chunks(WIDTH) {
        let found = model.residual(problem, j, episode, Some(&varied(needed, chunk)));
        changes.extend((0..chunk.len()).map(|place| found.values.iter().map(|r| r.eps[place]).collect()));
    }
    changes
}

/// What the links need, with the derivatives `slopes`.
fn varied(needed: &InverseDynamics<f64>, slopes: &[InverseDynamics<f64>]) -> InverseDynamics<Dual<WIDTH>> {
    let dual = |value: f64, slope: &dyn Fn(&InverseDynamics<f64>) -> f64| {
        let mut eps = [0.0; WIDTH];
        eps.iter_mut().zip(slopes).for_each(|(eps, own)| *eps = slope(own));
        Dual { re: value, eps }
    };
    let effort = needed.effort.iter().enumerate().map(|(k, value)| dual(*value, &|own| own.effort[k]));
    let own_inertia = needed.own_inertia.as_ref().map(|inertia| {
        let slope =
            |k: usize| move |own: &InverseDynamics<f64>| own.own_inertia.as_ref().map_or(0.0, |own| own[k]);
        inertia.iter().enumerate().map(|(k, value)| dual(*value, &slope(k))).collect()
    });
    InverseDynamics { effort: effort.collect(), own_inertia }
}

/// Least standard deviation of a joint's residual. No model is better than the noise of the readings: smaller residuals
/// would be noise that terms of the equation have in common.
pub(crate) fn noise_floor(problem: &Problem, joint: usize) -> f64 {
    let setup = &problem.joints[joint];
    let share = if setup.drive == Drive::None { MIN_NUMERICAL_ERROR } else { MIN_DRIVE_ERROR };
    setup.sensor_noise[0].hypot(setup.sensor_noise[1]).max(share * setup.scales.effort)
}

/// Robust standard deviation of residuals.
pub(crate) fn robust_sd(problem: &Problem, joint: usize, residual: &DVector<f64>) -> f64 {
    let floor = noise_floor(problem, joint);
    if residual.is_empty() {
        return floor;
    }
    if residual.iter().any(|r| !r.is_finite()) {
        return f64::INFINITY;
    }
    let mut sizes: Vec<f64> = residual.iter().map(|r| r.abs()).collect();
    let middle = sizes.len() / 2;
    let median = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
    let mut sd = (1.4826 * median).max(floor);
    for _ in 0..5 {
        let sum: f64 = residual.iter().map(|r| r * r * weight(*r, sd)).sum();
        sd = (sum / residual.len() as f64).sqrt().max(floor);
    }
    sd
}

/// Huber's weight of a residual.
pub(crate) fn weight(residual: f64, sd: f64) -> f64 {
    let size = residual.abs() / sd;
    if size <= HUBER_SDS { 1.0 } else { HUBER_SDS / size }
}

/// The normal equations of weighted rows: matrix and right-hand side, for the rows that `keep` selects.
pub(crate) fn normal_equations(
    rows: &[JointRows],
    sd: &[f64],
    slots: &[Slot],
    values: &[f64],
    keep: &dyn Fn(&Place) -> bool,
) -> (DMatrix<f64>, DVector<f64>) {
    let count = slots.len();
    let mut matrix = DMatrix::<f64>::zeros(count, count);
    let mut right = DVector::<f64>::zeros(count);
    for own in rows {
        let spread = sd[own.joint];
        let mut weighted = own.jacobian.clone();
        let mut small = DVector::zeros(own.residual.len());
        for (row, place) in own.places.iter().enumerate() {
            let factor = if keep(place) { weight(own.residual[row], spread).sqrt() / spread } else { 0.0 };
            weighted.row_mut(row).scale_mut(factor);
            small[row] = own.residual[row] * factor;
        }
        let (square, slope) = (weighted.tr_mul(&weighted), weighted.tr_mul(&small));
        for (a, &i) in own.columns.iter().enumerate() {
            right[i] -= slope[a];
            for (b, &k) in own.columns.iter().enumerate() {
                matrix[(i, k)] += square[(a, b)];
            }
        }
    }
    for (k, slot) in slots.iter().enumerate() {
        let (precision, slope) = slot.prior.normal_equation(values[k]);
        matrix[(k, k)] += precision;
        right[k] += slope;
    }
    (matrix, right)
}

#[cfg(test)]
pub(crate) mod tests;
