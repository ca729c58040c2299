//! Detection of tracking errors: held values, jumps and spikes. Poses are masked, never changed.
//!
//! - Held values are exact repeats, where the noise makes accidental repeats improbable.
//! - Jumps are found globally. Of all paths through the episode without an impossible speed, the one that keeps most
//!   samples is taken. This finds bursts of any length, noisy or constant.
//! - Spikes deviate from the smoothed motion (see [`spikes`]).

use crate::motion::spikes;

use super::sampling::quantile;
use super::transform::wrapped;

/// Classification of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PoseStatus {
    Valid,
    /// Exact repeat of the previous pose.
    Held,
    /// Jump or spike.
    Outlier,
}

/// Lower bound of the speed limit, m/s and rad/s. Furniture is pushed at walking pace.
const MIN_SPEED_LIMIT: [f64; 2] = [0.2, 1.0];
/// Speed limit relative to the 95 % quantile of the speeds.
const SPEED_LIMIT_FACTOR: f64 = 4.0;
/// Distance in standard deviations of the pose noise that every step may have.
const MAX_NOISE_STEP_SD: f64 = 12.0;
/// Cost of an impossible step in the path, as a share of the samples.
const IMPOSSIBLE_STEP_COST: f64 = 0.25;
/// Multiple of the largest possible distance at which a step has the full cost. The cost of a smaller excess is proportional.
const IMPOSSIBLE_STEP_RATIO: f64 = 10.0;
/// Noise below which poses are simulated, m or rad. No tracker is better.
pub(crate) const MIN_TRACKER_SD: f64 = 1e-5;
/// Largest number of consecutive runs that a path may skip. It bounds the computing time on bad data.
const MAX_SKIPPED_RUNS: usize = 1000;
/// Probability of an accidental repeat of all coordinates below which repeats count as held values.
const MAX_REPEAT_PROBABILITY: f64 = 1e-3;

/// Classifies each pose (x, y in m, theta in rad, wrapped or not) of one episode.
///
/// `sd` is the pose noise, and `estimated_sd` its estimate from the data. They differ for a simulation that states noise
/// but does not add it.
pub(crate) fn classify(
    t: &[f64],
    pose: &[[f64; 3]],
    sd: &[f64; 3],
    estimated_sd: &[f64; 3],
) -> Vec<PoseStatus> {
    let mut status = vec![PoseStatus::Valid; t.len()];
    for i in jumps(t, pose, sd) {
        status[i] = PoseStatus::Outlier;
    }
    if repeats_are_held(pose, estimated_sd) {
        for i in 1..pose.len() {
            if pose[i] == pose[i - 1] && status[i] == PoseStatus::Valid {
                status[i] = PoseStatus::Held;
            }
        }
    }
    let kept: Vec<usize> = (0..t.len()).filter(|&i| status[i] == PoseStatus::Valid).collect();
    let times: Vec<f64> = kept.iter().map(|&i| t[i]).collect();
    let clean = unwrapped(kept.iter().map(|&i| pose[i]));
    for i in spikes(&times, &clean, sd) {
        status[kept[i]] = PoseStatus::Outlier;
    }
    status
}

/// Poses with continuous theta.
pub(crate) fn unwrapped(pose: impl IntoIterator<Item = [f64; 3]>) -> Vec<[f64; 3]> {
    let mut last: Option<f64> = None;
    let follow = |[x, y, theta]: [f64; 3]| {
        let theta = last.map_or(theta, |before| before + wrapped(theta - before));
        last = Some(theta);
        [x, y, theta]
    };
    pose.into_iter().map(follow).collect()
}

/// Whether an exact repeat of a pose is a held value. It may be an accident if the noise is below the resolution of the
/// numbers and the object is at rest.
fn repeats_are_held(pose: &[[f64; 3]], sd: &[f64; 3]) -> bool {
    if sd.iter().all(|&sd| sd < MIN_TRACKER_SD) {
        return false;
    }
    let probability: f64 = (0..3).map(|k| repeat_probability(resolution(pose, k), sd[k])).product();
    probability < MAX_REPEAT_PROBABILITY
}

