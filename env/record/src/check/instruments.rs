//! Clipped readings, and samples that the tracker made up or left out.

use super::group::grouped;
use super::subject::{Look, Subject};
use super::{Finding, Severity};

/// This many equal extreme readings in a row are clipped, where noise makes even two unlikely.
const CLIPPED: usize = 5;
/// Noise relative to the range below which equal readings are no wonder: simulated or commanded plateaus.
const NOISELESS: f64 = 1e-4;
/// Share of repeats between the extremes from which on a reading is held, not clipped.
const HELD: f64 = 0.3;
/// Share of masked poses that deserves a word, and one that casts doubt.
const MASKED: [f64; 2] = [0.001, 0.1];

/// Readings that stand still at the end of the sensor's range.
pub(crate) fn clipping(subject: &Subject) -> Vec<Finding> {
    if subject.dataset.commanded {
        return vec![]; // a command holds its steps
    }
    let noise = &subject.seen_noise; // stated noise may not be in the data
    let per_axis = |(axis, sd): (&'static str, f64)| {
        let found = subject.episodes.iter().filter_map(move |look| {
            let column = look.episode.columns.get(axis)?;
            clipped(column, sd).map(|(value, n)| (n as f64, saturated(axis, value, n).of(look.name())))
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

/// The extreme value at which a column stands, and for how many samples in a row.
fn clipped(column: &[f64], sd: f64) -> Option<(f64, usize)> {
    let values: Vec<f64> = column.iter().copied().filter(|v| !v.is_nan()).collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if sd <= NOISELESS * (high - low) || high <= low || holds_steps(&values, [low, high]) {
        return None;
    }
    [low, high].into_iter().map(|end| (end, longest_run(&values, end))).find(|(_, n)| *n >= CLIPPED)
}

/// Whether values repeat between the extremes too: a command, or a reading that is held.
fn holds_steps(values: &[f64], ends: [f64; 2]) -> bool {
    let inner = |pair: &&[f64]| !ends.contains(&pair[0]);
    let pairs = values.windows(2).filter(inner).count();
    let repeats = values.windows(2).filter(inner).filter(|pair| pair[0] == pair[1]).count();
    repeats as f64 > HELD * pairs.max(1) as f64
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
    grouped(subject.episodes.iter().filter_map(masked_in).collect())
}

fn masked_in(look: &Look) -> Option<(f64, Finding)> {
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
    Some((share, Finding::new("tracker", severity, sentence, remedy).of(look.name())))
}

/// Values this near to zero, in standard deviations of the noise, and how many without a negative one.
const NEAR_ZERO: (f64, usize) = (2.0, 20);

/// Components without their sign: a reading that comes within its noise of zero has values on both sides of it.
pub(crate) fn unsigned(subject: &Subject) -> Vec<Finding> {
    let noise = &subject.seen_noise;
    let axes = [("force_x", noise.force), ("force_y", noise.force), ("torque_z", noise.torque)];
    let folded = axes.into_iter().filter_map(|(axis, sd)| {
        let values = || subject.episodes.iter().filter_map(move |l| l.episode.columns.get(axis)).flatten();
        let near = values().filter(|v| **v > 0.0 && **v < NEAR_ZERO.0 * sd).count();
        (near >= NEAR_ZERO.1 && !values().any(|v| *v < 0.0)).then_some((axis, near))
    });
    let found: Vec<(&str, usize)> = folded.collect();
    let [(_, near), ..] = found[..] else { return vec![] };
    let names: Vec<&str> = found.iter().map(|(axis, _)| *axis).collect();
    let sentence = format!(
        "{} never negative, though {near} values lie within the noise of zero: the sign is lost",
        if names.len() > 1 { format!("{} are", names.join(" and ")) } else { format!("{} is", names[0]) }
    );
    let remedy = "record the components of the force with their sign, not magnitudes";
    vec![Finding::new("sign", Severity::Error, sentence, remedy)]
}
