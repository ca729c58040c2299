//! Input of the checks: the motion of all joints in all episodes.

use crate::episode::Episode;
use crate::joints::drive::EffortSource;
use crate::joints::metadata::{Axis, JointMetadata};
use crate::joints::per_joint::{FreeOr, PerJoint};
use crate::joints::recording::JointRecording;
use crate::joints::tracks::{Grid, Track, rms};
use crate::prepare::median;

/// A recording and the motion that all checks share.
pub(super) struct Input<'a> {
    pub metadata: &'a JointMetadata,
    pub joints: &'a [String],
    /// Episodes with enough samples for a motion.
    pub episodes: Vec<EpisodeTracks<'a>>,
    /// All episodes.
    pub raw: &'a [Episode],
}

/// An episode with the tracks of all joints, on one grid and with one filter.
pub(super) struct EpisodeTracks<'a> {
    pub episode: &'a Episode,
    pub tracks: Vec<Track>,
    pub is_training: bool,
}

impl<'a> Input<'a> {
    pub fn new(recording: &'a JointRecording) -> Self {
        let metadata = &recording.metadata;
        let joints: &[String] = &metadata.mechanism.joints;
        let width = common_width(recording, joints);
        let tracks = |episode: &'a Episode| {
            let grid = Grid::of(episode, joints)?;
            let tracks = joints.iter().map(|joint| Track::new(episode, joint, grid, width));
            let is_training = !metadata.is_held_out(&episode.name);
            Some(EpisodeTracks { episode, tracks: tracks.collect::<Option<_>>()?, is_training })
        };
        let episodes = recording.episodes.iter().filter_map(tracks).collect();
        Self { metadata, joints, episodes, raw: &recording.episodes }
    }

    /// Whether a joint may be a hinge. The type of the joints of a model is not known here.
    pub fn may_be_hinge(&self) -> bool {
        let mechanism = &self.metadata.mechanism;
        let types = mechanism.types.as_ref().map(PerJoint::entries);
        let has_slides_only = types.is_some_and(|types| types.iter().all(|(_, kind)| **kind == Axis::Slide));
        mechanism.axis != Some(Axis::Slide) && !has_slides_only
    }

    /// Episodes with a stream of a joint.
    pub fn has(&self, prefix: &str, joint: &str) -> bool {
        self.raw.iter().any(|episode| episode.joint_stream(prefix, joint).is_some())
    }

    /// Whether the joint has a signed effort in any episode.
    pub fn has_signed_effort(&self, joint: &str) -> bool {
        let is_signed = |episode: &Episode| self.metadata.effort_of(&episode.name, joint).signed;
        self.raw.iter().any(|episode| is_signed(episode) && episode.joint_stream("effort", joint).is_some())
    }

    /// Rms of the noise of the velocity of joint `index`, and of its velocity.
    pub fn speeds(&self, index: usize) -> (f64, f64) {
        let tracks = || self.episodes.iter().map(|episode| &episode.tracks[index]);
        let noise = median(tracks().map(|track| track.v_noise)).unwrap_or(0.0);
        let all: Vec<f64> = tracks().flat_map(|track| track.v.iter().copied()).collect();
        (noise, rms(&all))
    }

    /// Median step of the grids, s.
    pub fn step(&self) -> f64 {
        median(self.episodes.iter().filter_map(|one| Some(one.tracks.first()?.step))).unwrap_or(0.0)
    }
}

impl EpisodeTracks<'_> {
    /// Effort of the drive of a joint in N m or N (in recorded units if the gain is free), filtered like the motion, with
    /// the known effort. `None` without an effort or if it has no sign.
    pub fn effort(&self, metadata: &JointMetadata, index: usize, joint: &str) -> Option<Vec<f64>> {
        let settings = metadata.effort_of(&self.episode.name, joint);
        let held = matches!(settings.source, EffortSource::Commanded | EffortSource::Voltage);
        let track = &self.tracks[index];
        let effort = track.stream(self.episode, "effort", joint, held).filter(|_| settings.signed)?;
        let gain = settings.gain.value().unwrap_or(1.0);
        let known =
            track.stream(self.episode, "known", joint, false).unwrap_or_else(|| vec![0.0; effort.len()]);
        // A known effort has N m or N, which a free gain does not.
        let known_scale = if settings.gain == FreeOr::Free { 0.0 } else { 1.0 };
        Some(effort.iter().zip(known).map(|(effort, known)| gain * effort + known_scale * known).collect())
    }

    /// Whether the drive of a joint is on at each point.
    pub fn is_on(&self, index: usize, joint: &str) -> Vec<bool> {
        let track = &self.tracks[index];
        match track.stream(self.episode, "on", joint, true) {
            // The filter blurs switches, and motion near them is left out.
            Some(on) => on.iter().map(|on| *on > 0.99).collect(),
            None => vec![true; track.t.len()],
        }
    }
}

/// The median of the widths that the moving joints need; `None` if no joint moves.
fn common_width(recording: &JointRecording, joints: &[String]) -> Option<f64> {
    let widths = recording.episodes.iter().flat_map(|episode| {
        let grid = Grid::of(episode, joints);
        joints.iter().filter_map(move |joint| {
            let track = Track::new(episode, joint, grid?, None)?;
            let is_moving = rms(&track.v) > 5.0 * track.v_noise;
            is_moving.then_some(track.width)
        })
    });
    median(widths)
}
