//! What a recording holds, in figures.

use serde::Serialize;

use crate::episode::{Episode, Gripper};
use crate::error::Error;
use crate::motion::Motion;
use crate::prepare::{Counts, Dataset, Noise, Prepared, gaps, median_step, prepare};
use crate::recording::Recording;

/// A whole recording in figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Info {
    /// The recording's name.
    pub name: String,
    /// Stated noise, or what the data show.
    pub noise: Noise,
    /// Mass of the object, kg: weighed, or a guess from force and acceleration.
    pub mass: f64,
    /// Whether it was weighed.
    pub mass_given: bool,
    /// In order of their names.
    pub episodes: Vec<EpisodeInfo>,
}

/// One episode in figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EpisodeInfo {
    /// The episode's name.
    pub name: String,
    /// Whether it is only predicted.
    pub held_out: bool,
    /// First and last time, s.
    pub span: [f64; 2],
    /// When contact begins, s.
    pub contact: f64,
    /// The object's poses.
    pub object: StreamInfo,
    /// The gripper's poses; `None` if there are none.
    pub gripper: Option<StreamInfo>,
    /// The wrench.
    pub wrench: StreamInfo,
    /// What was masked or is missing.
    pub counts: Counts,
    /// Smallest and largest force x, force y (N) and torque (N m) after the tare, in the axes of the reading.
    pub wrench_range: [[f64; 2]; 3],
    /// Largest force, N.
    pub peak_force: f64,
    /// Standard deviation of the tare's error, N, N, N m.
    pub tare_sd: [f64; 3],
    /// Length of the path of the object's origin, m, and its turns without regard to sign, rad.
    pub travel: [f64; 2],
    /// Largest speed, m/s, and turn rate, rad/s; `None` with too few poses.
    pub peak_speed: Option<[f64; 2]>,
}

/// One stream in figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StreamInfo {
    /// Number of samples.
    pub samples: usize,
    /// Samples per second, by the median interval; `None` for fewer than two.
    pub rate: Option<f64>,
    /// Number of drop-outs: intervals more than five times as long as usual.
    pub gaps: usize,
    /// The longest interval between samples, s.
    pub longest_gap: f64,
}

/// Figures of `recording`.
///
/// # Errors
/// Where it cannot be prepared.
pub fn inspect(recording: &Recording) -> Result<Info, Error> {
    let dataset = prepare(recording)?;
    let of = |episode: &Episode| {
        let prepared = dataset.episodes().find(|prepared| prepared.name == episode.name)?;
        Some(episode_info(episode, prepared, &dataset))
    };
    Ok(Info {
        name: dataset.name.clone(),
        noise: dataset.noise.clone(),
        mass: dataset.body.mass,
        mass_given: dataset.mass_given.is_some(),
        episodes: recording.episodes.iter().filter_map(of).collect(),
    })
}

fn episode_info(episode: &Episode, prepared: &Prepared, dataset: &Dataset) -> EpisodeInfo {
    let motion = prepared.motion(&dataset.noise);
    let gripper = episode.gripper().map(|gripper| match gripper {
        Gripper::Level(stream) => stream_info(&stream.t),
        Gripper::Tilting(stream) => stream_info(&stream.t),
    });
    EpisodeInfo {
        name: episode.name.clone(),
        held_out: dataset.held_out.iter().any(|held| held.name == episode.name),
        span: [episode.t.first(), episode.t.last()].map(|t| t.copied().unwrap_or(0.0)),
        contact: prepared.contact,
        object: stream_info(&episode.object().map_or(vec![], |stream| stream.t)),
        gripper,
        wrench: stream_info(&episode.wrench().map_or(vec![], |stream| stream.t)),
        counts: prepared.counts.clone(),
        wrench_range: [0, 1, 2].map(|k| range(prepared.wrench.iter().map(|w| w.reading[k]))),
        peak_force: prepared.wrench.iter().map(|w| w.reading[0].hypot(w.reading[1])).fold(0.0, f64::max),
        tare_sd: prepared.tare_sd,
        travel: travel(prepared, &motion),
        peak_speed: (!motion.is_empty()).then(|| peak_speed(&motion)),
    }
}

fn stream_info(t: &[f64]) -> StreamInfo {
    StreamInfo {
        samples: t.len(),
        rate: median_step(t).map(|step| 1.0 / step),
        gaps: gaps(t).0,
        longest_gap: t.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max),
    }
}

fn range(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high { [0.0; 2] } else { [low, high] }
}

/// Along the smoothed path where there is one: noise would add to the length of the recorded one.
fn travel(prepared: &Prepared, motion: &[Motion]) -> [f64; 2] {
    let path: Vec<[f64; 3]> = if motion.is_empty() {
        prepared.pose.iter().map(|p| p.pose).collect()
    } else {
        motion.iter().map(|m| m.pose).collect()
    };
    path.windows(2).fold([0.0; 2], |[way, turn], pair| {
        let [dx, dy, dtheta] = [0, 1, 2].map(|k| pair[1][k] - pair[0][k]);
        [way + dx.hypot(dy), turn + dtheta.abs()]
    })
}

fn peak_speed(motion: &[Motion]) -> [f64; 2] {
    motion.iter().fold([0.0; 2], |[speed, rate], m| {
        [speed.max(m.twist[0].hypot(m.twist[1])), rate.max(m.twist[2].abs())]
    })
}
