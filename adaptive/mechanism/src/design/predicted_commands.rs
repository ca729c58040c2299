//! The commands that a model predicts for a planned motion.

use crate::equation::JointModel;
use crate::fit::Fit;
use crate::link_motion::inverse_dynamics_at;
use crate::problem::Problem;

/// Most Newton steps.
const MAX_STEPS: usize = 12;
/// Decrease of the squared residual at which the steps end.
const MIN_DECREASE: f64 = 1e-6;

/// Recorded command of each joint at every time, for which a fitted model has no residual, by Newton steps at each
/// sample. Dry friction at rest needs no effort.
pub(super) fn predicted_commands(problem: &Problem, fit: &Fit) -> Vec<Vec<f64>> {
    let effects = fit.fitted_effects();
    let one = |j: usize| {
        let model = JointModel::new(problem, j, &effects, &fit.slots, |k| fit.values[k]);
        let acting = acting_commands(problem, fit, j, &model.without_delays());
        model.uncommanded(&acting, problem.episodes[0].dt)
    };
    (0..problem.joints.len()).map(one).collect()
}

/// Commands that act at once.
fn acting_commands(problem: &Problem, fit: &Fit, j: usize, model: &JointModel<f64>) -> Vec<f64> {
    let mut episode = problem.episodes[0].clone();
    let values = (&fit.effects[..], &fit.slots[..], &fit.values[..]);
    let wants_inertia = !model.is_linear_in_inverse_dynamics();
    let needed = inverse_dynamics_at(problem, &episode, j, values, wants_inertia);
    let gain = model.gain_of(&episode.joints[j]);
    if problem.joints[j].drive == crate::drive::Drive::Target {
        episode.joints[j].command = episode.joints[j].q.clone();
    }
    let square = |residual: &[f64]| residual.iter().map(|r| r * r).sum::<f64>();
    let mut found = model.residual(problem, j, &episode, needed.as_ref());
    for _ in 0..MAX_STEPS {
        let before = episode.joints[j].command.clone();
        let command = &mut episode.joints[j].command;
        for ((command, r), per_effort) in command.iter_mut().zip(&found.values).zip(&found.per_effort) {
            // Where friction holds the joint, any small command does.
            *command -= if *per_effort > 0.0 { r / (gain * per_effort) } else { 0.0 };
        }
        let next = model.residual(problem, j, &episode, needed.as_ref());
        let (old, new) = (square(&found.values), square(&next.values));
        if new.is_nan() || new >= old {
            return before;
        }
        found = next;
        if new > (1.0 - MIN_DECREASE) * old {
            break;
        }
    }
    episode.joints.swap_remove(j).command
}
