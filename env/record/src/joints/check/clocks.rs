//! Check of the times: gaps, and jumps of the clock.

use super::input::Input;
use super::merge::{Found, merged};
use crate::check::gaps::{Gap, unexplained_gap};
use crate::check::{Finding, Severity};
use crate::episode::Episode;

/// Streams that are sampled continuously.
const SAMPLED: [&str; 3] = ["q", "v", "effort"];
/// Number of samples at each side of a gap that are compared with it.
const NEIGHBOURS: usize = 5;
/// Largest change over a jump of the clock relative to those between the samples around it.
const MAX_CHANGE_RATIO: f64 = 2.0;
/// Smallest motion at the speed around a gap relative to the change of one step.
const MIN_MOTION_RATIO: f64 = 5.0;

/// Checks for gaps in the streams and jumps of the clock.
pub(super) fn clocks(input: &Input) -> Vec<Finding> {
    let mut found = Vec::new();
    for joint in input.joints {
        for prefix in SAMPLED {
            let times = |episode: &Episode| episode.joint_stream(prefix, joint).map_or(vec![], |(t, _)| t);
            let all: Vec<Vec<f64>> = input.raw.iter().map(times).collect();
            for (episode, t) in input.raw.iter().zip(&all) {
                let Some(gap) = unexplained_gap(t, &all) else { continue };
                let finding = match clock_jump(episode, &gap) {
                    true => jump_finding(&gap),
                    false => Finding::new(
                        "gaps",
                        Severity::Warning,
                        gap.sentence(&format!("{prefix}_{joint}")),
                        "record without drop-outs, or split the episode at the gap: the motion in it is unknown",
                    ),
                };
                let finding = finding.in_episode(&episode.name);
                found.push(Found { size: gap.length(), joint: joint.clone(), finding });
            }
        }
    }
    merged(found)
}

fn jump_finding(gap: &Gap) -> Finding {
    let sentence = format!(
        "the clock jumps by {:.3} s after t = {:.2} s: the positions continue as if only {:.0} ms had passed",
        gap.length() - gap.step,
        gap.from,
        1e3 * gap.step
    );
    Finding::new(
        "clocks",
        Severity::Error,
        sentence,
        "subtract the jump from the later times, or split the episode there",
    )
}

/// Whether all streams continue over the gap as over one step, though a joint was so fast that it would have moved on.
fn clock_jump(episode: &Episode, gap: &Gap) -> bool {
    let after = episode.t.partition_point(|&time| time <= gap.from);
    let Some(first) = after.checked_sub(NEIGHBOURS) else { return false };
    let mut is_fast = false;
    for (name, column) in episode.columns.iter().filter(|(name, _)| !name.starts_with("on_")) {
        let Some(window) = column.get(first..after + NEIGHBOURS) else { return false };
        let change = |pair: &[f64]| (pair[1] - pair[0]).abs();
        let changes: Vec<f64> = window.windows(2).map(change).collect();
        let across = changes[NEIGHBOURS - 1];
        let usual = changes.iter().enumerate().filter(|(k, _)| *k != NEIGHBOURS - 1).map(|(_, c)| *c);
        let usual = usual.fold(0.0, f64::max);
        // A cell without a sample gives NaN, which continues nothing.
        if across.is_nan() || across > MAX_CHANGE_RATIO * usual {
            return false;
        }
        // The mean speed averages the noise.
        let speed = (window[2 * NEIGHBOURS - 1] - window[0]).abs() / (2 * NEIGHBOURS - 1) as f64;
        is_fast |= name.starts_with("q_") && speed * gap.length() / gap.step > MIN_MOTION_RATIO * usual;
    }
    is_fast
}
