//! Check for encoders that stop reporting.

use super::input::Input;
use super::merge::{Found, merged};
use crate::check::{Finding, Severity};
use crate::episode::Episode;

/// Smallest length of a frozen stretch in samples.
const MIN_FROZEN_SAMPLES: usize = 10;
/// Smallest jump after a frozen stretch relative to the largest change between other samples.
const MIN_JUMP_RATIO: f64 = 3.0;
/// Smallest range of a target relative to its range in all episodes, for a joint that ought to move.
const MIN_TARGET_SHARE: f64 = 0.3;

/// Checks for positions that stay exactly constant while the joint moves.
pub(super) fn frozen(input: &Input) -> Vec<Finding> {
    let mut found = Vec::new();
    for joint in input.joints {
        let moves = input.raw.iter().any(|episode| range(episode, "q", joint) > 0.0);
        for episode in input.raw {
            let sentence = stuck(episode, joint).or_else(|| {
                (moves && dead(input, episode, joint)).then(|| {
                    format!("the position of {joint} never changes, though its target or velocity does")
                })
            });
            let Some(sentence) = sentence else { continue };
            let remedy = "check the encoder and its cable, and remove the episode or the stretch";
            let finding = Finding::new("frozen", Severity::Error, sentence, remedy).in_episode(&episode.name);
            found.push(Found { size: 1.0, joint: joint.clone(), finding });
        }
    }
    merged(found)
}

/// A stretch of equal positions that ends with a jump: the joint has moved meanwhile.
fn stuck(episode: &Episode, joint: &str) -> Option<String> {
    let (t, q) = episode.joint_stream("q", joint)?;
    let mut start = 0;
    let mut largest: Option<(usize, usize, f64)> = None;
    for k in 1..q.len() {
        if q[k] == q[start] {
            continue;
        }
        let jump = (q[k] - q[k - 1]).abs();
        if k - start >= MIN_FROZEN_SAMPLES && largest.is_none_or(|(_, _, size)| jump > size) {
            largest = Some((start, k, jump));
        }
        start = k;
    }
    let (start, end, jump) = largest?;
    let others = (1..q.len()).filter(|&k| k != end).map(|k| (q[k] - q[k - 1]).abs()).fold(0.0, f64::max);
    (others > 0.0 && jump > MIN_JUMP_RATIO * others).then(|| {
        format!(
            "the position of {joint} stays at {:.4} for {:.2} s from t = {:.2} s on, and then jumps by {jump:.3}",
            q[start],
            t[end - 1] - t[start],
            t[start]
        )
    })
}

/// Whether the position is constant in an episode in which the target or the velocity moves as in others.
fn dead(input: &Input, episode: &Episode, joint: &str) -> bool {
    let is_constant = episode.joint_stream("q", joint).is_some_and(|(_, q)| q.len() >= MIN_FROZEN_SAMPLES)
        && range(episode, "q", joint) == 0.0;
    let moves = |prefix: &str| {
        let most = input.raw.iter().map(|other| range(other, prefix, joint)).fold(0.0, f64::max);
        most > 0.0 && range(episode, prefix, joint) > MIN_TARGET_SHARE * most
    };
    is_constant && (moves("target") || moves("v"))
}

fn range(episode: &Episode, prefix: &str, joint: &str) -> f64 {
    let values = episode.joint_stream(prefix, joint).map_or(vec![], |(_, values)| values);
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (high - low).max(0.0)
}
