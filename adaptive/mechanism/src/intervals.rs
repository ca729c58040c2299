//! Standard deviations of fitted parameters.

use crate::fit::Fit;
use crate::laws::JointKind;
use crate::model::{Kind, Role};
use crate::problem::Problem;
use crate::rows::{Scope, evaluate, normal_equations};
use crate::units::Unit;

/// Largest share of the prior's standard deviation at which a parameter counts as identified.
const MAX_POSTERIOR_SHARE: f64 = 0.5;

/// A parameter's standard deviation, and whether the data identify it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    pub sd: f64,
    pub identified: bool,
}

/// Intervals of all slots. Correlated residuals count as fewer samples: `time` is the correlation time of each joint's
/// residual, in samples.
pub(crate) fn intervals(problem: &Problem, fit: &Fit, time: &[f64]) -> Vec<Interval> {
    let rows = evaluate(problem, &fit.effects, &fit.slots, &fit.values, Scope::Training, true);
    let sd: Vec<f64> = fit.sd.iter().zip(time).map(|(sd, time)| sd * time.sqrt()).collect();
    let (matrix, _) = normal_equations(&rows, &sd, &fit.slots, &fit.values, &|_| true);
    let scale: Vec<f64> =
        (0..fit.slots.len()).map(|k| matrix[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled =
        nalgebra::DMatrix::from_fn(scale.len(), scale.len(), |i, k| matrix[(i, k)] / (scale[i] * scale[k]));
    let covariance = scaled.cholesky().map(|c| c.inverse());
    let one = |k: usize| {
        let prior = fit.slots[k].prior[1];
        let sd = covariance.as_ref().map_or(prior, |all| all[(k, k)].max(0.0).sqrt() / scale[k]);
        Interval { sd, identified: sd < MAX_POSTERIOR_SHARE * prior }
    };
    (0..fit.slots.len()).map(one).collect()
}

/// Whether the data identify every effect: at least one parameter of its strength is two standard deviations from zero.
pub(crate) fn are_defined(problem: &Problem, fit: &Fit, time: &[f64]) -> bool {
    let spread = intervals(problem, fit, time);
    let is_strength = |effect: usize, param: usize| {
        let spec = fit.effects[effect].kind.params()[param];
        let is_phase = spec.unit == Unit::Angle && fit.effects[effect].kind.joint().is_some();
        let is_place = matches!(spec.unit, Unit::Position | Unit::Velocity | Unit::Length);
        !(spec.is_choice || is_place || is_phase)
    };
    (0..fit.effects.len()).all(|k| {
        let offset =
            matches!(fit.effects[k].kind, Kind::EncoderOffset(_) | Kind::Joint(JointKind::Backlash, _));
        fit.slots.iter().enumerate().any(|(i, slot)| match slot.role {
            Role::Effect(effect, param) if effect == k => {
                (offset || is_strength(effect, param)) && fit.values[i].abs() > 2.0 * spread[i].sd
            }
            _ => false,
        })
    })
}
