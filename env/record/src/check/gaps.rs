//! Check for drop-outs: intervals without a sample that random losses do not explain.

use crate::episode::Gripper;
use crate::prepare::median_step;

use super::data::EpisodeData;
use super::finding::{Finding, Severity};
use super::group::grouped;
use super::input::CheckInput;

/// Minimum length of a drop-out in median steps.
const MIN_STEPS: f64 = 5.0;
/// Minimum length of a drop-out as a share of the episode.
const MIN_EPISODE_SHARE: f64 = 0.03;
/// Probability of an equally long gap by random losses.
const MAX_RANDOM_PROBABILITY: f64 = 1e-6;
/// Minimum number of runs of losses for a model of losses in runs.
const MIN_RUNS: usize = 4;

/// Checks all streams for drop-outs.
pub(crate) fn gaps(input: &CheckInput) -> Vec<Finding> {
    let of = |name: &'static str, times: fn(&EpisodeData) -> Vec<f64>| {
        let all: Vec<Vec<f64>> = input.data.episodes.iter().map(times).collect();
        let found =
            input.data.episodes.iter().zip(&all).filter_map(|(episode, t)| drop_out(name, episode, t, &all));
        grouped(found.collect())
    };
    let object = |episode: &EpisodeData| episode.raw.object().map_or(vec![], |s| s.t);
    let wrench = |episode: &EpisodeData| episode.raw.wrench().map_or(vec![], |s| s.t);
    let gripper = |episode: &EpisodeData| match episode.raw.gripper() {
        Some(Gripper::Level(s)) => s.t,
        Some(Gripper::Tilting(s)) => s.t,
        None => vec![],
    };
    let (poses, grip) = (of("object pose", object), of("gripper pose", gripper));
    // Do not report a drop-out of a common tracker twice.
    let grip = if poses.is_empty() { grip } else { vec![] };
    [poses, grip, of("wrench", wrench)].concat()
}

fn drop_out(stream: &str, episode: &EpisodeData, t: &[f64], all: &[Vec<f64>]) -> Option<(f64, Finding)> {
    let gap = unexplained_gap(t, all).filter(|gap| gap.to >= episode.prepared.contact)?;
    let remedy = "record without drop-outs, or split the episode at the gap: the motion in it is unknown";
    let finding = Finding::new("gaps", Severity::Warning, gap.sentence(stream), remedy);
    Some((gap.length(), finding.in_episode(episode.name())))
}

/// An interval without a sample.
pub(crate) struct Gap {
    /// Last sample before it, s.
    pub from: f64,
    /// First sample after it, s.
    pub to: f64,
    /// Median interval of the stream, s.
    pub step: f64,
}

impl Gap {
    /// Its length, s.
    pub fn length(&self) -> f64 {
        self.to - self.from
    }

    /// A sentence about the gap in `stream`.
    pub fn sentence(&self, stream: &str) -> String {
        let (length, from, step) = (self.length(), self.from, 1e3 * self.step);
        format!(
            "no {stream} sample for {length:.2} s from t = {from:.2} s on; the median step is {step:.0} ms"
        )
    }
}

/// The longest interval of `t`, if random losses do not explain it. `all` are the times of the stream in all episodes.
pub(crate) fn unexplained_gap(t: &[f64], all: &[Vec<f64>]) -> Option<Gap> {
    let step = median_step(t).filter(|step| *step > 0.0)?;
    let duration = t.last()? - t.first()?;
    let longest = t.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    let gap = Gap { from: longest[0], to: longest[1], step };
    let random = longest_random_gap(t, all, step, gap.length());
    let shortest = (MIN_STEPS * step).max(MIN_EPISODE_SHARE * duration).max(random);
    (gap.length() >= shortest).then_some(gap)
}

/// Longest gap that random losses explain, s. The loss rate is estimated from the other intervals.
fn longest_random_gap(t: &[f64], all: &[Vec<f64>], step: f64, longest: f64) -> f64 {
    let n = t.len() as f64;
    let steps = ((t[t.len() - 1] - t[0] - longest) / step).max(n);
    let lost = (1.0 - (n - 1.0) / steps).clamp(1e-6, 0.9);
    // The median step may itself span losses, so allow for shorter steps.
    let finest = t.windows(2).map(|p| p[1] - p[0]).fold(f64::INFINITY, f64::min).max(0.2 * step);
    let irregular = if finest < 0.7 * step { 2.0 } else { 1.0 };
    let independent = irregular * step * (1.0 + (MAX_RANDOM_PROBABILITY / n).ln() / lost.ln());
    independent.max(in_runs(all, step).unwrap_or(0.0))
}

