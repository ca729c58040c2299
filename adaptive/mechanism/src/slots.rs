//! The free parameters of a nominal mechanism with effects.

use crate::laws::{JointKind, ParamSpec, stop_positions};
use crate::model::{Effect, Kind, PRIOR_SD, Role, Slot, label, scale_is_known};
use crate::nominal_slots::nominal_slots;
use crate::prior::Prior;
use crate::problem::Problem;
use crate::units::Unit;

/// Least limit of a drive, in rms efforts, where no inertia is given: an effort that is always at its limit could be
/// balanced by dry friction alone.
const MIN_UNSCALED_LIMIT: f64 = 1.2;

/// The free parameters of the nominal mechanism, then those of the effects.
pub(crate) fn slots(problem: &Problem, effects: &[Effect]) -> Vec<Slot> {
    let mut found = nominal_slots(problem);
    for (k, effect) in effects.iter().enumerate() {
        for (i, param) in effect.kind.params().iter().enumerate() {
            if param.is_choice || effect.values[i].is_nan() {
                continue;
            }
            found.push(effect_slot(problem, effect, (k, i), param));
        }
    }
    found
}

fn effect_slot(problem: &Problem, effect: &Effect, (k, i): (usize, usize), param: &ParamSpec) -> Slot {
    let scale = match effect.kind {
        Kind::Joint(_, j) | Kind::EncoderOffset(j) => param.scale.of(&problem.joints[j].scales),
        Kind::Payload(body) if param.unit == Unit::Mass => problem.bodies[body].1.max(f64::MIN_POSITIVE),
        Kind::Payload(body) => problem.farthest_payload[body],
        Kind::BaseTilt => 1.0,
    };
    let joint = match effect.kind {
        Kind::Joint(_, j) => Some(j),
        Kind::EncoderOffset(j) if problem.axis.is_some() => Some(j),
        _ => None,
    };
    let mut bounds = param.bounds.map(|bound| bound * scale);
    match effect.kind {
        Kind::Joint(JointKind::EffortSaturation, _) if !scale_is_known(problem) => {
            bounds[0] = MIN_UNSCALED_LIMIT * scale;
        }
        Kind::Joint(JointKind::Stop, j) if param.is_limit => {
            bounds = stop_positions(&problem.joints[j].scales, &effect.values);
        }
        _ => {}
    }
    let centre = match param.unit {
        Unit::Position if param.bounds[0] < 0.0 => effect.values[i],
        _ => 0.0,
    };
    let sd = match param.unit {
        Unit::Length => scale,
        _ => PRIOR_SD * scale.max(effect.values[i].abs()),
    };
    Slot {
        name: format!("{}.{}", label(problem, effect.kind), param.name),
        unit: param.unit,
        joint,
        role: Role::Effect(k, i),
        start: effect.values[i],
        bounds,
        prior: Prior::Normal { mean: centre, sd },
    }
}
