//! Check of measured velocities against the derivative of the positions.

use super::dynamics::{Rows, Terms};
use super::input::Input;
use super::merge::{Found, merged};
use super::regression::Regressors;
use super::shifts;
use super::units::looks_like_degrees;
use crate::check::{Finding, Severity};

/// Largest delay that is tried, s.
const MAX_DELAY_S: f64 = 0.25;
/// Smallest factor by which a delay reduces the misfit.
const MIN_DELAY_GAIN: f64 = 1.5;
/// Smallest delay in steps of the positions. Velocities fit the positions to a small fraction of a step.
const MIN_STEPS: f64 = 0.5;
/// Largest misfit at which delay and scale are reported: the velocity is that of this joint.
const MAX_UNEXPLAINED: f64 = 0.2;
/// Smallest deviation of the scale from 1. Filters of drives change the scale by less.
const MIN_SCALE_DEVIATION: f64 = 0.05;
/// Scales with a name, and what to do.
const SCALES: [(f64, &str); 4] = [
    (180.0 / std::f64::consts::PI, "degrees per second with positions in radians"),
    (std::f64::consts::PI / 180.0, "radians per second with positions in degrees"),
    (60.0 / std::f64::consts::TAU, "revolutions per minute"),
    (1.0 / std::f64::consts::TAU, "revolutions per second"),
];

/// Checks scale and delay of the velocities.
pub(super) fn velocity(input: &Input) -> Vec<Finding> {
    let (mut late, mut scaled) = (vec![], vec![]);
    for (index, joint) in input.joints.iter().enumerate() {
        let (v_noise, v_rms) = input.speeds(index);
        if v_rms <= 5.0 * v_noise {
            continue;
        }
        let Some((shift, scale)) = compared(input, index) else { continue };
        // Positions in degrees are one cause, which has its own finding.
        if (scale - 1.0).abs() > MIN_SCALE_DEVIATION && !looks_like_degrees(input, index) {
            let finding = scale_finding(joint, scale);
            scaled.push(Found { size: scale.ln().abs(), joint: joint.clone(), finding });
        }
        // The stream is late where the motion precedes it.
        let stated = input.metadata.delay_of("v", joint) - input.metadata.delay_of("q", joint);
        let delay = -shift.delay - stated;
        let [without, with] = shift.unexplained;
        let is_clear = without > MIN_DELAY_GAIN * with || stated != 0.0;
        if is_clear && delay.abs() > MIN_STEPS * input.step() && delay.abs() > 5.0 * shift.sd {
            let finding = delay_finding(joint, delay, stated);
            late.push(Found { size: delay.abs(), joint: joint.clone(), finding });
        }
    }
    [merged(scaled), merged(late)].concat()
}

/// The best shift of the recorded velocity, and its scale there.
fn compared(input: &Input, index: usize) -> Option<(shifts::Shift, f64)> {
    let joint = &input.joints[index];
    let streams: Vec<Option<Vec<f64>>> = input
        .episodes
        .iter()
        .map(|episode| episode.tracks[index].stream(episode.episode, "v", joint, false))
        .collect();
    let step = input.step();
    let points = (MAX_DELAY_S / step).ceil() as usize;
    let rows = Rows::new(input, index, &|episode| streams[episode].is_some(), points, Terms::Constant)?;
    let motion: Vec<f64> = rows.points.iter().map(|&(e, k)| input.episodes[e].tracks[index].v[k]).collect();
    let regressors = Regressors::new(&[motion, vec![1.0; rows.points.len()]])?;
    let independent = regressors.fit(&rows.pick(&streams, 0)).independent_rows;
    let stride = (points / 50).max(1) as isize;
    let unexplained = |shift: isize| regressors.unexplained(&rows.pick(&streams, shift));
    let shift = shifts::best(unexplained, points as isize, stride, step, independent)?;
    let at = regressors.fit(&rows.pick(&streams, (shift.delay / step).round() as isize));
    (at.unexplained < MAX_UNEXPLAINED).then_some((shift, at.coefficients[0]))
}

fn scale_finding(joint: &str, scale: f64) -> Finding {
    let named = SCALES.iter().find(|(known, _)| (scale.abs() / known - 1.0).abs() < MIN_SCALE_DEVIATION);
    let guess = named.map_or(String::new(), |(_, name)| format!(", as {name} would be"));
    let sentence =
        format!("the velocity of {joint} is {scale:.4} times the derivative of its positions{guess}");
    let remedy = if scale < 0.0 {
        format!("reverse the sign of v_{joint} or of q_{joint}, and check the sign of the effort")
    } else {
        format!("divide v_{joint} by {scale:.4}, or correct the unit of the positions (rad, m)")
    };
    Finding::new("units", Severity::Error, sentence, &remedy)
}

fn delay_finding(joint: &str, delay: f64, stated: f64) -> Finding {
    let word = if delay > 0.0 { "lags" } else { "leads" };
    let already = if stated == 0.0 {
        String::new()
    } else {
        format!(", in addition to the stated {:.1} ms", 1e3 * stated)
    };
    let sentence =
        format!("the velocity of {joint} {word} its positions by {:.1} ms{already}", 1e3 * delay.abs());
    let total = delay + stated;
    let remedy =
        format!("set [delay] v = {{\"{joint}\" = {total:.4}}}, or leave out v_{joint}: positions suffice");
    Finding::new("velocity", Severity::Warning, sentence, &remedy)
}