/// Longest gap that random losses in runs of exponential length explain, s; `None` with too few runs.
///
/// The longest run of each episode may be a drop-out and is left out. The mean length is the ratio of the sums of squared
/// and of plain lengths of the others, so that single losses have little influence, over the ratio of their expected values
/// for a mean of one.
fn in_runs(all: &[Vec<f64>], step: f64) -> Option<f64> {
    let (mut n, mut sums, mut expected) = (0, [0.0; 2], [0.0; 2]);
    for t in all {
        let runs = sorted_runs(t, step);
        n += runs.len();
        runs.iter().rev().skip(1).for_each(|run| sums = [sums[0] + run, sums[1] + run * run]);
        let [sum, squares] = expected_sums_without_longest(runs.len());
        expected = [expected[0] + sum, expected[1] + squares];
    }
    let mean = sums[1] / sums[0] * expected[0] / expected[1];
    (n >= MIN_RUNS && mean.is_finite()).then(|| step + mean * (n as f64 / MAX_RANDOM_PROBABILITY).ln())
}

/// Expected sums of the lengths and of the squared lengths of `n` runs without the longest one, for exponential lengths of
/// mean one. The longest has the mean `Σ 1/k` and the variance `Σ 1/k²` for k from 1 to n (Rényi).
fn expected_sums_without_longest(n: usize) -> [f64; 2] {
    let sum = |power: i32| (1..=n).map(|k| (k as f64).powi(-power)).sum::<f64>();
    let (mean, variance) = (sum(1), sum(2));
    [n as f64 - mean, 2.0 * n as f64 - mean * mean - variance]
}

/// Lengths of the gaps in excess of a step in ascending order, s.
fn sorted_runs(t: &[f64], step: f64) -> Vec<f64> {
    let gaps = t.windows(2).map(|pair| pair[1] - pair[0] - step).filter(|gap| *gap > 0.5 * step);
    let mut gaps: Vec<f64> = gaps.collect();
    gaps.sort_by(f64::total_cmp);
    gaps
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Ten episodes of 4 s at 25 Hz that lose runs of samples of exponential length, mean 0.2 s: about three in each.
    fn lossy(seed: u64) -> Vec<Vec<f64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut exponential = |mean: f64| -mean * (1.0 - rng.random::<f64>()).ln();
        let mut episode = || {
            let (mut t, mut times, mut until) = (0.0, vec![], exponential(1.0));
            while t < 4.0 {
                if t > until {
                    t += (exponential(0.2) / 0.04).ceil() * 0.04;
                    until = t + exponential(1.0);
                }
                times.push(t);
                t += 0.04;
            }
            times
        };
        (0..10).map(|_| episode()).collect()
    }

    #[test]
    fn the_longest_of_few_random_runs_is_no_drop_out() {
        for seed in 0..200 {
            let all = lossy(seed);
            let found = all.iter().filter_map(|t| unexplained_gap(t, &all)).map(|gap| gap.length());
            assert_eq!(found.collect::<Vec<_>>(), vec![], "seed {seed}");
        }
    }

    #[test]
    fn drop_outs_in_two_episodes_are_found_among_short_runs() {
        let mut all = lossy(0);
        for t in &mut all[..2] {
            t.iter_mut().filter(|t| **t > 2.0).for_each(|t| *t += 6.0);
        }
        let found = all.iter().filter(|t| unexplained_gap(t, &all).is_some()).count();
        assert_eq!(found, 2);
    }

    #[test]
    fn expected_sums_of_two_runs_are_those_of_the_shorter_one() {
        let [sum, squares] = expected_sums_without_longest(2);
        assert!((sum - 0.5).abs() < 1e-12 && (squares - 0.5).abs() < 1e-12, "{sum} {squares}");
    }
}
