//! Check for lists in another order than the joints.

use super::input::Input;
use crate::check::{Finding, Severity};

/// Smallest correlation with the motion of another joint.
const MIN_OTHER: f64 = 0.9;
/// Largest correlation with the motion of the joint itself. Joints that move together keep a higher one.
const MAX_OWN: f64 = 0.6;

/// Checks whether targets and velocities belong to other joints.
pub(super) fn order(input: &Input) -> Vec<Finding> {
    [("target", "positions"), ("v", "velocities")]
        .into_iter()
        .filter_map(|(prefix, of)| permuted(input, prefix, of))
        .collect()
}

fn permuted(input: &Input, prefix: &str, of: &str) -> Option<Finding> {
    let n = input.joints.len();
    let mut pairs = Vec::new();
    for index in 0..n {
        let correlations: Vec<f64> = (0..n).map(|other| correlation(input, prefix, index, other)).collect();
        let best = (0..n).max_by(|&a, &b| correlations[a].total_cmp(&correlations[b]))?;
        if best != index && correlations[best] > MIN_OTHER && correlations[index].abs() < MAX_OWN {
            let (own, other) = (&input.joints[index], &input.joints[best]);
            let (r, own_r) = (correlations[best], correlations[index]);
            pairs.push(format!(
                "{prefix}_{own} follows the {of} of {other} (correlation {r:.2}, own {own_r:.2})"
            ));
        }
    }
    if pairs.is_empty() {
        return None;
    }
    let sentence =
        format!("the columns {prefix}_* are in another order than the joints: {}", pairs.join(", "));
    let remedy = format!(
        "give each {prefix} column the name of its joint; logs often list them in the order of a message"
    );
    Some(Finding::new("order", Severity::Error, sentence, &remedy))
}

/// Correlation of a stream of joint `index` with the motion of joint `other`, over all episodes.
fn correlation(input: &Input, prefix: &str, index: usize, other: usize) -> f64 {
    let mut sums = [0.0; 3];
    for episode in &input.episodes {
        let held = prefix == "target";
        let own = &episode.tracks[index];
        let Some(values) = own.stream(episode.episode, prefix, &input.joints[index], held) else { continue };
        let track = &episode.tracks[other];
        let motion = if held { &track.q } else { &track.v };
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let (a, b) = (mean(&values), mean(motion));
        for (x, y) in values.iter().zip(motion) {
            let (x, y) = (x - a, y - b);
            sums = [sums[0] + x * y, sums[1] + x * x, sums[2] + y * y];
        }
    }
    let size = (sums[1] * sums[2]).sqrt();
    if size > 0.0 { sums[0] / size } else { 0.0 }
}
