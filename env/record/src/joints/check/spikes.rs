//! Check for isolated wrong samples.

use super::input::Input;
use super::merge::{Found, merged};
use crate::check::{Finding, Severity};
use crate::prepare::quantile;

/// Streams that are measured or computed sample by sample.
const SAMPLED: [&str; 3] = ["q", "v", "effort"];
/// Share of the samples that is regular.
const REGULAR_SHARE: f64 = 0.99;
/// Smallest size of a wrong sample relative to the regular ones. Impacts last several samples, and are smaller.
const MIN_SIZE: f64 = 5.0;

/// Samples at each side that are compared.
const NEIGHBOURS: usize = 4;

/// Checks for single samples that are far from those around them.
pub(super) fn spikes(input: &Input) -> Vec<Finding> {
    let mut found = Vec::new();
    for (joint, prefix) in input.joints.iter().flat_map(|joint| SAMPLED.map(|prefix| (joint, prefix))) {
        let series: Vec<_> =
            input.raw.iter().filter_map(|e| Some((&e.name, e.joint_stream(prefix, joint)?))).collect();
        // Over all episodes, because a joint may rest in some.
        let values = || series.iter().flat_map(|(_, (_, values))| values.iter().copied());
        let center = quantile(values(), 0.5).unwrap_or(0.0);
        let regular = quantile(values().map(|value| (value - center).abs()), REGULAR_SHARE).unwrap_or(0.0);
        for (episode, (t, values)) in &series {
            let deviation = |k: usize| (values[k] - local_median(values, k)).abs();
            let wrong: Vec<usize> =
                (0..values.len()).filter(|&k| deviation(k) > MIN_SIZE * regular).collect();
            let Some(&first) = wrong.first().filter(|_| regular > 0.0) else { continue };
            let finding = finding(&format!("{prefix}_{joint}"), wrong.len(), t[first], values[first]);
            found.push(Found {
                size: wrong.len() as f64,
                joint: joint.clone(),
                finding: finding.in_episode(episode),
            });
        }
    }
    merged(found)
}

fn finding(column: &str, count: usize, t: f64, value: f64) -> Finding {
    let sentence = format!(
        "{column} has {count} samples that leave those around them by more than {MIN_SIZE} times the usual range, first \
         {value:.4} at t = {t:.3} s"
    );
    let remedy =
        "remove these samples (a wrapped register, a transmission error), and leave their cells empty";
    Finding::new("outliers", Severity::Warning, sentence, remedy)
}

/// Median of the samples around sample `k`.
fn local_median(values: &[f64], k: usize) -> f64 {
    let window = &values[k.saturating_sub(NEIGHBOURS)..(k + NEIGHBOURS + 1).min(values.len())];
    quantile(window.iter().copied(), 0.5).unwrap_or(0.0)
}
