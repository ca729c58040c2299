//! The poses of one episode, masked.

use crate::episode::{Episode, Gripper};

use super::PoseSample;
use super::outlier::{Verdict, judge, unwrapped};
use super::sampling::median_step;
use super::transform::GripperPose;

/// A time between samples longer than this many median ones is a drop-out.
pub(crate) const GAP: f64 = 5.0;

/// A stream with what was masked in it.
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

/// Noise of the poses, m, m, rad: as stated or estimated, and as the data show it.
pub(crate) struct PoseNoise {
    pub sd: [f64; 3],
    pub seen: [f64; 3],
}

/// The object's poses, theta continuous.
pub(crate) fn object(episode: &Episode, noise: &PoseNoise) -> Track<PoseSample> {
    let Some(stream) = episode.object() else { return Track::none() };
    let (kept, outliers, held) = masked(&stream.t, &stream.value, noise);
    let poses = unwrapped(kept.iter().map(|&i| stream.value[i]));
    let samples = kept.iter().zip(poses).map(|(&i, pose)| PoseSample { t: stream.t[i], pose }).collect();
    Track { samples, outliers, held }
}

/// The gripper's poses.
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
    let (kept, outliers, held) = masked(&times, &planar, noise);
    let samples = kept.into_iter().map(|i| all[i].clone()).collect();
    Track { samples, outliers, held }
}

/// Number of drop-outs between increasing `times`, and the length from which on a time without sample is one, s.
pub(crate) fn gaps(times: &[f64]) -> (usize, f64) {
    let longest = median_step(times).map_or(f64::INFINITY, |step| GAP * step);
    (times.windows(2).filter(|pair| pair[1] - pair[0] > longest).count(), longest)
}

fn masked(t: &[f64], pose: &[[f64; 3]], noise: &PoseNoise) -> (Vec<usize>, usize, usize) {
    let verdicts = judge(t, pose, &noise.sd, &noise.seen);
    let indices = |wanted: Verdict| (0..t.len()).filter(|&i| verdicts[i] == wanted).collect::<Vec<_>>();
    (indices(Verdict::Kept), indices(Verdict::Outlier).len(), indices(Verdict::Held).len())
}
