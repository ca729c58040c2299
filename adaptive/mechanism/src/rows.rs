//! Residuals of the joints' equations at the compared samples, with their derivatives, and the normal equations.

use crate::drive::Drive;
use crate::dynamics::{EpisodeDynamics, InverseDynamics};
use crate::equation::JointModel;
use crate::link_motion::inverse_dynamics_at;
use crate::model::{Effect, Slot};
use crate::problem::{EpisodeData, Problem};
use crate::series::Series;
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
    let evaluator = Evaluator::new(problem, j, (effects, slots, values));
    let mut rows = evaluator.empty_rows();
    let parts = parts(problem);
    let mut first_fold = 0;
    for (index, episode) in problem.episodes.iter().enumerate() {
        if episode.held_out != (scope == Scope::HeldOut) {
            continue;
        }
        if with_derivatives {
            evaluator.add_with_derivatives(episode, &mut rows);
        } else {
            evaluator.add_residuals(episode, &mut rows);
        }
        let series = &episode.joints[j];
        let len = series.q.len();
        rows.places.extend(series.kept.iter().map(|k| Place {
            episode: index,
            sample: *k,
            fold: first_fold + k * parts / len.max(1),
        }));
        first_fold += parts;
    }
    evaluator.collected(rows, with_derivatives)
}

/// The equation of one joint under a model.
struct Evaluator<'a> {
    problem: &'a Problem,
    joint: usize,
    known: (&'a [Effect], &'a [Slot], &'a [f64]),
    /// Slots of this joint.
    own: Vec<usize>,
    /// Slots of all joints.
    shared: Vec<usize>,
    /// Whether the equation reads the own inertia.
    wants_inertia: bool,
}

/// Rows of the episodes so far.
struct PartialRows {
    places: Vec<Place>,
    residual: Vec<f64>,
    per_effort: Vec<f64>,
    /// By slot, then by row.
    columns: Vec<Vec<f64>>,
}

