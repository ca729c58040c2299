//! Streams of one joint in one episode.

use crate::bandwidth::{Positions, noise};
use crate::drive::Drive;
use crate::motion::EpisodeMotion;
use crate::resample::{held, held_means, interpolated, median_interval};
use trundle_record::{FreeOr, JointRecording};

/// One joint in one episode, at the uniform times of the motion.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    pub raw: Vec<f64>,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    /// Position and velocity that the samples up to each one tell.
    pub causal: Vec<[f64; 2]>,
    /// Recorded effort or target, unfiltered.
    pub command: Vec<f64>,
    /// Median interval of the recorded effort or target, s; zero without a drive.
    pub interval: f64,
    /// Standard deviation of the white noise of the recorded effort; zero for commands.
    pub noise: f64,
    /// Gain of the effort or stiffness of the target in this episode; `None` if it is free.
    pub gain: Option<f64>,
    /// Damping of the target's drive; `None` if it is free.
    pub drive_damping: Option<f64>,
    /// Limit of the target's drive.
    pub limit: Option<f64>,
    pub known: Vec<f64>,
    pub on: Vec<f64>,
    pub load: Option<Vec<f64>>,
    /// Samples that are compared.
    pub kept: Vec<usize>,
    /// Samples around which the joint rests or turns. They are compared with the weight that friction allows; see
    /// [`crate::rest`].
    pub resting: Vec<usize>,
    /// Factor of the residual at each sample.
    pub weight: Vec<f64>,
}

impl Series {
    /// The streams of a joint, at the times of the smoothed motion.
    pub fn new(
        recording: &JointRecording,
        episode: &EpisodeMotion,
        j: usize,
        joint: &str,
        drive: Drive,
    ) -> Self {
        let (meta, grid) = (&recording.metadata, &episode.grid);
        let stream = |name: &str, late: f64| {
            let (t, values) = recording.stream(&episode.name, name, joint)?;
            Some((t.iter().map(|t| t - late).collect::<Vec<f64>>(), values))
        };
        let effort = meta.effort_of(&episode.name, joint);
        let target = meta.target_of(&episode.name, joint);
        let sampled = |name: &str, is_held: bool| {
            let (t, values) = stream(name, meta.delay_of(name, joint))?;
            Some(if is_held { held(&t, &values, grid) } else { interpolated(&t, &values, grid) })
        };
        // A switch is not smooth.
        let switch =
            stream("on", meta.delay_of("on", joint)).map(|(t, values)| held_means(&t, &values, grid));
        let zeros = || vec![0.0; grid.len];
        let (command, gain) = match drive {
            Drive::None => (None, Some(1.0)),
            Drive::Effort(_) => (sampled("effort", drive.is_held()), effort.gain.value()),
            Drive::Target => (sampled("target", drive.is_held()), target.stiffness.value()),
        };
        let name = if drive == Drive::Target { "target" } else { "effort" };
        let record = stream(name, 0.0).unwrap_or_default();
        Self {
            raw: episode.raw[j].clone(),
            q: episode.q[j].clone(),
            v: episode.v[j].clone(),
            a: episode.a[j].clone(),
            causal: episode.causal[j].clone(),
            command: command.unwrap_or_else(zeros),
            interval: median_interval(&record.0).unwrap_or(0.0),
            noise: if drive.is_held() { 0.0 } else { noise(&[Positions { t: &record.0, q: &record.1 }]) },
            gain,
            drive_damping: match target.damping {
                FreeOr::Free => None,
                FreeOr::Value(value) => Some(value),
            },
            limit: (drive == Drive::Target).then_some(target.limit).flatten(),
            known: sampled("known", false).unwrap_or_else(zeros),
            on: switch.unwrap_or_else(|| vec![1.0; grid.len]),
            load: sampled("load", false),
            kept: vec![],
            resting: vec![],
            weight: vec![1.0; grid.len],
        }
    }

    /// Recorded effort, or error of the target.
    pub fn command_error(&self, drive: Drive, k: usize) -> f64 {
        self.command[k] - if drive == Drive::Target { self.raw[k] } else { 0.0 }
    }
}
