//! Effects that may be added to a mechanism.

use crate::drive::Drive;
use crate::laws::{Applies, JointKind};
use crate::model::{Kind, scale_is_known};
use crate::nominal_slots::nominal_slots;
use crate::problem::Problem;
use trundle_record::EffortSource;

/// All effects that may be added to a mechanism.
pub(crate) fn candidates(problem: &Problem) -> Vec<Kind> {
    let mut all = vec![];
    for j in 0..problem.joints.len() {
        if problem.samples(j) == 0 {
            continue;
        }
        all.extend(JointKind::ALL.iter().filter(|k| applies(problem, **k, j)).map(|k| Kind::Joint(*k, j)));
        let has_gravity = problem.axis.is_none_or(|axis| axis.gravity_torque.is_some());
        if has_gravity {
            all.push(Kind::EncoderOffset(j));
        }
    }
    if problem.axis.is_none() {
        all.extend((0..problem.bodies.len()).map(Kind::Payload));
    }
    if problem.axis.is_none() && problem.simulator.is_none() {
        all.push(Kind::BaseTilt);
    }
    all
}

/// Whether a law can act on a joint and is not part of the nominal model.
fn applies(problem: &Problem, kind: JointKind, j: usize) -> bool {
    let joint = &problem.joints[j];
    let (is_measured, is_commanded) = match joint.drive {
        Drive::None => (false, false),
        Drive::Effort(EffortSource::Commanded | EffortSource::Voltage) => (false, true),
        Drive::Effort(_) => (true, false),
        Drive::Target => (false, true),
    };
    let is_effort = matches!(joint.drive, Drive::Effort(_));
    let has_fixed_gain = problem.episodes.iter().all(|e| e.joints[j].gain.is_some());
    let is_free =
        |key: &str| nominal_slots(problem).iter().any(|s| s.joint == Some(j) && s.name.starts_with(key));
    match kind {
        JointKind::ViscousFriction => {
            !is_free("damping") && (joint.switches_off || !is_free("drive_damping"))
        }
        JointKind::RotorInertia => {
            let has_inertia = problem.axis.is_none_or(|axis| axis.inertia.is_some());
            has_inertia && !is_free("armature") && !is_free("inertia")
        }
        // A common gain is the scale of all forces: something else must fix it.
        JointKind::EffortGain => is_effort && has_fixed_gain && scale_is_known(problem),
        JointKind::EffortBias => is_effort,
        // Without a known inertia, a play that never closes would explain any motion.
        JointKind::Backlash => joint.drive != Drive::None && scale_is_known(problem),
        _ => match kind.spec().applies {
            Applies::Always => true,
            Applies::Driven => joint.drive != Drive::None,
            Applies::MeasuredEffort => is_measured,
            Applies::CommandedEffort => is_commanded,
            Applies::Loaded => joint.drive != Drive::None || joint.has_load,
        },
    }
}
