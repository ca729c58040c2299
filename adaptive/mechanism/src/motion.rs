//! Smoothed motion of all joints on the uniform times of each episode.

use crate::bandwidth::{Cutoffs, Positions, StageSds, cutoffs, noise};
use crate::causal_filter::{causal_states, jerk_density};
use crate::error::MechanismError;
use crate::kernel::Kernel;
use crate::resample::{Grid, in_gap, interpolated, median_interval};
use trundle_record::JointRecording;

/// Longest gap between positions, standard deviations of the filter.
const MAX_GAP_SDS: f64 = 6.0;
/// Range of a joint's positions, standard deviations of their noise, above which it moves (MECHANISM.md).
const MIN_RANGE_SDS: f64 = 10.0;
/// Least ratio of cut-off frequencies that is worth a second search: almost one step of their choice, 1.25.
const MIN_FINER: f64 = 1.2;
/// Fewest positions of a joint in an episode.
const MIN_POSITIONS: usize = 20;

/// Motion of the joints in one episode. The outer index of the arrays is the joint.
#[derive(Clone, Debug)]
pub struct EpisodeMotion {
    /// Name of the episode.
    pub name: String,
    /// Whether the episode is held out.
    pub held_out: bool,
    pub(crate) grid: Grid,
    /// Positions as recorded, interpolated.
    pub(crate) raw: Vec<Vec<f64>>,
    /// Filtered positions, rad or m.
    pub q: Vec<Vec<f64>>,
    /// Velocities.
    pub v: Vec<Vec<f64>>,
    /// Accelerations.
    pub a: Vec<Vec<f64>>,
    /// Position and velocity that the samples up to each one tell.
    pub causal: Vec<Vec<[f64; 2]>>,
    /// Whether each sample is usable: away from the ends and from gaps.
    pub(crate) usable: Vec<Vec<bool>>,
}

impl EpisodeMotion {
    /// Times of the samples, s, in the time of the table.
    #[must_use]
    pub fn times(&self) -> Vec<f64> {
        self.grid.times()
    }
}

/// Motion in all episodes.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Names of the joints.
    pub joints: Vec<String>,
    /// The episodes.
    pub episodes: Vec<EpisodeMotion>,
    /// Cut-off frequency of the filter, Hz: positions tell acceleration up to it.
    pub bandwidth: f64,
    /// Standard deviation of the noise of each joint's positions.
    pub position_noise: Vec<f64>,
    /// Standard deviation of the noise of each joint's filtered velocity.
    pub(crate) velocity_noise: Vec<f64>,
    pub(crate) stages: StageSds,
    /// Median interval between positions in the training episodes by joint, s.
    pub(crate) interval: Vec<f64>,
}

impl Motion {
    /// The same motion, compared up to the largest frequency at which the first stage of the filter leaves it; `None` if that
    /// is hardly more.
    pub(crate) fn finer(&self) -> Option<Self> {
        let stages = self.stages.finest();
        let ratio = self.stages.both() / stages.both();
        (ratio > MIN_FINER).then(|| Self { stages, bandwidth: ratio * self.bandwidth, ..self.clone() })
    }

    /// Standard deviation of a derivative of white noise of unit standard deviation, sampled at an interval, after both
    /// stages of the filter. A Gaussian filter of standard deviation s has √(T/(2√π s)) for the value, with the factors
    /// 1/(√2 s) and √3/(2 s²) for the derivatives.
    pub(crate) fn noise_gain(&self, derivative: usize, interval: f64) -> f64 {
        let sd = self.stages.both();
        let factor = [1.0, 0.5f64.sqrt() / sd, 0.75f64.sqrt() / (sd * sd)][derivative];
        factor * (interval / (2.0 * std::f64::consts::PI.sqrt() * sd)).sqrt().min(1.0)
    }
}

