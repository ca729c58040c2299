//! Fits of a model to the equations of the joints, by Levenberg–Marquardt steps on the free parameters.

use crate::model::{Effect, Nominal, Role, Slot};
use crate::problem::Problem;
use crate::quadratic_cost::QuadraticCost;
use crate::rows::{JointRows, Scope, evaluate, normal_equations, robust_sd, weight};
use crate::shared_parameters;
use crate::slots::slots;
use nalgebra::{DMatrix, DVector};

/// Most steps of a fit.
pub(crate) const MAX_STEPS: usize = 30;
/// Relative decrease of the cost at which a fit ends.
const TOLERANCE: f64 = 1e-6;

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
    /// Number of parameters that the data determine: the trace of H (H + P)⁻¹ with the data's and the prior's
    /// precision (Spiegelhalter et al. 2002). Parameters that only the prior determines do not count.
    pub rank: f64,
}

impl Fit {
    /// −log likelihood of all joints, where `time` is the correlation time of each joint's residual in samples.
    pub fn cost(&self, time: &[f64]) -> f64 {
        let own = |j: usize| self.samples[j] as f64 / time[j] * self.sd[j].max(f64::MIN_POSITIVE).ln();
        (0..self.sd.len()).filter(|j| self.samples[*j] > 0).map(own).sum::<f64>() + self.penalty
    }

    /// Fitted gain of a joint's drive; `None` if it is given.
    pub fn gain(&self, j: usize) -> Option<f64> {
        let is_gain = |slot: &Slot| slot.joint == Some(j) && slot.role == Role::Nominal(Nominal::Gain);
        self.slots.iter().position(is_gain).map(|k| self.values[k])
    }

    /// Effects with their fitted values.
    pub fn fitted_effects(&self) -> Vec<Effect> {
        shared_parameters::with_values(&self.effects, &self.slots, &self.values)
    }
}

/// −log likelihood of residuals up to a constant. Residuals below the least standard deviation still determine the values,
/// although they count as no better in [`Fit::cost`], which compares models.
fn misfit(residual: &DVector<f64>, sd: f64) -> f64 {
    let squares: f64 = residual.iter().map(|r| weight(*r, sd) * (r / sd).powi(2)).sum();
    residual.len() as f64 * sd.ln() + 0.5 * squares
}

