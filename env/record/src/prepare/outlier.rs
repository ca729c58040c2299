//! Poses that a tracker made up: held values, jumps away and back, single spikes.
//!
//! A pose is masked, never changed. Held values are exact repeats where the noise makes chance repeats
//! practically impossible. Jumps are judged globally: of all ways to follow the object through the episode
//! without an impossible speed, the one that keeps most samples. So a burst of any length is found, be it noisy or
//! a constant fake pose. Spikes are what leaves the smoothed motion by far more than their neighbours do.

use crate::motion::spikes;

use super::sampling::quantile;
use super::transform::wrapped;

/// What becomes of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Kept,
    /// Repeats the one before it exactly.
    Held,
    Outlier,
}

/// A speed below which nothing counts as a jump, m/s and rad/s: furniture is pushed at walking pace.
const SLOWEST_CAP: [f64; 2] = [0.2, 1.0];
/// How much faster than nearly all steps a step must be to be a jump.
const CAP_FACTOR: f64 = 4.0;
/// How many standard deviations of the pose noise a jump exceeds.
const CAP_NOISE: f64 = 12.0;
/// Share of the samples that it must save to believe in one impossible jump of the object itself.
const BREAK_SHARE: f64 = 0.25;
/// Times the possible distance from which on a jump is wholly impossible; a little too far costs little.
const IMPOSSIBLE: f64 = 10.0;
/// No tracker has less noise than this, m or rad: such poses are simulated.
const NOISELESS: f64 = 1e-5;
/// Runs looked back over; a path that skips more of them is no path, and hopeless data stay quick to judge.
const MOST_RUNS: usize = 1000;
/// A repeat of all coordinates is less likely than this by chance where it counts as held.
const CHANCE: f64 = 1e-3;

/// Judges each pose (x, y in m, theta in rad, wrapped or not) of one episode.
///
/// `sd` is the pose noise, `seen` that which the data show: a simulation may state noise that it does not add.
pub(crate) fn judge(t: &[f64], pose: &[[f64; 3]], sd: &[f64; 3], seen: &[f64; 3]) -> Vec<Verdict> {
    let mut verdict = vec![Verdict::Kept; t.len()];
    for i in jumps(t, pose, sd) {
        verdict[i] = Verdict::Outlier;
    }
    if repeats_are_held(pose, seen) {
        for i in 1..pose.len() {
            if pose[i] == pose[i - 1] && verdict[i] == Verdict::Kept {
                verdict[i] = Verdict::Held;
            }
        }
    }
    let kept: Vec<usize> = (0..t.len()).filter(|&i| verdict[i] == Verdict::Kept).collect();
    let times: Vec<f64> = kept.iter().map(|&i| t[i]).collect();
    let clean = unwrapped(kept.iter().map(|&i| pose[i]));
    for i in spikes(&times, &clean, sd) {
        verdict[kept[i]] = Verdict::Outlier;
    }
    verdict
}

/// The poses with the turns added that make theta continuous.
pub(crate) fn unwrapped(pose: impl IntoIterator<Item = [f64; 3]>) -> Vec<[f64; 3]> {
    let mut last: Option<f64> = None;
    let follow = |[x, y, theta]: [f64; 3]| {
        let theta = last.map_or(theta, |before| before + wrapped(theta - before));
        last = Some(theta);
        [x, y, theta]
    };
    pose.into_iter().map(follow).collect()
}

/// Whether an exact repeat of a pose says that the tracker held it: not where the object may be at rest and
/// the noise is below the resolution of the numbers.
fn repeats_are_held(pose: &[[f64; 3]], sd: &[f64; 3]) -> bool {
    if sd.iter().all(|&sd| sd < NOISELESS) {
        return false;
    }
    let chance: f64 = (0..3).map(|k| repeat_chance(resolution(pose, k), sd[k])).product();
    chance < CHANCE
}

/// Chance that two samples with noise `sd` round to one value, for a density of 1 / (2 √π sd) at zero difference.
fn repeat_chance(resolution: f64, sd: f64) -> f64 {
    (resolution / (2.0 * std::f64::consts::PI.sqrt() * sd.max(1e-12))).min(1.0)
}

/// The smallest step between consecutive values of coordinate `k`; infinite if it never changes.
pub(crate) fn resolution(pose: &[[f64; 3]], k: usize) -> f64 {
    let steps = pose.windows(2).map(|pair| (pair[1][k] - pair[0][k]).abs());
    steps.filter(|&step| step > 0.0).fold(f64::INFINITY, f64::min)
}

/// A run of poses without a jump inside: first and last index.
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

/// Indices of the poses that are not on the object's path.
fn jumps(t: &[f64], pose: &[[f64; 3]], sd: &[f64; 3]) -> Vec<usize> {
    let cap = speed_cap(t, pose);
    // Distance over the greatest possible one.
    let stretch = |i: usize, j: usize| {
        let (distance, dt) = (step(&pose[i], &pose[j]), t[j] - t[i]);
        let noise = [sd[0].max(sd[1]), sd[2]];
        let ratio = |k: usize| distance[k] / (CAP_NOISE * noise[k] + cap[k] * dt);
        ratio(0).max(ratio(1))
    };
    let runs = runs(t.len(), |i, j| stretch(i, j) <= 1.0);
    let price = |a: Run, b: Run| {
        let excess = (stretch(a.last, b.first) - 1.0) / (IMPOSSIBLE - 1.0);
        BREAK_SHARE * t.len() as f64 * excess.clamp(0.0, 1.0)
    };
    let kept = best_path(&runs, price);
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

/// Which runs lie on the path that keeps most samples, where going from one to the next costs `price` samples.
fn best_path(runs: &[Run], price: impl Fn(Run, Run) -> f64) -> Vec<bool> {
    let mut score: Vec<f64> = vec![];
    let mut from: Vec<Option<usize>> = vec![];
    for (k, run) in runs.iter().enumerate() {
        let gain = |j: usize| score[j] - price(runs[j], *run);
        let best = (k.saturating_sub(MOST_RUNS)..k)
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

/// Position and angle between two poses, m and rad.
fn step(a: &[f64; 3], b: &[f64; 3]) -> [f64; 2] {
    [(b[0] - a[0]).hypot(b[1] - a[1]), wrapped(b[2] - a[2]).abs()]
}

fn speed_cap(t: &[f64], pose: &[[f64; 3]]) -> [f64; 2] {
    [0, 1].map(|k| {
        let speeds = (1..t.len()).map(|i| step(&pose[i - 1], &pose[i])[k] / (t[i] - t[i - 1]));
        SLOWEST_CAP[k].max(CAP_FACTOR * quantile(speeds, 0.95).unwrap_or(0.0))
    })
}

#[cfg(test)]
mod tests;