impl<'a> Evaluator<'a> {
    fn new(problem: &'a Problem, j: usize, known: (&'a [Effect], &'a [Slot], &'a [f64])) -> Self {
        let (effects, slots, values) = known;
        let own = (0..slots.len()).filter(|k| slots[*k].joint == Some(j)).collect();
        let shared = (0..slots.len()).filter(|k| slots[*k].joint.is_none()).collect();
        let model = JointModel::new(problem, j, effects, slots, |slot| values[slot]);
        let wants_inertia = !model.is_linear_in_inverse_dynamics();
        Self { problem, joint: j, known, own, shared, wants_inertia }
    }

    fn empty_rows(&self) -> PartialRows {
        PartialRows {
            places: vec![],
            residual: vec![],
            per_effort: vec![],
            columns: vec![vec![]; self.own.len() + self.shared.len()],
        }
    }

    /// Add the residuals of an episode.
    fn add_residuals(&self, episode: &EpisodeData, rows: &mut PartialRows) {
        let (effects, slots, values) = self.known;
        let series = &episode.joints[self.joint];
        let needed = self.inverse_dynamics(episode);
        let model = JointModel::new(self.problem, self.joint, effects, slots, |slot| values[slot]);
        let found = model.residual(self.problem, self.joint, episode, needed.as_ref());
        let at = |k: &usize| series.weight[*k] * episode.kernel.at(&found.values, *k);
        rows.residual.extend(series.kept.iter().map(at));
        rows.add_per_effort(series, &found.per_effort);
    }

    /// Add the residuals of an episode with their derivatives.
    fn add_with_derivatives(&self, episode: &EpisodeData, rows: &mut PartialRows) {
        let needed = self.inverse_dynamics(episode);
        let per_effort = self.add_own_columns(episode, needed.as_ref(), rows);
        rows.add_per_effort(&episode.joints[self.joint], &per_effort);
        if let (Some(dynamics), Some(needed)) = (&episode.dynamics, &needed) {
            self.add_shared_columns(episode, dynamics, needed, &per_effort, rows);
        }
    }

    fn inverse_dynamics(&self, episode: &EpisodeData) -> Option<InverseDynamics<f64>> {
        inverse_dynamics_at(self.problem, episode, self.joint, self.known, self.wants_inertia)
    }

    /// Add the residuals with their derivatives by this joint's slots. Returns the derivative of the residual by the effort at
    /// every time.
    fn add_own_columns(
        &self,
        episode: &EpisodeData,
        needed: Option<&InverseDynamics<f64>>,
        rows: &mut PartialRows,
    ) -> Vec<f64> {
        let (effects, slots, values) = self.known;
        let series = &episode.joints[self.joint];
        let passes: Vec<&[usize]> =
            if self.own.is_empty() { vec![&[]] } else { self.own.chunks(WIDTH).collect() };
        let mut per_effort = vec![];
        for (pass, chunk) in passes.iter().enumerate() {
            let variable = |slot: usize| match chunk.iter().position(|own| *own == slot) {
                Some(place) => Dual::<WIDTH>::variable(values[slot], place),
                None => Dual::lift(values[slot]),
            };
            let model = JointModel::new(self.problem, self.joint, effects, slots, variable);
            let constant = needed.map(|needed| varied(needed, &[]));
            let found = model.residual(self.problem, self.joint, episode, constant.as_ref());
            for k in &series.kept {
                let compared = episode.kernel.at(&found.values, *k);
                let weight = series.weight[*k];
                if pass == 0 {
                    rows.residual.push(weight * compared.re);
                }
                for place in 0..chunk.len() {
                    rows.columns[pass * WIDTH + place].push(weight * compared.eps[place]);
                }
            }
            per_effort = found.per_effort;
        }
        per_effort
    }

    /// Add the derivatives by the slots of all joints.
    fn add_shared_columns(
        &self,
        episode: &EpisodeData,
        dynamics: &EpisodeDynamics,
        needed: &InverseDynamics<f64>,
        per_effort: &[f64],
        rows: &mut PartialRows,
    ) {
        let (problem, j, wants_inertia) = (self.problem, self.joint, self.wants_inertia);
        let series = &episode.joints[j];
        let slope = |slot: &usize| {
            shared_parameters::slope(problem, dynamics, j, &self.known.1[*slot], self.known, wants_inertia)
        };
        let slopes: Vec<InverseDynamics<f64>> = self.shared.iter().map(slope).collect();
        let changes = if wants_inertia {
            changes_by_inverse_dynamics(problem, (j, episode), self.known, needed, &slopes)
        } else {
            let change = |slope: &InverseDynamics<f64>| {
                slope.effort.iter().zip(per_effort).map(|(slope, factor)| -slope * factor).collect()
            };
            slopes.iter().map(change).collect()
        };
        for (column, change) in rows.columns[self.own.len()..].iter_mut().zip(changes) {
            column.extend(series.kept.iter().map(|k| series.weight[*k] * episode.kernel.at(&change, *k)));
        }
    }

    fn collected(self, rows: PartialRows, with_derivatives: bool) -> JointRows {
        let PartialRows { places, residual, per_effort, columns } = rows;
        let jacobian = if with_derivatives {
            DMatrix::from_fn(residual.len(), columns.len(), |row, column| columns[column][row])
        } else {
            DMatrix::zeros(0, 0)
        };
        JointRows {
            joint: self.joint,
            places,
            residual: DVector::from_vec(residual),
            per_effort,
            jacobian,
            columns: self.own.into_iter().chain(self.shared).collect(),
        }
    }
}

impl PartialRows {
    /// Add the weighted derivatives of the compared residuals by the effort.
    fn add_per_effort(&mut self, series: &Series, per_effort: &[f64]) {
        self.per_effort.extend(series.kept.iter().map(|k| series.weight[*k] * per_effort[*k]));
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
