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
/// Minimum mean length of the runs relative to independent losses.
const MIN_RUN_LENGTH_RATIO: f64 = 2.0;

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
    independent.max(in_runs(all, step, lost).unwrap_or(0.0))
}

/// Longest gap that random losses in runs of exponential length explain, s. The mean length is that of the runs of all
/// episodes without the longest one of each. `None` if the runs are no longer than independent losses.
fn in_runs(all: &[Vec<f64>], step: f64, lost: f64) -> Option<f64> {
    let runs: Vec<f64> = all.iter().flat_map(|t| runs(t, step)).collect();
    let n = runs.len() as f64;
    // Weighted by length, so that single losses have little influence.
    let mean = runs.iter().map(|run| run * run).sum::<f64>() / (2.0 * runs.iter().sum::<f64>());
    (runs.len() >= MIN_RUNS && mean > MIN_RUN_LENGTH_RATIO * step / (1.0 - lost))
        .then(|| step + mean * (n / MAX_RANDOM_PROBABILITY).ln())
}

/// Lengths of the gaps in excess of a step, without the longest one, s.
fn runs(t: &[f64], step: f64) -> Vec<f64> {
    let gaps = t.windows(2).map(|pair| pair[1] - pair[0] - step).filter(|gap| *gap > 0.5 * step);
    let mut gaps: Vec<f64> = gaps.collect();
    gaps.sort_by(f64::total_cmp);
    gaps.pop();
    gaps
}
