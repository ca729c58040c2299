//! Check of the delay between the command of a drive (effort or target) and the motion.

use super::dynamics::{Rows, Terms};
use super::input::Input;
use super::merge::{Found, merged};
use super::shifts::{self, Shift};
use crate::check::{Finding, Severity};

/// Largest delay that is tried, s.
const MAX_DELAY_S: f64 = 0.25;
/// Largest misfit at the best delay: above, something else than a delay is missing.
const MAX_UNEXPLAINED: f64 = 0.3;
/// Smallest factor by which the delay reduces the misfit. Friction, play and loads, which the regression describes coarsely,
/// mimic delays that reduce it by less.
const MIN_GAIN: f64 = 2.0;
/// Smallest delay in its standard deviations. In simulated clean recordings noise and friction mimic up to 14.
const MIN_SD: f64 = 15.0;
/// Smallest delay in steps of the positions: a sample-and-hold shifts it by half a step.
const MIN_STEPS: f64 = 1.0;

/// Checks whether efforts or targets are early or late.
pub(super) fn command_lag(input: &Input) -> Vec<Finding> {
    let (mut efforts, mut targets) = (vec![], vec![]);
    for (index, joint) in input.joints.iter().enumerate() {
        let (prefix, list) = match input.has_signed_effort(joint) {
            true => ("effort", &mut efforts),
            false => ("target", &mut targets),
        };
        let Some(shift) = best_shift(input, index, prefix) else { continue };
        let stated = input.metadata.delay_of(prefix, joint) - input.metadata.delay_of("q", joint);
        // Positive: the motion follows the command; a stated delay of the stream makes it appear early.
        let delay = shift.delay + stated;
        let [without, with] = shift.unexplained;
        let is_clear = with < MAX_UNEXPLAINED && (without > MIN_GAIN * with || stated != 0.0);
        if is_clear && delay.abs() > MIN_STEPS * input.step() && delay.abs() > MIN_SD * shift.sd {
            let finding = delay_finding(joint, prefix, delay, shift.sd);
            list.push(Found { size: delay.abs(), joint: joint.clone(), finding });
        }
    }
    [merged(efforts), merged(targets)].concat()
}

fn best_shift(input: &Input, index: usize, prefix: &str) -> Option<Shift> {
    let joint = &input.joints[index];
    let (v_noise, v_rms) = input.speeds(index);
    let streams: Vec<Option<Vec<f64>>> = input
        .episodes
        .iter()
        .map(|episode| match prefix {
            "effort" => episode.effort(input.metadata, index, joint),
            _ => episode.tracks[index].stream(episode.episode, prefix, joint, true),
        })
        .collect();
    let step = input.step();
    let points = (MAX_DELAY_S / step).ceil() as usize;
    let terms = if prefix == "target" { Terms::AllAndPosition } else { Terms::All };
    let uses = |episode: usize| streams[episode].is_some();
    let rows = Rows::new(input, index, &uses, points, terms).filter(|_| v_rms > 5.0 * v_noise)?;
    let independent = rows.regressors.fit(&rows.pick(&streams, 0)).independent_rows;
    let stride = (points / 50).max(1) as isize;
    let unexplained = |shift: isize| rows.regressors.unexplained(&rows.pick(&streams, shift));
    shifts::best(unexplained, points as isize, stride, step, independent)
}

fn delay_finding(joint: &str, prefix: &str, delay: f64, sd: f64) -> Finding {
    let (size, sd) = (1e3 * delay.abs(), 1e3 * sd);
    let sentence = match (delay > 0.0, prefix) {
        (true, _) => format!(
            "the motion of {joint} follows its {prefix} by {size:.1} ± {sd:.1} ms: a delay, dry friction, play or \
             elasticity of the transmission"
        ),
        (false, _) => format!("the {prefix} of {joint} is recorded {size:.1} ± {sd:.1} ms late"),
    };
    let remedy = match delay > 0.0 {
        true => "find the cause with `trundle diagnose`, or correct the clock of the command",
        false => "state it in [delay], or let the diagnosis estimate it",
    };
    Finding::new("clocks", Severity::Warning, sentence, remedy)
}