/// Probability that two samples with noise `sd` round to the same value: the density of their difference at zero,
/// 1 / (2 √π sd), times the resolution.
fn repeat_probability(resolution: f64, sd: f64) -> f64 {
    (resolution / (2.0 * std::f64::consts::PI.sqrt() * sd.max(1e-12))).min(1.0)
}

/// Smallest nonzero step between consecutive values of coordinate `k`; infinite if it never changes.
pub(crate) fn resolution(pose: &[[f64; 3]], k: usize) -> f64 {
    let steps = pose.windows(2).map(|pair| (pair[1][k] - pair[0][k]).abs());
    steps.filter(|&step| step > 0.0).fold(f64::INFINITY, f64::min)
}

/// A run of poses without a jump: first and last index.
#[derive(Clone, Copy)]
struct Run {
    first: usize,
    last: usize,
}

impl Run {
    fn len(self) -> f64 {
        (self.last - self.first + 1) as f64
    }
}

/// Indices of the poses that are not on the path of the object.
fn jumps(t: &[f64], pose: &[[f64; 3]], sd: &[f64; 3]) -> Vec<usize> {
    let limit = speed_limit(t, pose);
    // Distance relative to the largest possible distance.
    let distance_ratio = |i: usize, j: usize| {
        let (distance, dt) = (step(&pose[i], &pose[j]), t[j] - t[i]);
        let noise = [sd[0].max(sd[1]), sd[2]];
        let ratio = |k: usize| distance[k] / (MAX_NOISE_STEP_SD * noise[k] + limit[k] * dt);
        ratio(0).max(ratio(1))
    };
    let runs = runs(t.len(), |i, j| distance_ratio(i, j) <= 1.0);
    let cost = |a: Run, b: Run| {
        let excess = (distance_ratio(a.last, b.first) - 1.0) / (IMPOSSIBLE_STEP_RATIO - 1.0);
        IMPOSSIBLE_STEP_COST * t.len() as f64 * excess.clamp(0.0, 1.0)
    };
    let kept = best_path(&runs, cost);
    let rejected = runs.iter().zip(kept).filter(|(_, kept)| !kept);
    rejected.flat_map(|(run, _)| run.first..=run.last).collect()
}

fn runs(n: usize, reachable: impl Fn(usize, usize) -> bool) -> Vec<Run> {
    let mut runs: Vec<Run> = vec![];
    for i in 0..n {
        match runs.last_mut() {
            Some(run) if reachable(i - 1, i) => run.last = i,
            _ => runs.push(Run { first: i, last: i }),
        }
    }
    runs
}

/// Whether each run lies on the path that keeps most samples. A step from one run to the next costs `cost` samples.
fn best_path(runs: &[Run], cost: impl Fn(Run, Run) -> f64) -> Vec<bool> {
    let mut score: Vec<f64> = vec![];
    let mut from: Vec<Option<usize>> = vec![];
    for (k, run) in runs.iter().enumerate() {
        let gain = |j: usize| score[j] - cost(runs[j], *run);
        let best = (k.saturating_sub(MAX_SKIPPED_RUNS)..k)
            .map(|j| (gain(j), Some(j)))
            .fold((0.0, None), |a, b| if b.0 > a.0 { b } else { a });
        score.push(best.0 + run.len());
        from.push(best.1);
    }
    let mut kept = vec![false; runs.len()];
    let mut at = (0..runs.len()).max_by(|&a, &b| score[a].total_cmp(&score[b]));
    while let Some(k) = at {
        kept[k] = true;
        at = from[k];
    }
    kept
}

/// Distance and angle between two poses, m and rad.
fn step(a: &[f64; 3], b: &[f64; 3]) -> [f64; 2] {
    [(b[0] - a[0]).hypot(b[1] - a[1]), wrapped(b[2] - a[2]).abs()]
}

fn speed_limit(t: &[f64], pose: &[[f64; 3]]) -> [f64; 2] {
    [0, 1].map(|k| {
        let speeds = (1..t.len()).map(|i| step(&pose[i - 1], &pose[i])[k] / (t[i] - t[i - 1]));
        MIN_SPEED_LIMIT[k].max(SPEED_LIMIT_FACTOR * quantile(speeds, 0.95).unwrap_or(0.0))
    })
}

#[cfg(test)]
mod tests;
