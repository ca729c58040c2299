//! Drop-outs: times without a sample that chance losses do not explain.

use crate::episode::Gripper;
use crate::prepare::median_step;

use super::group::grouped;
use super::subject::{Look, Subject};
use super::{Finding, Severity};

/// Shortest drop-out worth a word, in median steps and in lengths of the episode.
const LEAST: (f64, f64) = (5.0, 0.03);
/// Chance of a longer one among all that are lost at random.
const CHANCE: f64 = 1e-6;
/// Fewest runs of losses, and how many times longer than losses one by one they are in the mean.
const RUNS: (usize, f64) = (4, 2.0);

/// Streams that pause.
pub(crate) fn gaps(subject: &Subject) -> Vec<Finding> {
    let of = |name: &'static str, times: fn(&Look) -> Vec<f64>| {
        let all: Vec<Vec<f64>> = subject.episodes.iter().map(times).collect();
        let found = subject.episodes.iter().zip(&all).filter_map(|(look, t)| pause(name, look, t, &all));
        grouped(found.collect())
    };
    let object = |look: &Look| look.episode.object().map_or(vec![], |s| s.t);
    let wrench = |look: &Look| look.episode.wrench().map_or(vec![], |s| s.t);
    let gripper = |look: &Look| match look.episode.gripper() {
        Some(Gripper::Level(s)) => s.t,
        Some(Gripper::Tilting(s)) => s.t,
        None => vec![],
    };
    let (poses, grip) = (of("the object's poses", object), of("the gripper's poses", gripper));
    // One tracker that pauses loses both.
    let grip = if poses.is_empty() { grip } else { vec![] };
    [poses, grip, of("the wrench", wrench)].concat()
}

fn pause(stream: &str, look: &Look, t: &[f64], all: &[Vec<f64>]) -> Option<(f64, Finding)> {
    let step = median_step(t).filter(|step| *step > 0.0)?;
    let whole = t.last()? - t.first()?;
    let longest = t.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    let (from, to) = (longest[0], longest[1]);
    let length = to - from;
    let usual = usual(t, all, step, length);
    if length < (LEAST.0 * step).max(LEAST.1 * whole).max(usual) || to < look.prepared.contact {
        return None;
    }
    let sentence = format!(
        "{stream} pause for {length:.2} s from {from:.2} s on, where the usual step is {:.0} ms",
        1e3 * step
    );
    let remedy = "record without drop-outs, or end the episode there and begin another: what happened meanwhile is \
                  unknown";
    Some((length, Finding::new("gaps", Severity::Warning, sentence, remedy).of(look.name())))
}

/// The pause that losses at random at the rate of the other intervals do not reach, s.
fn usual(t: &[f64], all: &[Vec<f64>], step: f64, longest: f64) -> f64 {
    let n = t.len() as f64;
    let steps = ((t[t.len() - 1] - t[0] - longest) / step).max(n);
    let lost = (1.0 - (n - 1.0) / steps).clamp(1e-6, 0.9);
    // The median step may itself span losses: count in steps between the shortest and it.
    let finest = t.windows(2).map(|p| p[1] - p[0]).fold(f64::INFINITY, f64::min).max(0.2 * step);
    let irregular = if finest < 0.7 * step { 2.0 } else { 1.0 };
    let one_by_one = irregular * step * (1.0 + (CHANCE / n).ln() / lost.ln());
    one_by_one.max(in_runs(all, step, lost).unwrap_or(0.0))
}

/// The same where samples are lost in runs, in any episode: their lengths are exponential, with the mean of those besides
/// each episode's longest. `None` where the losses are no longer than single ones would be.
fn in_runs(all: &[Vec<f64>], step: f64, lost: f64) -> Option<f64> {
    let runs: Vec<f64> = all.iter().flat_map(|t| runs(t, step)).collect();
    let n = runs.len() as f64;
    // By their squares, so that single losses among them count little.
    let mean = runs.iter().map(|run| run * run).sum::<f64>() / (2.0 * runs.iter().sum::<f64>());
    (runs.len() >= RUNS.0 && mean > RUNS.1 * step / (1.0 - lost)).then(|| step + mean * (n / CHANCE).ln())
}

/// What pauses exceed the step by, the longest left out.
fn runs(t: &[f64], step: f64) -> Vec<f64> {
    let pauses = t.windows(2).map(|pair| pair[1] - pair[0] - step).filter(|pause| *pause > 0.5 * step);
    let mut pauses: Vec<f64> = pauses.collect();
    pauses.sort_by(f64::total_cmp);
    pauses.pop();
    pauses
}
