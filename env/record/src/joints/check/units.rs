//! Check of the unit of positions and targets.

use std::f64::consts::PI;

use super::input::Input;
use super::merge::{Found, merged};
use crate::check::{Finding, Severity};
use crate::joints::drive::EncoderSide;

/// Largest position that is more likely in degrees than in radians, if it lies beyond two turns in radians.
const MAX_DEGREES: f64 = 370.0;
/// Smallest position in radians that is suspicious: joints of arms and pendulums turn less than twice.
const MIN_DEGREES: f64 = 4.0 * PI;
/// Smallest number of reversals: a motor that turns on and on has positions of any size.
const MIN_REVERSALS: usize = 2;
/// Smallest swing between reversals in radians that counts.
const MIN_SWING: f64 = 2.0 * PI;
/// Relative deviation up to which the scale of a target is that of degrees.
const SCALE_TOLERANCE: f64 = 0.2;

/// Smallest correlation of target and position at which their scales are compared.
const MIN_CORRELATION: f64 = 0.5;

/// Checks for positions or targets in degrees.
pub(super) fn degrees(input: &Input) -> Vec<Finding> {
    let all = 0..input.joints.len();
    merged(
        all.filter_map(|index| target_scale(input, index).or_else(|| swings_in_degrees(input, index)))
            .collect(),
    )
}

/// Whether the positions of joint `index` look like degrees.
pub(super) fn looks_like_degrees(input: &Input, index: usize) -> bool {
    target_scale(input, index).is_some() || swings_in_degrees(input, index).is_some()
}

fn swings_in_degrees(input: &Input, index: usize) -> Option<Found> {
    let joint = &input.joints[index];
    if !input.may_be_hinge() || input.metadata.encoder_side_of(joint) == EncoderSide::Drive {
        return None;
    }
    let series: Vec<Vec<f64>> =
        input.raw.iter().filter_map(|episode| Some(episode.joint_stream("q", joint)?.1)).collect();
    let largest = series.iter().flatten().fold(0.0, |a: f64, q| a.max(q.abs()));
    let swings = series.iter().map(|q| reversals(q)).sum::<usize>();
    if !(MIN_DEGREES..=MAX_DEGREES).contains(&largest) || swings < MIN_REVERSALS {
        return None;
    }
    let turns = largest / (2.0 * PI);
    let sentence = format!(
        "the position of {joint} swings back and forth up to {largest:.1}, which is {turns:.1} turns in radians: it looks \
         like degrees"
    );
    let remedy = format!("convert q_{joint}, its target and its velocity to radians (multiply by pi / 180)");
    let finding = Finding::new("units", Severity::Warning, sentence, &remedy);
    Some(Found { size: largest, joint: joint.clone(), finding })
}

/// Number of changes of direction after a swing of at least [`MIN_SWING`].
fn reversals(q: &[f64]) -> usize {
    let Some(&first) = q.first() else { return 0 };
    let (mut low, mut high, mut direction, mut count) = (first, first, 0, 0);
    for &q in q {
        (low, high) = (low.min(q), high.max(q));
        if direction >= 0 && q < high - MIN_SWING {
            count += usize::from(direction > 0);
            (direction, low, high) = (-1, q, q);
        } else if direction <= 0 && q > low + MIN_SWING {
            count += usize::from(direction < 0);
            (direction, low, high) = (1, q, q);
        }
    }
    count
}

/// A target in another unit than the positions.
fn target_scale(input: &Input, index: usize) -> Option<Found> {
    let joint = &input.joints[index];
    let mut squares = [0.0; 3];
    for episode in &input.episodes {
        let track = &episode.tracks[index];
        let Some(target) = track.stream(episode.episode, "target", joint, true) else { continue };
        for (x, q) in target.iter().zip(&track.q) {
            squares = [squares[0] + x * q, squares[1] + x * x, squares[2] + q * q];
        }
    }
    let [product, targets, positions] = squares;
    let correlation = product / (targets * positions).sqrt();
    let scale = (targets / positions).sqrt();
    let is_degrees = |scale: f64| (scale * PI / 180.0 - 1.0).abs() < SCALE_TOLERANCE;
    let words = if is_degrees(scale) {
        "the targets look like degrees, and the positions like radians"
    } else if is_degrees(1.0 / scale) {
        "the positions look like degrees, and the targets like radians"
    } else {
        return None;
    };
    if correlation.is_nan() || correlation.abs() < MIN_CORRELATION {
        return None;
    }
    let sentence = format!("the target of {joint} is {scale:.4} times its position: {words}");
    let finding = Finding::new(
        "units",
        Severity::Error,
        sentence,
        "convert both to radians (multiply degrees by pi / 180)",
    );
    Some(Found { size: scale.ln().abs(), joint: joint.clone(), finding })
}
