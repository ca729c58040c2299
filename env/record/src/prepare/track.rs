//! Masked poses of an episode.

use crate::episode::{Episode, Gripper};

use super::outlier::{PoseStatus, classify, unwrapped};
use super::samples::PoseSample;
use super::sampling::median_step;
use super::transform::GripperPose;

/// Length of a drop-out in median intervals.
const MIN_DROP_OUT_INTERVALS: f64 = 5.0;

/// The valid samples of a stream, and the numbers of masked samples.
pub(crate) struct Track<T> {
    pub samples: Vec<T>,
    pub outliers: usize,
    pub held: usize,
}

impl<T> Track<T> {
    fn none() -> Self {
        Self { samples: vec![], outliers: 0, held: 0 }
    }
}

/// Noise of the poses, m, m, rad: `sd` is stated or estimated, `estimated` always estimated.
pub(crate) struct PoseNoise {
    pub sd: [f64; 3],
    pub estimated: [f64; 3],
}

/// Valid poses of the object, with continuous theta.
pub(crate) fn object(episode: &Episode, noise: &PoseNoise) -> Track<PoseSample> {
    let Some(stream) = episode.object() else { return Track::none() };
    let (valid, outliers, held) = masked(&stream.t, &stream.value, noise);
    let poses = unwrapped(valid.iter().map(|&i| stream.value[i]));
    let samples = valid.iter().zip(poses).map(|(&i, pose)| PoseSample { t: stream.t[i], pose }).collect();
    Track { samples, outliers, held }
}

/// Valid poses of the gripper.
pub(crate) fn gripper(episode: &Episode, noise: &PoseNoise) -> Track<GripperPose> {
    let all: Vec<GripperPose> = match episode.gripper() {
        None => return Track::none(),
        Some(Gripper::Level(s)) => {
            s.t.iter().zip(s.value).map(|(&t, pose)| GripperPose::level(t, pose)).collect()
        }
        Some(Gripper::Tilting(s)) => {
            s.t.iter().zip(s.value).map(|(&t, pose)| GripperPose::tilting(t, pose)).collect()
        }
    };
    let times: Vec<f64> = all.iter().map(|p| p.t).collect();
    let planar: Vec<[f64; 3]> = all.iter().map(GripperPose::planar).collect();
    let (valid, outliers, held) = masked(&times, &planar, noise);
    let samples = valid.into_iter().map(|i| all[i].clone()).collect();
    Track { samples, outliers, held }
}

/// Number of drop-outs between increasing `times`, and the minimum length of a drop-out, s.
pub(crate) fn gaps(times: &[f64]) -> (usize, f64) {
    let longest = median_step(times).map_or(f64::INFINITY, |step| MIN_DROP_OUT_INTERVALS * step);
    (times.windows(2).filter(|pair| pair[1] - pair[0] > longest).count(), longest)
}

fn masked(t: &[f64], pose: &[[f64; 3]], noise: &PoseNoise) -> (Vec<usize>, usize, usize) {
    let statuses = classify(t, pose, &noise.sd, &noise.estimated);
    let indices = |wanted: PoseStatus| (0..t.len()).filter(|&i| statuses[i] == wanted).collect::<Vec<_>>();
    (indices(PoseStatus::Valid), indices(PoseStatus::Outlier).len(), indices(PoseStatus::Held).len())
}
