//! Check for efforts at their limit.

use super::input::Input;
use super::merge::{Found, merged};
use crate::check::instruments::MAX_REPEAT_SHARE;
use crate::check::{Finding, Severity};
use crate::episode::Episode;

/// Smallest number of equal extreme efforts in a row.
const MIN_SAMPLES: usize = 5;
/// Largest change into a plateau relative to the range: a larger one is the step of a command.
const MAX_ENTRY: f64 = 0.1;
/// Smallest number of plateaus at the same extreme; one may be chance or a command that is held.
const MIN_PLATEAUS: usize = 2;

/// Checks for flat extreme efforts that are approached gradually.
pub(super) fn saturation(input: &Input) -> Vec<Finding> {
    let mut found = Vec::new();
    for joint in input.joints {
        let Some([low, high]) = extremes(input.raw, joint).filter(|[low, high]| low < high) else { continue };
        for end in [low, high] {
            let plateaus: Vec<usize> =
                input.raw.iter().flat_map(|episode| plateaus(episode, joint, end, high - low)).collect();
            // Zero is the end of a drive that pushes only, or of magnitudes.
            if plateaus.len() < MIN_PLATEAUS || end == 0.0 {
                continue;
            }
            let samples: usize = plateaus.iter().sum();
            let sentence = format!(
                "the effort of {joint} stays at its extreme {end:.4} for {samples} samples, {} times: the drive or its \
                 reading is saturated",
                plateaus.len()
            );
            let remedy =
                "record at smaller commands, or let the diagnosis estimate the limit (effort_saturation)";
            let finding = Finding::new("saturation", Severity::Warning, sentence, remedy);
            found.push(Found { size: samples as f64, joint: joint.clone(), finding });
        }
    }
    merged(found)
}

fn extremes(episodes: &[Episode], joint: &str) -> Option<[f64; 2]> {
    let values =
        episodes.iter().filter_map(|episode| Some(episode.joint_stream("effort", joint)?.1)).flatten();
    values.fold(None, |ends, value| {
        let [low, high]: [f64; 2] = ends.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}

/// Lengths of the plateaus at `end` that are approached gradually.
fn plateaus(episode: &Episode, joint: &str, end: f64, range: f64) -> Vec<usize> {
    let Some((_, effort)) = episode.joint_stream("effort", joint) else { return vec![] };
    let inner = effort.windows(2).filter(|pair| pair[0] != end);
    let (pairs, repeats) = (inner.clone().count(), inner.filter(|pair| pair[0] == pair[1]).count());
    if repeats as f64 > MAX_REPEAT_SHARE * pairs.max(1) as f64 {
        return vec![];
    }
    let mut found = Vec::new();
    let mut start = None;
    for k in 0..=effort.len() {
        match (start, effort.get(k) == Some(&end)) {
            (None, true) => start = Some(k),
            (Some(first), false) => {
                let is_gradual = first > 0 && (effort[first] - effort[first - 1]).abs() < MAX_ENTRY * range;
                if is_gradual && k - first >= MIN_SAMPLES {
                    found.push(k - first);
                }
                start = None;
            }
            _ => {}
        }
    }
    found
}
