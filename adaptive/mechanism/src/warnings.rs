//! Doubts that a careful reader must know.

use crate::figures::figures;
use crate::fit::Fit;
use crate::model::{Nominal, Role};
use crate::problem::Problem;
use crate::units::EffortUnit;
use trundle_diagnose::Verdict;

/// Relative rise of a held-out figure that counts as worse.
const MIN_RISE: f64 = 1.05;
/// Ratio of a refitted mass to the model's that is implausible.
const MAX_MASS_RATIO: f64 = 2.0;

/// Warnings of a diagnosis.
pub(crate) fn warnings(problem: &Problem, before: &Fit, after: &Fit, verdict: Verdict) -> Vec<String> {
    let mut found = vec![];
    match problem.effort_unit {
        EffortUnit::Newton => {}
        EffortUnit::PerInertia => found.push(
            "nothing fixes the scale of force: all dynamics are per unit of inertia, in 1/s and 1/s²".to_owned(),
        ),
        EffortUnit::Recorded => found.push(
            "nothing fixes the scale of force: efforts are in the recorded unit, inertias in that unit per acceleration"
                .to_owned(),
        ),
        EffortUnit::TargetError => found.push(
            "nothing fixes the scale of force: efforts are in position error of the target".to_owned(),
        ),
    }
    for (slot, value) in after.slots.iter().zip(&after.values) {
        if let Role::Nominal(Nominal::Mass(body)) = slot.role {
            let ratio = value / problem.bodies[body].1;
            if !(MAX_MASS_RATIO.recip()..=MAX_MASS_RATIO).contains(&ratio) {
                found.push(format!("{}: the refitted mass is {ratio:.2} times the model's", slot.name));
            }
        }
    }
    let held_out = [figures(problem, before, true), figures(problem, after, true)];
    if let ([Some(before), Some(after)], Verdict::Explained) = (held_out, verdict) {
        for (joint, now) in &after.joints {
            let Some(then) = before.joints.get(joint) else { continue };
            let pairs = [
                ("open-loop position", then.position_rmse, now.position_rmse),
                ("position within a second", then.window_position_rmse, now.window_position_rmse),
                ("effort", then.effort_rmse, now.effort_rmse),
            ];
            for (what, then, now) in pairs {
                if let (Some(then), Some(now)) = (then, now)
                    && now > MIN_RISE * then
                {
                    found.push(format!(
                        "held-out episodes: the error of the {what} of joint {joint} rises from {then:.3e} to {now:.3e}"
                    ));
                }
            }
        }
    }
    found
}