/// Smooth the positions of a recording. All joints share the filter, because their efforts depend on each other's
/// acceleration. Training episodes alone decide about it.
///
/// # Errors
/// If an episode has too few positions.
pub fn motion(recording: &JointRecording) -> Result<Motion, MechanismError> {
    let joints = recording.metadata.mechanism.joints.clone();
    let mut streams: Vec<Vec<(Vec<f64>, Vec<f64>)>> = vec![];
    for joint in &joints {
        let of = |episode: &trundle_record::Episode| positions(recording, &episode.name, joint);
        streams.push(recording.episodes.iter().map(of).collect::<Result<_, _>>()?);
    }
    let is_training: Vec<bool> =
        recording.episodes.iter().map(|episode| !recording.metadata.is_held_out(&episode.name)).collect();
    let stated = recording.metadata.noise.as_ref().and_then(|noise| noise.position.as_ref());
    let (mut position_noise, mut interval) = (vec![], vec![]);
    let mut lowest = Cutoffs { compared: f64::INFINITY, resolved: f64::INFINITY };
    for (joint, episodes) in joints.iter().zip(&streams) {
        let training: Vec<Positions<'_>> = episodes
            .iter()
            .zip(&is_training)
            .filter(|(_, is_training)| **is_training)
            .map(|((t, q), _)| Positions { t, q })
            .collect();
        let sd = stated.and_then(|by| by.of(joint)).copied().unwrap_or_else(|| noise(&training));
        position_noise.push(sd);
        interval.push(training.iter().filter_map(|one| median_interval(one.t)).fold(0.0, f64::max));
        let moves = range(training.iter().flat_map(|episode| episode.q)) > MIN_RANGE_SDS * sd;
        if moves {
            let own = cutoffs(&training, sd, slowest_interval(recording, joint));
            lowest.compared = lowest.compared.min(own.compared);
            lowest.resolved = lowest.resolved.min(own.resolved);
        }
    }
    if !lowest.compared.is_finite() {
        return Err(MechanismError::Unsuitable {
            recording: recording.metadata.name.clone(),
            reason: "no joint moves by more than ten standard deviations of its noise".to_owned(),
            remedy: "record motion, or state [noise] position".to_owned(),
        });
    }
    let stages = StageSds::new(lowest);
    let one = |k: usize| {
        let own: Vec<&(Vec<f64>, Vec<f64>)> = streams.iter().map(|episodes| &episodes[k]).collect();
        smooth(recording, k, &own, stages.first)
    };
    let mut episodes: Vec<EpisodeMotion> = (0..recording.episodes.len()).map(one).collect();
    add_causal_states(&mut episodes, joints.len());
    let dt =
        episodes.iter().find(|episode| !episode.held_out).map_or(stages.first, |episode| episode.grid.dt);
    let amplification = Kernel::flat(stages.first, dt).noise()[1];
    let velocity_noise = position_noise.iter().map(|sd| sd * amplification).collect();
    let bandwidth = lowest.compared;
    Ok(Motion { joints, episodes, bandwidth, position_noise, velocity_noise, stages, interval })
}

/// Add the states that earlier samples tell; training episodes alone decide about the filter.
fn add_causal_states(episodes: &mut [EpisodeMotion], joints: usize) {
    for j in 0..joints {
        let training: Vec<&EpisodeMotion> = episodes.iter().filter(|episode| !episode.held_out).collect();
        let positions: Vec<&[f64]> = training.iter().map(|episode| episode.raw[j].as_slice()).collect();
        let (density, interval) = (jerk_density(&positions), training.first().map_or(1.0, |e| e.grid.dt));
        for episode in episodes.iter_mut() {
            let own = density * (episode.grid.dt / interval).powi(5);
            episode.causal.push(causal_states(&episode.raw[j], episode.grid.dt, own));
        }
    }
}

/// Largest minus smallest value.
pub(crate) fn range<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    (high - low).max(0.0)
}

