//! Summary of a recording in numbers.

use serde::Serialize;

use crate::episode::{Episode, Gripper};
use crate::error::Error;
use crate::motion::Motion;
use crate::prepare::{Counts, Dataset, Noise, Prepared, gaps, median_step, prepare};
use crate::recording::Recording;

/// Summary of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Info {
    /// The recording's name.
    pub name: String,
    /// Stated noise, or an estimate from the data.
    pub noise: Noise,
    /// Mass of the object, kg: stated, or a guess from force and acceleration.
    pub mass: f64,
    /// Whether the recording states the mass.
    pub mass_given: bool,
    /// The episodes, sorted by name.
    pub episodes: Vec<EpisodeInfo>,
}

/// Summary of one episode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EpisodeInfo {
    /// The episode's name.
    pub name: String,
    /// Whether the episode is held out: predicted, never fitted.
    pub held_out: bool,
    /// First and last time, s.
    pub span: [f64; 2],
    /// Start of contact, s.
    pub contact: f64,
    /// Stream of object poses.
    pub object: StreamInfo,
    /// Stream of gripper poses; `None` if there are none.
    pub gripper: Option<StreamInfo>,
    /// Stream of the wrench.
    pub wrench: StreamInfo,
    /// Numbers of masked and missing samples.
    pub counts: Counts,
    /// Smallest and largest force x, force y (N) and torque (N m) after the tare, in the axes of the reading.
    pub wrench_range: [[f64; 2]; 3],
    /// Largest force, N.
    pub peak_force: f64,
    /// Standard deviation of the error of the tare, N, N, N m.
    pub tare_sd: [f64; 3],
    /// Path length of the object's origin, m, and total absolute rotation, rad.
    pub travel: [f64; 2],
    /// Largest speed, m/s, and angular speed, rad/s; `None` with too few poses.
    pub peak_speed: Option<[f64; 2]>,
}

/// Summary of one stream.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StreamInfo {
    /// Number of samples.
    pub samples: usize,
    /// Sampling rate from the median interval, Hz; `None` for fewer than two samples.
    pub rate: Option<f64>,
    /// Number of drop-outs: intervals longer than five median intervals.
    pub gaps: usize,
    /// The longest interval between samples, s.
    pub longest_gap: f64,
}

/// Summary of `recording`.
///
/// # Errors
/// If the recording cannot be prepared.
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

pub(crate) fn stream_info(t: &[f64]) -> StreamInfo {
    StreamInfo {
        samples: t.len(),
        rate: median_step(t).map(|step| 1.0 / step),
        gaps: gaps(t).0,
        longest_gap: t.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max),
    }
}

pub(crate) fn range(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high { [0.0; 2] } else { [low, high] }
}

/// Path length, m, and total absolute rotation, rad. Uses the smoothed path if there is one, because noise lengthens the
/// recorded path.
fn travel(prepared: &Prepared, motion: &[Motion]) -> [f64; 2] {
    let path: Vec<[f64; 3]> = if motion.is_empty() {
        prepared.pose.iter().map(|p| p.pose).collect()
    } else {
        motion.iter().map(|m| m.pose).collect()
    };
    path.windows(2).fold([0.0; 2], |[length, rotation], pair| {
        let [dx, dy, dtheta] = [0, 1, 2].map(|k| pair[1][k] - pair[0][k]);
        [length + dx.hypot(dy), rotation + dtheta.abs()]
    })
}

fn peak_speed(motion: &[Motion]) -> [f64; 2] {
    motion.iter().fold([0.0; 2], |[speed, rate], m| {
        [speed.max(m.twist[0].hypot(m.twist[1])), rate.max(m.twist[2].abs())]
    })
}
