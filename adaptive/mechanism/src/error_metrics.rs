//! Error metrics of a model on some episodes: errors of efforts and positions.

use crate::drive::Drive;
use crate::fit::Fit;
use crate::motion::range;
use crate::problem::{EpisodeData, Problem};
use crate::rows::{Scope, evaluate, noise_floor};
use crate::simulation::simulate;
use serde::Serialize;
use std::collections::BTreeMap;
use trundle_infer::PREDICTION_WINDOW_S;

/// Error metrics of one joint; null where a metric is not defined.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct JointErrorMetrics {
    /// Open loop from the first state, rad or m.
    pub position_rmse: Option<f64>,
    /// Windows of 1 s, rad or m.
    pub window_position_rmse: Option<f64>,
    /// Effort that the model needs less the recorded one, below the bandwidth.
    pub effort_rmse: Option<f64>,
}

/// Error metrics of all joints.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ErrorMetrics {
    /// Cut-off frequency of efforts, Hz.
    pub effort_bandwidth: f64,
    /// By joint.
    pub joints: BTreeMap<String, JointErrorMetrics>,
    /// Root mean square over joints of the open-loop errors, each divided by the joint's range in training.
    pub relative_position_rmse: Option<f64>,
    /// The same for windows.
    pub relative_window_rmse: Option<f64>,
    /// Root mean square over joints of the efforts' errors, each divided by the effort's range in training.
    pub relative_effort_rmse: Option<f64>,
}

/// Sum of squares and number of errors.
#[derive(Clone, Copy, Default)]
struct Sum(f64, f64);

impl Sum {
    fn add(&mut self, errors: impl Iterator<Item = f64>) {
        for error in errors {
            self.0 += error * error;
            self.1 += 1.0;
        }
    }

    fn add_weighted(&mut self, error: f64, weight: f64) {
        self.0 += weight * error * error;
        self.1 += weight;
    }

    fn rms(self) -> Option<f64> {
        (self.1 > 0.0 && self.0.is_finite()).then(|| (self.0 / self.1).sqrt())
    }
}

/// Positions of one joint in one episode, as recorded and as simulated from the first compared state, or from rest at the first
/// sample.
#[derive(Clone, Debug)]
pub struct OpenLoop {
    /// Times, s.
    pub t: Vec<f64>,
    /// Recorded positions, interpolated.
    pub observed: Vec<f64>,
    /// Simulated positions; NaN after a divergence.
    pub simulated: Vec<f64>,
}

/// Size of a joint's residual in an episode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResidualSize {
    /// Root mean square, as the search compares it.
    pub rms: f64,
    /// Part that the noise may have.
    pub floor: f64,
}

/// Sizes of the residuals in one episode, by joint.
#[derive(Clone, Debug)]
pub(crate) struct EpisodeErrors {
    pub name: String,
    pub held_out: bool,
    pub joints: BTreeMap<String, ResidualSize>,
}

/// Sizes of the residuals of a model in every episode.
pub(crate) fn episode_errors(problem: &Problem, fit: &Fit) -> Vec<EpisodeErrors> {
    let empty = |episode: &EpisodeData| EpisodeErrors {
        name: episode.name.clone(),
        held_out: episode.held_out,
        joints: BTreeMap::new(),
    };
    let mut found: Vec<EpisodeErrors> = problem.episodes.iter().map(empty).collect();
    for scope in [Scope::Training, Scope::HeldOut] {
        for own in evaluate(problem, &fit.effects, &fit.slots, &fit.values, scope, false) {
            let mut sums = vec![Sum::default(); found.len()];
            for (residual, place) in own.residual.iter().zip(&own.places) {
                let weight = problem.episodes[place.episode].joints[own.joint].weight[place.sample];
                sums[place.episode].0 += residual * residual;
                sums[place.episode].1 += weight * weight;
            }
            let floor = noise_floor(problem, own.joint);
            for (episode, sum) in found.iter_mut().zip(sums) {
                if let Some(rms) = sum.rms() {
                    let name = problem.joints[own.joint].name.clone();
                    episode.joints.insert(name, ResidualSize { rms, floor });
                }
            }
        }
    }
    found
}

