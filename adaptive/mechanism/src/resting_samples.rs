//! Samples around which a joint rests or turns.
//!
//! There dry friction may have any value between minus and plus its level, so the equation holds only up to that level.
//! The variance of such a sample is that of other samples, plus the square of the friction's mean uncertainty over the
//! window of the filter. It counts like any other if the joint has no dry friction, and hardly if it has much.

use crate::equation::JointModel;
use crate::fit::{Fit, MAX_STEPS, fit};
use crate::laws::JointKind;
use crate::link_motion::inverse_dynamics_at;
use crate::model::{Effect, Kind};
use crate::problem::{EpisodeData, Problem};
use crate::rows::Scope;

/// Largest ratio of static to kinetic dry friction (Armstrong-Hélouvry, Dupont and Canudas de Wit 1994).
const MAX_STICTION: f64 = 2.0;
/// Least number of full samples that samples at rest must be worth, as a share of the others. Fewer change nothing, and the
/// second search takes time.
const MIN_SHARE: f64 = 0.02;

/// The problem in which samples at rest are compared, with weights from the residuals and the friction of a fit; `None`
/// if all these samples together hardly count.
pub(crate) fn with_resting_samples(problem: &Problem, model: &Fit) -> Option<Problem> {
    let mut found = problem.clone();
    let mut gained = 0.0;
    for j in (0..problem.joints.len()).filter(|j| problem.samples(*j) > 0) {
        let with_friction = with_dry_friction(problem, model, j);
        for (episode, own) in problem.episodes.iter().zip(&mut found.episodes) {
            let uncertainty = uncertainty(problem, &with_friction, j, episode);
            let series = &mut own.joints[j];
            for k in std::mem::take(&mut series.resting) {
                series.weight[k] =
                    (episode.kernel.at(&uncertainty, k) / with_friction.sd[j]).hypot(1.0).recip();
                gained += if episode.held_out { 0.0 } else { series.weight[k].powi(2) };
                series.kept.push(k);
            }
            series.kept.sort_unstable();
        }
    }
    let before: usize = (0..problem.joints.len()).map(|j| problem.samples(j)).sum();
    (gained > MIN_SHARE * before as f64).then_some(found)
}

/// The model with dry friction at a joint.
fn with_dry_friction(problem: &Problem, model: &Fit, j: usize) -> Fit {
    let kind = Kind::Joint(JointKind::DryFriction, j);
    if model.effects.iter().any(|effect| effect.kind == kind) {
        return model.clone();
    }
    let one = |values: Vec<f64>| {
        let effects = [model.fitted_effects(), vec![Effect { kind, values }]].concat();
        fit(problem, &effects, Some(model), Scope::Joint(j), MAX_STEPS)
    };
    let fits = kind.starts(problem).into_iter().map(one).filter(|fit| fit.sd[j].is_finite());
    fits.min_by(|a, b| a.sd[j].total_cmp(&b.sd[j])).unwrap_or_else(|| model.clone())
}

/// What friction may exert at each time of an episode beyond what the equation takes it for, in units of the residual.
fn uncertainty(problem: &Problem, model: &Fit, j: usize, episode: &EpisodeData) -> Vec<f64> {
    let Fit { effects, slots, values, .. } = model;
    let model = JointModel::new(problem, j, effects, slots, |slot| values[slot]);
    let wants_inertia = !model.is_linear_in_inverse_dynamics();
    let needed = inverse_dynamics_at(problem, episode, j, (effects, slots, values), wants_inertia);
    let found = model.residual(problem, j, episode, needed.as_ref());
    let size = found.per_effort.iter().copied().fold(0.0, f64::max);
    let rests = |k: usize| episode.joints[j].v[k].abs() < problem.joints[j].rest_speed;
    let one = |k: usize| if rests(k) { MAX_STICTION * size * found.friction[k] } else { 0.0 };
    (0..found.friction.len()).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::with_resting_samples;
    use crate::fit::{MAX_STEPS, fit};
    use crate::{Problem, motion, rows::Scope};
    use std::collections::BTreeMap;
    use trundle_record::{Episode, JointMetadata, JointRecording};

    /// An axis that stops once in each turn, with dry friction of 0 or more.
    fn stopping(dry: f64) -> Problem {
        let text = "format = \"trundle-recording/2\"\nname = \"bench\"\n[mechanism]\naxis = \"hinge\"\njoints = [\"arm\"]\n";
        let one = |index: usize| {
            let rate = 2.0 + 0.4 * index as f64;
            let t: Vec<f64> = (0..1600).map(|k| k as f64 * 0.005).collect();
            let noise = |k: usize| 1e-3 * ((k * 7919 + index) as f64).sin();
            let effort = |(k, t): (usize, &f64)| {
                let [v, a] = [rate * (1.0 - (rate * t).cos()), rate * rate * (rate * t).sin()];
                0.02 * a + 0.05 * v + dry * v.signum() + noise(k)
            };
            let mut episode = Episode { name: format!("episode_{index}"), ..Episode::default() };
            let angles = t.iter().map(|t| rate * t - (rate * t).sin()).collect();
            let efforts = t.iter().enumerate().map(effort).collect();
            let columns = [("t", t), ("q_arm", angles), ("effort_arm", efforts)];
            columns.into_iter().for_each(|(title, values)| episode.insert(title.to_owned(), values));
            episode
        };
        let metadata = JointMetadata::from_toml(text).unwrap();
        let recording = JointRecording::new(metadata, (0..4).map(one).collect(), BTreeMap::new()).unwrap();
        Problem::new(&recording, &motion(&recording).unwrap(), None).unwrap()
    }

    #[test]
    fn samples_at_rest_count_where_there_is_no_friction() {
        let weights = |dry: f64| -> Vec<f64> {
            let problem = stopping(dry);
            let all = with_resting_samples(&problem, &fit(&problem, &[], None, Scope::Training, MAX_STEPS));
            let weighted = all.as_ref().unwrap_or(&problem);
            let resting = problem.episodes.iter().map(|e| &e.joints[0].resting);
            let found = resting.zip(&weighted.episodes).flat_map(|(resting, episode)| {
                resting.iter().map(|k| episode.joints[0].weight[*k]).collect::<Vec<f64>>()
            });
            if all.is_some() { found.collect() } else { vec![] }
        };
        let [smooth, rough] = [weights(0.0), weights(0.2)];
        assert!(!smooth.is_empty() && smooth.iter().all(|weight| *weight > 0.9), "{smooth:?}");
        assert!(rough.iter().all(|weight| *weight < 0.1), "{rough:?}");
    }
}
