//! Fits of a model to the equations of the joints, by Levenberg–Marquardt steps on the free parameters.

use crate::common;
use crate::equation::JointModel;
use crate::model::{Effect, Slot, slots};
use crate::problem::{Drive, Problem};
use nalgebra::{DMatrix, DVector};
use trundle_model::Dual;

/// Derivatives that one pass over the samples computes.
const WIDTH: usize = 8;
/// Most steps of a fit.
pub(crate) const MAX_STEPS: usize = 30;
/// Relative decrease of the cost at which a fit ends.
const TOLERANCE: f64 = 1e-6;
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
    /// One joint in the training episodes; the equations of the others are approximated, see [`Others`].
    Joint(usize),
}

/// A fitted model.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub effects: Vec<Effect>,
    pub slots: Vec<Slot>,
    pub values: Vec<f64>,
    /// Robust standard deviation of each joint's residual.
    pub sd: Vec<f64>,
    /// Number of compared samples of each joint.
    pub samples: Vec<usize>,
    /// −log prior density up to a constant.
    pub penalty: f64,
}

impl Fit {
    /// −log likelihood of all joints, where `time` is the correlation time of each joint's residual in samples.
    pub fn cost(&self, time: &[f64]) -> f64 {
        let own = |j: usize| self.samples[j] as f64 / time[j] * self.sd[j].max(f64::MIN_POSITIVE).ln();
        (0..self.sd.len()).filter(|j| self.samples[*j] > 0).map(own).sum::<f64>() + self.penalty
    }

