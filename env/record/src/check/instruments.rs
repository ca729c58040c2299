//! Checks of the instruments: saturated readings, lost signs and masked poses.

use super::data::EpisodeData;
use super::finding::{Finding, Severity};
use super::group::grouped;
use super::input::CheckInput;

/// Minimum number of equal extreme readings in a row. Noise makes even two unlikely.
const MIN_SATURATED_SAMPLES: usize = 5;
/// Noise relative to the range below which equal readings are normal, as in simulated or commanded plateaus.
const MIN_RELATIVE_NOISE: f64 = 1e-4;
/// Share of repeats between the extremes above which a reading is held, not saturated.
pub(crate) const MAX_REPEAT_SHARE: f64 = 0.3;
/// Minimum share of masked poses for a note.
const MIN_MASKED_SHARE_NOTE: f64 = 0.001;
/// Minimum share of masked poses for a warning.
const MIN_MASKED_SHARE_WARNING: f64 = 0.1;

/// Checks for readings at the limit of the sensor's range.
pub(crate) fn clipping(input: &CheckInput) -> Vec<Finding> {
    if input.data.dataset.commanded {
        return vec![]; // commands repeat values
    }
    let noise = &input.data.estimated_noise; // the data may not contain the stated noise
    let per_axis = |(axis, sd): (&'static str, f64)| {
        let found = input.data.episodes.iter().filter_map(move |episode| {
            let column = episode.raw.columns.get(axis)?;
            saturation(column, sd)
                .map(|(value, n)| (n as f64, saturation_finding(axis, value, n).in_episode(episode.name())))
        });
        grouped(found.collect())
    };
    let axes = [
        ("force_x", noise.force),
        ("force_y", noise.force),
        ("force_z", noise.force),
        ("torque_x", noise.torque),
        ("torque_y", noise.torque),
        ("torque_z", noise.torque),
    ];
    axes.into_iter().flat_map(per_axis).collect()
}

/// The extreme value at which a column saturates, and the number of samples in a row.
fn saturation(column: &[f64], sd: f64) -> Option<(f64, usize)> {
    let values: Vec<f64> = column.iter().copied().filter(|v| !v.is_nan()).collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if sd <= MIN_RELATIVE_NOISE * (high - low) || high <= low || holds_steps(&values, [low, high]) {
        return None;
    }
    [low, high]
        .into_iter()
        .map(|end| (end, longest_run(&values, end)))
        .find(|(_, n)| *n >= MIN_SATURATED_SAMPLES)
}

/// Whether values also repeat between the extremes, as for commands and held readings.
fn holds_steps(values: &[f64], ends: [f64; 2]) -> bool {
    let inner = |pair: &&[f64]| !ends.contains(&pair[0]);
    let pairs = values.windows(2).filter(inner).count();
    let repeats = values.windows(2).filter(inner).filter(|pair| pair[0] == pair[1]).count();
    repeats as f64 > MAX_REPEAT_SHARE * pairs.max(1) as f64
}

fn longest_run(values: &[f64], value: f64) -> usize {
    let (mut longest, mut run) = (0, 0);
    for v in values {
        run = if *v == value { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    longest
}

fn saturation_finding(axis: &str, value: f64, n: usize) -> Finding {
    let sentence =
        format!("{axis} stays at its extreme {value:.4} for {n} samples in a row: the sensor is saturated");
    Finding::new(
        "saturation",
        Severity::Warning,
        sentence,
        "push more gently, or use a sensor with a larger range: a saturated reading hides the true force",
    )
}

/// Checks for many masked poses.
pub(crate) fn masked(input: &CheckInput) -> Vec<Finding> {
    grouped(input.data.episodes.iter().filter_map(masked_in).collect())
}

fn masked_in(episode: &EpisodeData) -> Option<(f64, Finding)> {
    let counts = &episode.prepared.counts;
    let masked = counts.pose_outliers + counts.pose_held;
    let share = masked as f64 / (masked + episode.prepared.pose.len()).max(1) as f64;
    if share <= MIN_MASKED_SHARE_NOTE {
        return None;
    }
    let severity = if share > MIN_MASKED_SHARE_WARNING { Severity::Warning } else { Severity::Note };
    let sentence = format!(
        "{:.1} % of the object's poses are masked: {} are outliers, {} repeat the previous pose",
        100.0 * share,
        counts.pose_outliers,
        counts.pose_held
    );
    let remedy = "keep the tracker's markers in view, and remove held values from the table";
    Some((share, Finding::new("tracker", severity, sentence, remedy).in_episode(episode.name())))
}

/// Upper limit of values near zero in standard deviations of the noise.
const NEAR_ZERO_SD: f64 = 2.0;
/// Minimum number of values near zero, if none is negative.
const MIN_NEAR_ZERO_SAMPLES: usize = 20;

/// Checks for components without their sign. Readings near zero have both signs because of the noise.
pub(crate) fn unsigned(input: &CheckInput) -> Vec<Finding> {
    let noise = &input.data.estimated_noise;
    let axes = [("force_x", noise.force), ("force_y", noise.force), ("torque_z", noise.torque)];
    let unsigned = axes.into_iter().filter_map(|(axis, sd)| {
        let values = || input.data.episodes.iter().filter_map(move |l| l.raw.columns.get(axis)).flatten();
        let near = values().filter(|v| **v > 0.0 && **v < NEAR_ZERO_SD * sd).count();
        (near >= MIN_NEAR_ZERO_SAMPLES && !values().any(|v| *v < 0.0)).then_some((axis, near))
    });
    let found: Vec<(&str, usize)> = unsigned.collect();
    let [(_, near), ..] = found[..] else { return vec![] };
    let names: Vec<&str> = found.iter().map(|(axis, _)| *axis).collect();
    let sentence = format!(
        "{} never negative, although {near} values lie within the noise of zero: the sign is lost",
        if names.len() > 1 { format!("{} are", names.join(" and ")) } else { format!("{} is", names[0]) }
    );
    let remedy = "record the signed components of the wrench, not their magnitudes";
    vec![Finding::new("sign", Severity::Error, sentence, remedy)]
}
