//! Clipped readings, and samples that the tracker made up or left out.

use super::subject::{Look, Subject};
use super::{Finding, Severity};

/// This many equal extreme readings in a row are clipped, where noise makes even two unlikely.
const CLIPPED: usize = 5;
/// Noise relative to the range below which equal readings are no wonder: simulated or commanded plateaus.
const NOISELESS: f64 = 1e-4;
/// Share of masked poses that deserves a word, and one that casts doubt.
const MASKED: [f64; 2] = [0.001, 0.1];

/// Readings that stand still at the end of the sensor's range.
pub(crate) fn clipping(subject: &Subject) -> Vec<Finding> {
    let noise = &subject.seen_noise; // stated noise may not be in the data
    let per_axis = |(axis, sd): (&'static str, f64)| {
        subject.episodes.iter().filter_map(move |look| {
            let column = look.episode.columns.get(axis)?;
            clipped(column, sd).map(|(value, n)| saturated(axis, value, n).of(look.name()))
        })
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

/// The extreme value at which a column stands, and for how many samples in a row.
fn clipped(column: &[f64], sd: f64) -> Option<(f64, usize)> {
    let values: Vec<f64> = column.iter().copied().filter(|v| !v.is_nan()).collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if sd <= NOISELESS * (high - low) || high <= low {
        return None;
    }
    [low, high].into_iter().map(|end| (end, longest_run(&values, end))).find(|(_, n)| *n >= CLIPPED)
}

fn longest_run(values: &[f64], value: f64) -> usize {
    let (mut longest, mut run) = (0, 0);
    for v in values {
        run = if *v == value { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    longest
}

fn saturated(axis: &str, value: f64, n: usize) -> Finding {
    let sentence =
        format!("{axis} stands at its extreme {value:.4} for {n} samples in a row: the sensor is saturated");
    Finding::new(
        "saturation",
        Severity::Warning,
        sentence,
        "push more gently or choose a larger range; a clipped force hides what the object felt",
    )
}

/// Masked and missing samples.
pub(crate) fn masked(subject: &Subject) -> Vec<Finding> {
    subject.episodes.iter().filter_map(masked_in).collect()
}

fn masked_in(look: &Look) -> Option<Finding> {
    let counts = &look.prepared.counts;
    let made_up = counts.pose_outliers + counts.pose_held;
    let share = made_up as f64 / (made_up + look.prepared.pose.len()).max(1) as f64;
    if share <= MASKED[0] {
        return None;
    }
    let severity = if share > MASKED[1] { Severity::Warning } else { Severity::Note };
    let sentence = format!(
        "{:.1} % of the object's poses are masked: {} jump away from its path, {} repeat the pose before",
        100.0 * share,
        counts.pose_outliers,
        counts.pose_held
    );
    let remedy = "see that the tracker's markers stay in view, and leave held values out of the table";
    Some(Finding::new("tracker", severity, sentence, remedy).of(look.name()))
}
