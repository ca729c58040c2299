//! Check for lists in another order than the joints.

use std::collections::BTreeMap;

use super::dynamics::{Rows, Terms};
use super::input::Input;
use crate::check::{Finding, Severity};

/// Smallest correlation with the motion of another joint.
const MIN_OTHER: f64 = 0.9;
/// Largest correlation with the motion of the joint itself. Joints that move together keep a higher one.
const MAX_OWN: f64 = 0.6;
/// Largest share of an effort that the motion of another joint leaves unexplained, relative to that of the joint itself:
/// geometric mean of the exchanged joints.
const MAX_EXCHANGED: f64 = 0.5;

/// Checks whether targets, velocities and efforts belong to the positions of other joints.
pub(super) fn order(input: &Input) -> Vec<Finding> {
    let streams = [
        ("target", correlated(input, "target", "positions")),
        ("v", correlated(input, "v", "velocities")),
        ("effort", exchanged_efforts(input)),
    ];
    let found: Vec<_> = streams.into_iter().filter(|(_, pairs)| !pairs.is_empty()).collect();
    let prefixes: Vec<&str> = found.iter().map(|(prefix, _)| *prefix).collect();
    // If efforts and another stream disagree with the positions, the positions are wrong.
    let columns = match prefixes[..] {
        [] => return vec![],
        [_, .., "effort"] => "q_*".to_owned(),
        _ => prefixes.iter().map(|prefix| format!("{prefix}_*")).collect::<Vec<_>>().join(" and "),
    };
    let pairs: Vec<String> = found.into_iter().flat_map(|(_, pairs)| pairs).collect();
    let sentence =
        format!("the columns {columns} are in another order than the joints: {}", pairs.join(", "));
    let which = match prefixes[..] {
        ["effort"] => "each effort column (or each q column: efforts alone do not tell)",
        _ => "each of these columns",
    };
    let remedy =
        format!("give {which} the name of its joint; logs often list them in the order of a message");
    vec![Finding::new("order", Severity::Error, sentence, &remedy)]
}

/// Efforts that the motion of another joint explains better. Efforts and joints form a cycle: an exchanged pair, or more.
fn exchanged_efforts(input: &Input) -> Vec<String> {
    let unexplained = unexplained_shares(input);
    let share_of = |effort: usize, motion: usize| unexplained.get(&motion)?[effort];
    let best_motion = |effort: usize| {
        let shares = unexplained.keys().filter_map(|&motion| Some((motion, share_of(effort, motion)?)));
        shares.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(effort, |(motion, _)| motion)
    };
    let best: Vec<usize> = (0..input.joints.len()).map(best_motion).collect();
    let ratio = |effort: usize| Some(share_of(effort, best[effort])? / share_of(effort, effort)?);
    let is_exchanged = |effort: &usize| {
        let cycle = cycle(&best, *effort);
        let ratios: Option<Vec<f64>> = cycle.iter().map(|&effort| ratio(effort)).collect();
        let product = ratios.map_or(1.0, |ratios| ratios.iter().product::<f64>());
        cycle.len() > 1 && product < MAX_EXCHANGED.powi(cycle.len() as i32)
    };
    let words = |effort: usize| {
        let [share, own] = [best[effort], effort].map(|motion| Some(100.0 * share_of(effort, motion)?));
        let (joint, other, share, own) = (&input.joints[effort], &input.joints[best[effort]], share?, own?);
        Some(format!(
            "the motion of {other} leaves {share:.2} % of effort_{joint} unexplained, its own {own:.2} %"
        ))
    };
    (0..input.joints.len()).filter(is_exchanged).filter_map(words).collect()
}

/// The elements that lead from `start` back to it; empty if none do.
fn cycle(next: &[usize], start: usize) -> Vec<usize> {
    let mut all = vec![start];
    let mut at = next[start];
    while at != start && all.len() < next.len() {
        all.push(at);
        at = next[at];
    }
    if at == start { all } else { vec![] }
}

/// For each joint that moves: the share of each signed effort that its motion leaves unexplained.
fn unexplained_shares(input: &Input) -> BTreeMap<usize, Vec<Option<f64>>> {
    let effort = |index: usize| -> Option<Vec<Option<Vec<f64>>>> {
        let joint = &input.joints[index];
        let efforts = input.episodes.iter().map(|episode| episode.effort(input.metadata, index, joint));
        input.has_signed_effort(joint).then(|| efforts.collect())
    };
    let efforts: Vec<_> = (0..input.joints.len()).map(effort).collect();
    let has_all = |episode: usize| efforts.iter().flatten().all(|effort| effort[episode].is_some());
    let moving = (0..input.joints.len()).filter(|&index| {
        let (v_noise, v_rms) = input.speeds(index);
        efforts[index].is_some() && v_rms > 5.0 * v_noise
    });
    let shares = |index: usize| {
        let rows = Rows::new(input, index, &has_all, 0, Terms::Constant)?;
        let share =
            |effort: &Option<Vec<_>>| Some(rows.regressors.unexplained(&rows.pick(effort.as_ref()?, 0)));
        Some((index, efforts.iter().map(share).collect()))
    };
    moving.filter_map(shares).collect()
}

/// Joints whose stream follows the motion of another joint.
fn correlated(input: &Input, prefix: &str, of: &str) -> Vec<String> {
    let n = input.joints.len();
    let other_motion = |index: usize| {
        let correlations: Vec<f64> = (0..n).map(|other| correlation(input, prefix, index, other)).collect();
        let best = (0..n).max_by(|&a, &b| correlations[a].total_cmp(&correlations[b]))?;
        let (r, own_r) = (correlations[best], correlations[index]);
        let (own, other) = (&input.joints[index], &input.joints[best]);
        (best != index && r > MIN_OTHER && own_r.abs() < MAX_OWN).then(|| {
            format!("{prefix}_{own} follows the {of} of {other} (correlation {r:.2}, own {own_r:.2})")
        })
    };
    (0..n).filter_map(other_motion).collect()
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