fn positions(
    recording: &JointRecording,
    episode: &str,
    joint: &str,
) -> Result<(Vec<f64>, Vec<f64>), MechanismError> {
    let late = recording.metadata.delay_of("q", joint);
    recording
        .stream(episode, "q", joint)
        .filter(|(t, _)| t.len() >= MIN_POSITIONS)
        .map(|(t, q)| (t.iter().map(|t| t - late).collect(), q))
        .ok_or_else(|| MechanismError::Unsuitable {
            recording: recording.metadata.name.clone(),
            reason: format!("episode {episode} has fewer than {MIN_POSITIONS} positions q_{joint}"),
            remedy: "remove the episode, or record more".to_owned(),
        })
}

/// Largest median interval of a joint's positions and of its drive's stream in the training episodes, s.
fn slowest_interval(recording: &JointRecording, joint: &str) -> f64 {
    let streams = ["q", "effort", "target"];
    let of = |episode: &trundle_record::Episode| {
        let intervals =
            streams.iter().filter_map(|stream| median_interval(&episode.joint_stream(stream, joint)?.0));
        intervals.fold(0.0, f64::max)
    };
    let is_training = |episode: &&trundle_record::Episode| !recording.metadata.is_held_out(&episode.name);
    recording.episodes.iter().filter(is_training).map(of).fold(0.0, f64::max)
}

fn smooth(
    recording: &JointRecording,
    index: usize,
    streams: &[&(Vec<f64>, Vec<f64>)],
    stage_sd: f64,
) -> EpisodeMotion {
    let episode = &recording.episodes[index];
    let start = streams.iter().map(|(t, _)| t[0]).fold(f64::NEG_INFINITY, f64::max);
    let end = streams.iter().map(|(t, _)| t[t.len() - 1]).fold(f64::INFINITY, f64::min);
    let native = streams.iter().filter_map(|(t, _)| median_interval(t)).fold(f64::INFINITY, f64::min);
    let dt = native.max(stage_sd / 3.0).min(stage_sd);
    let grid = Grid { start, dt, len: 1 + ((end - start).max(0.0) / dt + 1e-9) as usize };
    let kernel = Kernel::flat(stage_sd, dt);
    let mut motion = EpisodeMotion {
        name: episode.name.clone(),
        held_out: recording.metadata.is_held_out(&episode.name),
        grid,
        raw: vec![],
        q: vec![],
        v: vec![],
        a: vec![],
        causal: vec![],
        usable: vec![],
    };
    for (t, q) in streams {
        let raw = interpolated(t, q, &grid);
        let inside = |k: usize| k >= kernel.half && k + kernel.half < grid.len;
        let mut found = [vec![0.0; grid.len], vec![0.0; grid.len], vec![0.0; grid.len]];
        for k in (0..grid.len).filter(|k| inside(*k)) {
            let values = kernel.derivatives(&raw, k);
            found.iter_mut().zip(values).for_each(|(series, value)| series[k] = value);
        }
        // The ends hold the nearest value, so that models can be evaluated there. They are not compared.
        if grid.len > 2 * kernel.half {
            let (first, last) = (kernel.half, grid.len - kernel.half - 1);
            for k in (0..first).chain(last + 1..grid.len) {
                found[0][k] = raw[k];
                found[1][k] = found[1][if k < first { first } else { last }];
            }
        }
        let gaps = in_gap(t, &grid, MAX_GAP_SDS * stage_sd.max(native));
        let mut usable: Vec<bool> = (0..grid.len).map(inside).collect();
        for k in (0..grid.len).filter(|k| gaps[*k]) {
            let reach = k.saturating_sub(kernel.half)..(k + kernel.half + 1).min(grid.len);
            usable[reach].fill(false);
        }
        let [q, v, a] = found;
        motion.raw.push(raw);
        motion.q.push(q);
        motion.v.push(v);
        motion.a.push(a);
        motion.usable.push(usable);
    }
    motion
}
