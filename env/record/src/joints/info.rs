//! Summary of a recording of joints in numbers.

use std::collections::BTreeMap;

use serde::Serialize;

use super::columns::STREAMS;
use super::recording::JointRecording;
use super::tracks::{Grid, Track, white_noise};
use crate::episode::Episode;
use crate::info::{StreamInfo, range, stream_info};
use crate::prepare::median;

/// Summary of a recording of joints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointInfo {
    /// The recording's name.
    pub name: String,
    /// Path of the model; `None` for an axis without a model.
    pub model: Option<String>,
    /// The recorded joints with their noise.
    pub joints: Vec<JointNoiseInfo>,
    /// The episodes, sorted by name.
    pub episodes: Vec<JointEpisodeInfo>,
}

/// Noise of the positions of a joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointNoiseInfo {
    /// The joint.
    pub joint: String,
    /// Standard deviation of a position, rad or m.
    pub position_noise: f64,
    /// Whether the recording states it. Otherwise it is estimated from the data.
    pub stated: bool,
}

/// Summary of one episode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointEpisodeInfo {
    /// The episode's name.
    pub name: String,
    /// Whether the episode is held out: predicted, never fitted.
    pub held_out: bool,
    /// First and last time, s.
    pub span: [f64; 2],
    /// The joints, in the order of the recording.
    pub joints: Vec<JointMotionInfo>,
}

/// Motion of one joint in one episode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointMotionInfo {
    /// The joint.
    pub joint: String,
    /// Recorded streams by prefix (`q`, `v`, `effort`, …).
    pub streams: BTreeMap<&'static str, StreamInfo>,
    /// Smallest and largest position, rad or m.
    pub position_range: [f64; 2],
    /// Largest speed, rad/s or m/s; `None` with too few samples.
    pub peak_speed: Option<f64>,
    /// Smallest and largest effort as recorded; `None` without one.
    pub effort_range: Option<[f64; 2]>,
}

/// Summary of `recording`.
pub fn inspect_joints(recording: &JointRecording) -> JointInfo {
    let joints = &recording.metadata.mechanism.joints;
    JointInfo {
        name: recording.metadata.name.clone(),
        model: recording.metadata.mechanism.model.clone(),
        joints: joints.iter().map(|joint| noise_info(recording, joint)).collect(),
        episodes: recording.episodes.iter().map(|episode| episode_info(recording, episode)).collect(),
    }
}

fn noise_info(recording: &JointRecording, joint: &str) -> JointNoiseInfo {
    let stated =
        recording.metadata.noise.as_ref().and_then(|noise| noise.position.as_ref()?.of(joint).copied());
    let positions = recording.episodes.iter().filter_map(|episode| episode.joint_stream("q", joint));
    let estimated = || median(positions.map(|(_, q)| white_noise(&q))).unwrap_or(0.0);
    JointNoiseInfo {
        joint: joint.to_owned(),
        position_noise: stated.unwrap_or_else(estimated),
        stated: stated.is_some(),
    }
}

fn episode_info(recording: &JointRecording, episode: &Episode) -> JointEpisodeInfo {
    let joints = &recording.metadata.mechanism.joints;
    JointEpisodeInfo {
        name: episode.name.clone(),
        held_out: recording.metadata.is_held_out(&episode.name),
        span: [episode.t.first(), episode.t.last()].map(|t| t.copied().unwrap_or(0.0)),
        joints: joints.iter().map(|joint| motion_info(episode, joint)).collect(),
    }
}

fn motion_info(episode: &Episode, joint: &str) -> JointMotionInfo {
    let samples = |prefix| episode.joint_stream(prefix, joint);
    let streams = STREAMS.into_iter().filter_map(|prefix| Some((prefix, stream_info(&samples(prefix)?.0))));
    let grid = Grid::of(episode, &[joint.to_owned()]);
    let track = grid.and_then(|grid| Track::new(episode, joint, grid, None));
    let values = |prefix| samples(prefix).map(|(_, values)| range(values.into_iter()));
    JointMotionInfo {
        joint: joint.to_owned(),
        streams: streams.collect(),
        position_range: values("q").unwrap_or_default(),
        peak_speed: track.map(|track| track.v.iter().fold(0.0, |peak, v| v.abs().max(peak))),
        effort_range: values("effort"),
    }
}
