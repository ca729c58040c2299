//! Check whether the motion can tell effects apart.

use super::input::Input;
use super::merge::{Found, merged};
use crate::check::{Finding, Severity};
use crate::prepare::quantile;

/// Smallest range of a joint in noise standard deviations.
const MIN_RANGE_SD: f64 = 10.0;
/// Smallest speed in noise standard deviations that counts as motion.
const MIN_SPEED_SD: f64 = 5.0;
/// Smallest share of the moving time in the rarer direction.
const MIN_REVERSED_SHARE: f64 = 0.02;
/// Smallest ratio of the 90 % to the 10 % quantile of the speeds while the joint moves.
const MIN_SPEED_RATIO: f64 = 1.5;

/// Checks range, directions and speeds of each joint over the training episodes.
pub(super) fn excitation(input: &Input) -> Vec<Finding> {
    let (mut still, mut one_way, mut one_speed) = (vec![], vec![], vec![]);
    for (index, joint) in input.joints.iter().enumerate() {
        let tracks = || input.episodes.iter().filter(|one| one.is_training).map(|one| &one.tracks[index]);
        let noise = tracks().map(|track| track.noise).fold(0.0, f64::max);
        let range = tracks().map(|track| span(&track.q)).fold(0.0, f64::max);
        if tracks().next().is_none() {
            continue;
        }
        let push = |list: &mut Vec<Found>, sentence: String, remedy: &str| {
            let finding = Finding::new("excitation", Severity::Warning, sentence, remedy);
            list.push(Found { size: 1.0 / (range + f64::MIN_POSITIVE), joint: joint.clone(), finding });
        };
        if range <= MIN_RANGE_SD * noise {
            let sentence = format!(
                "{joint} moves by {range:.2e} in the training episodes, less than ten times its noise of {noise:.1e}"
            );
            push(
                &mut still,
                sentence,
                "move the joint, or leave it out of [mechanism] joints: it is then locked",
            );
            continue;
        }
        let (v_noise, v_rms) = input.speeds(index);
        let slow = (MIN_SPEED_SD * v_noise).max(0.1 * v_rms);
        let moving: Vec<f64> =
            tracks().flat_map(|t| t.v.iter().copied()).filter(|v| v.abs() > slow).collect();
        if moving.is_empty() {
            continue;
        }
        let forward = moving.iter().filter(|v| **v > 0.0).count() as f64 / moving.len() as f64;
        if forward.min(1.0 - forward) < MIN_REVERSED_SHARE {
            let sentence = format!("{joint} moves in one direction only in the training episodes");
            push(
                &mut one_way,
                sentence,
                "reverse the motion: friction and a bias of the effort look the same in one direction",
            );
        }
        let speed = |share| quantile(moving.iter().map(|v| v.abs()), share).unwrap_or(0.0);
        let (low, high) = (speed(0.1), speed(0.9));
        if high < MIN_SPEED_RATIO * low {
            let sentence =
                format!("{joint} moves at one speed only, {low:.3} to {high:.3} rad/s (slide: m/s)");
            push(
                &mut one_speed,
                sentence,
                "record several speeds: viscous and dry friction look the same at one speed",
            );
        }
    }
    [merged(still), merged(one_way), merged(one_speed)].concat()
}

fn span(values: &[f64]) -> f64 {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (high - low).max(0.0)
}
