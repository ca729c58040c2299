//! Forward simulation of an axis without a model.

use crate::drive::Drive;
use crate::equation::JointModel;
use crate::fit::Fit;
use crate::laws::JointSample;
use crate::problem::{EpisodeData, Problem};

/// Longest step, s.
const MAX_STEP_S: f64 = 1e-3;
/// Positions beyond this multiple of the recorded range count as divergence.
const MAX_RANGES: f64 = 1e3;

/// Simulated positions of an axis at the times of samples `from..to` of an episode, from a state at `from`. NaN after a
/// divergence; `None` if a law of the model cannot be simulated.
pub(crate) fn simulate(
    problem: &Problem,
    fit: &Fit,
    episode: &EpisodeData,
    (from, to): (usize, usize),
    state: [f64; 2],
) -> Option<Vec<f64>> {
    let effects = fit.fitted_effects();
    let model = JointModel::new(problem, 0, &effects, &fit.slots, |k| fit.values[k]);
    if !model.can_be_simulated() {
        return None;
    }
    let (setup, series) = (&problem.joints[0], &episode.joints[0]);
    let commands = model.commands(series, episode.dt);
    let steps = (episode.dt / MAX_STEP_S).ceil().max(1.0);
    let dt = episode.dt / steps;
    let [mut q, mut v] = state;
    let mut found = Vec::with_capacity(to - from);
    let limit = MAX_RANGES * setup.scales.span();
    for k in from..to {
        found.push(if (q - state[0]).abs() < limit { q } else { f64::NAN });
        let next = (k + 1).min(series.q.len() - 1);
        for step in 0..steps as usize {
            let share = (step as f64 + 0.5) / steps;
            let mix = |a: f64, b: f64| a + share * (b - a);
            // Held commands are brought to the middle of their intervals, see [`crate::resample::held`]: to hold them again
            // would delay them.
            let [command, known, on] = [&commands, &series.known, &series.on].map(|of| mix(of[k], of[next]));
            let drive = model.drive_effort(setup, series, command, [q, v, on]);
            let drive = (setup.drive != Drive::None).then_some(drive);
            let load = series.load.as_ref().map(|load| load[k]);
            let at = JointSample { q, v, a: 0.0, drive, external: known + model.gravity_at(q), load };
            [q, v] = model.step(&at, known, on, dt);
        }
    }
    Some(found)
}