/// Open-loop simulation of an axis in an episode; `None` if it makes no sense.
pub(crate) fn open_loop(problem: &Problem, fit: &Fit, episode: &EpisodeData) -> Option<OpenLoop> {
    if problem.axis.is_none() || problem.imposed {
        return None;
    }
    let series = &episode.joints[0];
    let (first, state) = match problem.at_rest {
        true => (0, [series.raw[0], 0.0]),
        false => {
            let first = episode.first_stage.half.min(series.q.len() - 1);
            (first, [series.q[first], series.v[first]])
        }
    };
    let simulated = simulate(problem, fit, episode, (first, series.q.len()), state)?;
    Some(OpenLoop {
        t: (first..series.q.len()).map(|k| episode.start + k as f64 * episode.dt).collect(),
        observed: series.raw[first..].to_vec(),
        simulated,
    })
}

/// ErrorMetrics on the training or the held-out episodes. `None` if there is no such episode.
pub(crate) fn error_metrics(problem: &Problem, fit: &Fit, held_out: bool) -> Option<ErrorMetrics> {
    let episodes: Vec<&EpisodeData> = problem.episodes.iter().filter(|e| e.held_out == held_out).collect();
    if episodes.is_empty() {
        return None;
    }
    let scope = if held_out { Scope::HeldOut } else { Scope::Training };
    let rows = evaluate(problem, &fit.effects, &fit.slots, &fit.values, scope, false);
    let mut found = ErrorMetrics { effort_bandwidth: problem.bandwidth, ..ErrorMetrics::default() };
    let mut relative = [Sum::default(), Sum::default(), Sum::default()];
    for (j, joint) in problem.joints.iter().enumerate() {
        let mut effort = Sum::default();
        for own in rows.iter().filter(|own| own.joint == j) {
            for (row, place) in own.places.iter().enumerate() {
                let weight = problem.episodes[place.episode].joints[j].weight[place.sample];
                let (residual, per_effort) = (own.residual[row], own.per_effort[row]);
                let error = if per_effort > 0.0 { residual / per_effort } else { 0.0 };
                effort.add_weighted(error, weight * weight);
            }
        }
        let (mut whole, mut windows) = (Sum::default(), Sum::default());
        for episode in &episodes {
            if let Some(path) = open_loop(problem, fit, episode) {
                whole.add(path.simulated.iter().zip(&path.observed).map(|(a, b)| a - b));
                windows.add(window_errors(problem, fit, episode).into_iter());
            }
        }
        let errors = JointErrorMetrics {
            position_rmse: whole.rms(),
            window_position_rmse: windows.rms(),
            effort_rmse: effort.rms().filter(|_| joint.drive != Drive::None || problem.axis.is_some()),
        };
        let effort_range = effort_range(problem, fit, j);
        let ranges = [joint.scales.span(), joint.scales.span(), effort_range];
        let values = [errors.position_rmse, errors.window_position_rmse, errors.effort_rmse];
        for ((sum, value), range) in relative.iter_mut().zip(values).zip(ranges) {
            sum.add(value.filter(|_| range > 0.0).map(|value| value / range).into_iter());
        }
        found.joints.insert(joint.name.clone(), errors);
    }
    [found.relative_position_rmse, found.relative_window_rmse, found.relative_effort_rmse] =
        relative.map(Sum::rms);
    Some(found)
}

/// Largest minus smallest recorded effort of a joint in the training episodes; zero without a recorded effort.
fn effort_range(problem: &Problem, fit: &Fit, j: usize) -> f64 {
    if !matches!(problem.joints[j].drive, Drive::Effort(_)) {
        return 0.0;
    }
    let free = fit.gain(j).map_or(1.0, f64::abs);
    let of = |e: &EpisodeData| {
        let series = &e.joints[j];
        series.command.iter().map(|effort| effort * series.gain.unwrap_or(free)).collect::<Vec<f64>>()
    };
    let all: Vec<f64> = problem.episodes.iter().filter(|e| !e.held_out).flat_map(of).collect();
    range(all.iter())
}

/// Errors within windows, each from a state that earlier samples tell.
fn window_errors(problem: &Problem, fit: &Fit, episode: &EpisodeData) -> Vec<f64> {
    let series = &episode.joints[0];
    let count = series.q.len();
    let duration = count as f64 * episode.dt;
    let size = ((PREDICTION_WINDOW_S.min(duration / 10.0) / episode.dt) as usize).max(2);
    let mut errors = vec![];
    let mut from = episode.first_stage.half;
    while from + size < count {
        let state = series.causal[from];
        let simulated = simulate(problem, fit, episode, (from, from + size), state).unwrap_or_default();
        errors.extend(simulated.iter().zip(&series.raw[from..]).map(|(a, b)| a - b));
        from += size;
    }
    errors
}
