//! Standard deviations of fitted parameters.

use crate::fit::Fit;
use crate::laws::JointKind;
use crate::model::{Kind, Role};
use crate::problem::Problem;
use crate::rows::{Scope, evaluate, normal_equations};
use crate::units::Unit;
use nalgebra::DMatrix;

/// Largest share of the prior's standard deviation at which a parameter counts as identified.
const MAX_POSTERIOR_SHARE: f64 = 0.5;

/// Distance of a strength from zero at which it is identified, standard deviations.
const CLEAR_SDS: f64 = 2.0;

/// A parameter's standard deviation, and whether the data identify it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    pub sd: f64,
    pub identified: bool,
}

/// Covariance of all slots; `None` if the precision is singular. Correlated residuals count as fewer samples: `time` is the
/// correlation time of each joint's residual, in samples.
fn covariance(problem: &Problem, fit: &Fit, time: &[f64]) -> Option<DMatrix<f64>> {
    let rows = evaluate(problem, &fit.effects, &fit.slots, &fit.values, Scope::Training, true);
    let sd: Vec<f64> = fit.sd.iter().zip(time).map(|(sd, time)| sd * time.sqrt()).collect();
    let (mut matrix, _) = normal_equations(&rows, &sd, &fit.slots, &fit.values, &|_| true);
    // A parameter at its bound cannot move with the others.
    let is_bound = |k: usize| fit.slots[k].bounds.contains(&fit.values[k]);
    for k in (0..fit.slots.len()).filter(|k| is_bound(*k)) {
        let own = matrix[(k, k)];
        matrix.row_mut(k).fill(0.0);
        matrix.column_mut(k).fill(0.0);
        matrix[(k, k)] = own;
    }
    let scale: Vec<f64> =
        (0..fit.slots.len()).map(|k| matrix[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled = DMatrix::from_fn(scale.len(), scale.len(), |i, k| matrix[(i, k)] / (scale[i] * scale[k]));
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(scale.len(), scale.len(), |i, k| inverse[(i, k)] / (scale[i] * scale[k])))
}

/// Intervals of all slots; `time` as in [`covariance`].
pub(crate) fn intervals(problem: &Problem, fit: &Fit, time: &[f64]) -> Vec<Interval> {
    let covariance = covariance(problem, fit, time);
    let one = |k: usize| {
        let prior = fit.slots[k].prior[1];
        let sd = covariance.as_ref().map_or(prior, |all| all[(k, k)].max(0.0).sqrt());
        Interval { sd, identified: sd < MAX_POSTERIOR_SHARE * prior }
    };
    (0..fit.slots.len()).map(one).collect()
}

/// Whether the data identify every effect: at least one parameter of its strength is two standard deviations from zero.
/// The strength of a payload is its mass, or a moment of it.
pub(crate) fn are_defined(problem: &Problem, fit: &Fit, time: &[f64]) -> bool {
    let Some(covariance) = covariance(problem, fit, time) else { return fit.effects.is_empty() };
    let is_strength = |effect: usize, param: usize| {
        let spec = fit.effects[effect].kind.params()[param];
        let is_phase = spec.unit == Unit::Angle && fit.effects[effect].kind.joint().is_some();
        let is_place = matches!(spec.unit, Unit::Position | Unit::Velocity | Unit::Length);
        !(spec.is_choice || is_place || is_phase)
    };
    (0..fit.effects.len()).all(|k| {
        let kind = fit.effects[k].kind;
        let offset = matches!(kind, Kind::EncoderOffset(_) | Kind::Joint(JointKind::Backlash, _));
        let own = |slot: usize| match fit.slots[slot].role {
            Role::Effect(effect, param) if effect == k => Some(param),
            _ => None,
        };
        let slots: Vec<(usize, usize)> =
            (0..fit.slots.len()).filter_map(|slot| Some((slot, own(slot)?))).collect();
        let is_clear = |(slot, param): &(usize, usize)| {
            let sd = covariance[(*slot, *slot)].max(0.0).sqrt();
            (offset || is_strength(k, *param)) && fit.values[*slot].abs() > CLEAR_SDS * sd
        };
        let mass = slots.first().map_or(0, |(slot, _)| *slot);
        let has_clear_moment = |(slot, _): &(usize, usize)| {
            let [m, x] = [fit.values[mass], fit.values[*slot]];
            let variance = x * x * covariance[(mass, mass)]
                + m * m * covariance[(*slot, *slot)]
                + 2.0 * m * x * covariance[(mass, *slot)];
            *slot != mass && (m * x).abs() > CLEAR_SDS * variance.max(0.0).sqrt()
        };
        slots.iter().any(is_clear) || (matches!(kind, Kind::Payload(_)) && slots.iter().any(has_clear_moment))
    })
}