    /// Effects with their fitted values.
    pub fn fitted_effects(&self) -> Vec<Effect> {
        common::with_values(&self.effects, &self.slots, &self.values)
    }
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
    let passes: Vec<&[usize]> =
        if own.is_empty() || !with_derivatives { vec![&[]] } else { own.chunks(WIDTH).collect() };
    let parts = parts(problem);
    let (mut places, mut residual, mut columns) = (vec![], vec![], vec![vec![]; own.len() + shared.len()]);
    let mut first_fold = 0;
    for (index, episode) in problem.episodes.iter().enumerate() {
        if episode.held_out != (scope == Scope::HeldOut) {
            continue;
        }
        let series = &episode.joints[j];
        let needed = episode.dynamics.as_ref().map(|d| common::needed(problem, d, j, effects, slots, values));
        let mut held = vec![];
        for (pass, chunk) in passes.iter().enumerate() {
            let variable = |slot: usize| match chunk.iter().position(|own| *own == slot) {
                Some(place) => Dual::<WIDTH>::variable(values[slot], place),
                None => trundle_model::Real::lift(values[slot]),
            };
            let model = JointModel::new(problem, j, effects, slots, variable);
            let (found, at_rest) = model.residual(problem, j, episode, needed.as_deref());
            for k in &series.kept {
                let compared = episode.kernel.at(&found, *k);
                if pass == 0 {
                    residual.push(compared.re);
                }
                for place in 0..chunk.len() {
                    columns[pass * WIDTH + place].push(compared.eps[place]);
                }
            }
            held = at_rest;
        }
        if let (Some(dynamics), true) = (&episode.dynamics, with_derivatives) {
            for (place, slot) in shared.iter().enumerate() {
                let mut slope = common::slope(problem, dynamics, j, effects, &slots[*slot], (slots, values));
                slope.iter_mut().zip(&held).filter(|(_, held)| **held).for_each(|(x, _)| *x = 0.0);
                let column = &mut columns[own.len() + place];
                column.extend(series.kept.iter().map(|k| -episode.kernel.at(&slope, *k)));
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
    JointRows { joint: j, places, residual: DVector::from_vec(residual), jacobian, columns }
}

/// Robust standard deviation of residuals, and the weight of each.
pub(crate) fn robust_sd(problem: &Problem, joint: usize, residual: &DVector<f64>) -> f64 {
    let setup = &problem.joints[joint];
    let share = if setup.drive == Drive::None { MIN_NUMERICAL_ERROR } else { MIN_DRIVE_ERROR };
    let floor = setup.noise.max(share * setup.scales.effort);
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
        let precision = slot.prior[1].powi(-2);
        matrix[(k, k)] += precision;
        right[k] -= precision * (values[k] - slot.prior[0]);
    }
    (matrix, right)
}

fn penalty(slots: &[Slot], values: &[f64]) -> f64 {
    let one = |(slot, value): (&Slot, &f64)| 0.5 * ((value - slot.prior[0]) / slot.prior[1]).powi(2);
    slots.iter().zip(values).map(one).sum()
}

/// A step within the bounds: parameters that would leave them stay at the bound.
pub(crate) fn bounded_step(
    matrix: &DMatrix<f64>,
    right: &DVector<f64>,
    slots: &[Slot],
    values: &[f64],
    damping: f64,
    free: &dyn Fn(usize) -> bool,
) -> Option<DVector<f64>> {
    let mut fixed: Vec<bool> = (0..slots.len()).map(|k| !free(k)).collect();
    loop {
        let mut lhs = matrix.clone();
        let mut rhs = right.clone();
        for k in 0..slots.len() {
            if fixed[k] {
                lhs.row_mut(k).fill(0.0);
                lhs.column_mut(k).fill(0.0);
                (lhs[(k, k)], rhs[k]) = (1.0, 0.0);
            } else {
                lhs[(k, k)] *= 1.0 + damping;
            }
        }
        let scale = DVector::from_fn(slots.len(), |k, _| lhs[(k, k)].max(f64::MIN_POSITIVE).sqrt().recip());
        let scaled = DMatrix::from_fn(slots.len(), slots.len(), |i, k| lhs[(i, k)] * scale[i] * scale[k]);
        let step = scaled.cholesky()?.solve(&rhs.component_mul(&scale)).component_mul(&scale);
        let mut changed = false;
        for k in 0..slots.len() {
            let leaves = |bound: f64, below: bool| {
                let next = values[k] + step[k];
                let outside = if below { next < bound } else { next > bound };
                outside && (values[k] - bound).abs() < 1e-12 * slots[k].prior[1]
            };
            if !fixed[k] && (leaves(slots[k].bounds[0], true) || leaves(slots[k].bounds[1], false)) {
                (fixed[k], changed) = (true, true);
            }
        }
        if !changed {
            return Some(step);
        }
    }
}

/// Values after a step, cut at the bounds.
pub(crate) fn moved(slots: &[Slot], values: &[f64], step: &DVector<f64>) -> Vec<f64> {
    let one = |k: usize| (values[k] + step[k]).clamp(slots[k].bounds[0], slots[k].bounds[1]);
    (0..slots.len()).map(one).collect()
}

/// The equations of all joints at a fit: a quadratic approximation of the cost of those joints that are not evaluated
/// again.
#[derive(Clone, Debug)]
pub(crate) struct Others {
    values: Vec<f64>,
    /// Matrix and right-hand side of the normal equations of each joint, without the prior.
    joints: Vec<(DMatrix<f64>, DVector<f64>)>,
}

impl Others {
    /// Those of a fit.
    pub fn of(problem: &Problem, fit: &Fit) -> Self {
        let rows = evaluate(problem, &fit.effects, &fit.slots, &fit.values, Scope::Training, true);
        let flat: Vec<Slot> =
            fit.slots.iter().map(|slot| Slot { prior: [0.0, f64::INFINITY], ..slot.clone() }).collect();
        let own = |rows: &JointRows| {
            normal_equations(std::slice::from_ref(rows), &fit.sd, &flat, &fit.values, &|_| true)
        };
        Self { values: fit.values.clone(), joints: rows.iter().map(own).collect() }
    }

    /// Change of the values from the fit's. Further slots belong to new effects, which the other joints do not contain.
    fn change(&self, values: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.values.len(), self.values.iter().zip(values).map(|(old, new)| new - old))
    }

    /// Rise of the cost of all joints but one, nats.
    pub fn cost(&self, except: usize, fit: &Fit) -> f64 {
        self.cost_at(except, &fit.values)
    }

    fn cost_at(&self, except: usize, values: &[f64]) -> f64 {
        let change = self.change(values);
        let one = |(matrix, right): &(DMatrix<f64>, DVector<f64>)| {
            0.5 * change.dot(&(matrix * &change)) - right.dot(&change)
        };
        self.joints.iter().enumerate().filter(|(j, _)| *j != except).map(|(_, own)| one(own)).sum()
    }

    /// Add the other joints' normal equations at some values.
    fn add_to(&self, except: usize, values: &[f64], matrix: &mut DMatrix<f64>, right: &mut DVector<f64>) {
        let (change, count) = (self.change(values), self.values.len());
        for (_, (own, slope)) in self.joints.iter().enumerate().filter(|(j, _)| *j != except) {
            let mut block = matrix.view_mut((0, 0), (count, count));
            block += own;
            let mut part = right.rows_mut(0, count);
            part += slope - own * &change;
        }
    }
}

/// Fit a model, from the values in `effects` and of `from`'s slots of the same name.
pub(crate) fn fit(
    problem: &Problem,
    effects: &[Effect],
    from: Option<&Fit>,
    scope: Scope,
    max_steps: usize,
) -> Fit {
    fit_with(problem, effects, from, scope, max_steps, None)
}

/// [`fit`], with an approximation of the joints outside the scope.
pub(crate) fn fit_with(
    problem: &Problem,
    effects: &[Effect],
    from: Option<&Fit>,
    scope: Scope,
    max_steps: usize,
    others: Option<&Others>,
) -> Fit {
    let slots = slots(problem, effects);
    let known = |slot: &Slot| {
        let from = from?;
        let place = from.slots.iter().position(|other| other.name == slot.name && other.role == slot.role)?;
        Some(from.values[place])
    };
    let start = |slot: &Slot| known(slot).unwrap_or(slot.start).clamp(slot.bounds[0], slot.bounds[1]);
    let mut values: Vec<f64> = slots.iter().map(start).collect();
    let approximated = match scope {
        Scope::Joint(j) => others.map(|others| (j, others)),
        _ => None,
    };
    let is_free = |k: usize| match scope {
        Scope::Joint(j) if others.is_none() => slots[k].joint == Some(j),
        _ => true,
    };
    let spread = |rows: &[JointRows]| -> Vec<f64> {
        let mut sd = vec![1.0; problem.joints.len()];
        rows.iter().for_each(|own| sd[own.joint] = robust_sd(problem, own.joint, &own.residual));
        sd
    };
    let objective = |rows: &[JointRows], sd: &[f64], values: &[f64]| -> f64 {
        rows.iter().map(|own| own.residual.len() as f64 * sd[own.joint].ln()).sum::<f64>()
            + penalty(&slots, values)
            + approximated.map_or(0.0, |(j, others)| others.cost_at(j, values))
    };
    let mut rows = evaluate(problem, effects, &slots, &values, scope, true);
    let mut sd = spread(&rows);
    let mut cost = objective(&rows, &sd, &values);
    let mut damping = 1e-6;
    for _ in 0..max_steps {
        let (mut matrix, mut right) = normal_equations(&rows, &sd, &slots, &values, &|_| true);
        if let Some((j, others)) = approximated {
            others.add_to(j, &values, &mut matrix, &mut right);
        }
        let mut accepted = false;
        while damping < 1e6 {
            let Some(step) = bounded_step(&matrix, &right, &slots, &values, damping, &is_free) else {
                damping = (damping * 100.0).max(1e-3);
                continue;
            };
            let next = moved(&slots, &values, &step);
            let tried = evaluate(problem, effects, &slots, &next, scope, false);
            let next_sd = spread(&tried);
            let next_cost = objective(&tried, &next_sd, &next);
            if next_cost < cost {
                let gain = cost - next_cost;
                (values, cost) = (next, next_cost);
                damping = (damping * 0.1).max(1e-9);
                accepted = gain > TOLERANCE * (1.0 + cost.abs());
                break;
            }
            damping = (damping * 10.0).max(1e-4);
        }
        if !accepted {
            break;
        }
        rows = evaluate(problem, effects, &slots, &values, scope, true);
        sd = spread(&rows);
    }
    let rows = evaluate(problem, effects, &slots, &values, scope, false);
    let sd = spread(&rows);
    let mut samples = vec![0; problem.joints.len()];
    rows.iter().for_each(|own| samples[own.joint] = own.residual.len());
    let penalty = penalty(&slots, &values);
    Fit { effects: effects.to_vec(), slots, values, sd, samples, penalty }
}