fn penalty(slots: &[Slot], values: &[f64]) -> f64 {
    slots.iter().zip(values).map(|(slot, value)| slot.prior.cost(*value)).sum()
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
                outside && (values[k] - bound).abs() < 1e-12 * slots[k].prior.sd()
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

/// The parameters that a fit changes.
#[derive(Clone, Copy)]
pub(crate) enum Freedom<'a> {
    /// All, or those of the joint of the scope.
    Scope,
    /// All, with an approximation of the joints outside the scope.
    Approximated(&'a QuadraticCost),
    /// The timing of drives between samples, which is no value of the model.
    Timing,
}

/// Fit a model, from the values in `effects` and of `from`'s slots of the same name.
pub(crate) fn fit(
    problem: &Problem,
    effects: &[Effect],
    from: Option<&Fit>,
    scope: Scope,
    max_steps: usize,
) -> Fit {
    fit_with(problem, effects, from, scope, max_steps, Freedom::Scope)
}

/// [`fit`] of some of the parameters.
pub(crate) fn fit_with(
    problem: &Problem,
    effects: &[Effect],
    from: Option<&Fit>,
    scope: Scope,
    max_steps: usize,
    freedom: Freedom<'_>,
) -> Fit {
    let slots = slots(problem, effects);
    let mut values = starting_values(&slots, from);
    let objective = Objective::new(problem, effects, &slots, (scope, freedom));
    let mut rows = objective.rows(&values, true);
    let mut sd = objective.residual_sds(&rows);
    let mut cost = objective.cost(&rows, &sd, &values);
    let mut damping = 1e-6;
    for _ in 0..max_steps {
        let equations = objective.normal_equations(&rows, &sd, &values);
        let Some((next, next_cost)) = objective.lowered(&equations, &values, cost, &mut damping) else {
            break;
        };
        let gain = cost - next_cost;
        (values, cost) = (next, next_cost);
        rows = objective.rows(&values, true);
        sd = objective.residual_sds(&rows);
        if gain <= TOLERANCE * (1.0 + cost.abs()) {
            break;
        }
    }
    let mut samples = vec![0; problem.joints.len()];
    rows.iter().for_each(|own| samples[own.joint] = own.residual.len());
    let penalty = penalty(&slots, &values);
    let (precision, _) = normal_equations(&rows, &sd, &slots, &values, &|_| true);
    let rank = rank(&precision, &slots, &values);
    Fit { effects: effects.to_vec(), slots, values, sd, samples, penalty, rank }
}

/// Values of the slots of the same name in another fit, or else the slots' own, within the bounds.
fn starting_values(slots: &[Slot], from: Option<&Fit>) -> Vec<f64> {
    let known = |slot: &Slot| {
        let from = from?;
        let place = from.slots.iter().position(|other| other.name == slot.name && other.role == slot.role)?;
        Some(from.values[place])
    };
    let start = |slot: &Slot| known(slot).unwrap_or(slot.start).clamp(slot.bounds[0], slot.bounds[1]);
    slots.iter().map(start).collect()
}

/// The cost that a fit minimises, as a function of the values of the slots.
struct Objective<'a> {
    problem: &'a Problem,
    effects: &'a [Effect],
    slots: &'a [Slot],
    scope: Scope,
    freedom: Freedom<'a>,
    /// The joint that is evaluated, and the approximated cost of the others.
    approximated: Option<(usize, &'a QuadraticCost)>,
}

impl<'a> Objective<'a> {
    fn new(
        problem: &'a Problem,
        effects: &'a [Effect],
        slots: &'a [Slot],
        (scope, freedom): (Scope, Freedom<'a>),
    ) -> Self {
        let approximated = match (scope, freedom) {
            (Scope::Joint(j), Freedom::Approximated(others)) => Some((j, others)),
            _ => None,
        };
        Self { problem, effects, slots, scope, freedom, approximated }
    }

    fn is_free(&self, k: usize) -> bool {
        match (self.freedom, self.scope) {
            (Freedom::Timing, _) => self.slots[k].is_timing(),
            (Freedom::Scope, Scope::Joint(j)) => self.slots[k].joint == Some(j),
            _ => true,
        }
    }

    fn rows(&self, values: &[f64], with_derivatives: bool) -> Vec<JointRows> {
        evaluate(self.problem, self.effects, self.slots, values, self.scope, with_derivatives)
    }

    /// Robust standard deviation of each joint's residual; 1 for joints that are not evaluated.
    fn residual_sds(&self, rows: &[JointRows]) -> Vec<f64> {
        let mut sd = vec![1.0; self.problem.joints.len()];
        rows.iter().for_each(|own| sd[own.joint] = robust_sd(self.problem, own.joint, &own.residual));
        sd
    }

    fn cost(&self, rows: &[JointRows], sd: &[f64], values: &[f64]) -> f64 {
        rows.iter().map(|own| misfit(&own.residual, sd[own.joint])).sum::<f64>()
            + penalty(self.slots, values)
            + self.approximated.map_or(0.0, |(j, others)| others.cost(j, values))
    }

    fn normal_equations(
        &self,
        rows: &[JointRows],
        sd: &[f64],
        values: &[f64],
    ) -> (DMatrix<f64>, DVector<f64>) {
        let (mut matrix, mut right) = normal_equations(rows, sd, self.slots, values, &|_| true);
        if let Some((j, others)) = self.approximated {
            others.add_to(j, values, &mut matrix, &mut right);
        }
        (matrix, right)
    }

    /// Values after a Levenberg–Marquardt step that lowers the cost, and their cost; `None` if no damping leads to one.
    fn lowered(
        &self,
        (matrix, right): &(DMatrix<f64>, DVector<f64>),
        values: &[f64],
        cost: f64,
        damping: &mut f64,
    ) -> Option<(Vec<f64>, f64)> {
        let is_free = |k: usize| self.is_free(k);
        while *damping < 1e6 {
            let Some(step) = bounded_step(matrix, right, self.slots, values, *damping, &is_free) else {
                *damping = (*damping * 100.0).max(1e-3);
                continue;
            };
            let next = moved(self.slots, values, &step);
            let rows = self.rows(&next, false);
            let next_cost = self.cost(&rows, &self.residual_sds(&rows), &next);
            if next_cost < cost {
                *damping = (*damping * 0.1).max(1e-9);
                return Some((next, next_cost));
            }
            *damping = (*damping * 10.0).max(1e-4);
        }
        None
    }
}

/// Number of parameters that the data determine, from the precision of data and prior together.
fn rank(precision: &DMatrix<f64>, slots: &[Slot], values: &[f64]) -> f64 {
    let Some(variances) = variances(precision) else { return slots.len() as f64 };
    let by_prior = |k: usize| variances[k] * slots[k].prior.normal_equation(values[k]).0;
    slots.len() as f64 - (0..slots.len()).map(by_prior).sum::<f64>()
}

/// Variances of all parameters from their precision; `None` if it is not positive definite.
pub(crate) fn variances(precision: &DMatrix<f64>) -> Option<Vec<f64>> {
    let count = precision.nrows();
    let scale: Vec<f64> = (0..count).map(|k| precision[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled = DMatrix::from_fn(count, count, |i, k| precision[(i, k)] / (scale[i] * scale[k]));
    let covariance = scaled.cholesky()?.inverse();
    Some((0..count).map(|k| covariance[(k, k)] / (scale[k] * scale[k])).collect())
}
