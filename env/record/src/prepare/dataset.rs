//! A prepared recording.

use serde::Serialize;
use trundle_model::Body;

use super::noise::Noise;
use super::options::WrenchPose;
use super::samples::{PoseSample, WrenchSample};
use crate::motion::{self, Motion, MotionCache};

/// Numbers of masked and missing samples of an episode.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Object poses that are tracking errors: jumps and spikes.
    pub pose_outliers: usize,
    /// Object poses that repeat the previous one.
    pub pose_held: usize,
    /// Drop-outs of the object's poses: intervals longer than five median intervals.
    pub pose_gaps: usize,
    /// Gripper poses that are tracking errors.
    pub gripper_outliers: usize,
    /// Gripper poses that repeat the previous one.
    pub gripper_held: usize,
    /// Drop-outs of the wrench.
    pub wrench_gaps: usize,
    /// Wrench samples before the first pose; they use the first pose.
    pub before_first_pose: usize,
    /// Wrench samples whose latest pose lies before a drop-out.
    pub stale_pose: usize,
}

/// A prepared episode.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Prepared {
    /// The episode's name.
    pub name: String,
    /// Index among all episodes of the recording.
    pub ordinal: usize,
    /// Wrench samples in chronological order.
    pub wrench: Vec<WrenchSample>,
    /// Poses in chronological order, without outliers and held values.
    pub pose: Vec<PoseSample>,
    /// Start of contact, s: the time of the first reading that exceeds its noise. If no reading does, the time of the last
    /// reading, or of the first one if the object is not at rest before contact.
    pub contact: f64,
    /// Whether each reading holds until the next one (zero-order hold), as for commands. Otherwise readings are interpolated.
    pub zero_order_hold: bool,
    /// Standard deviation of the error of the tare, reading axes; 0 for a reading that is not raw.
    pub tare_sd: [f64; 3],
    /// Whether the object is at rest until contact, according to the recording and to the poses.
    pub at_rest: bool,
    /// Twist at the first pose, world axes, m/s, m/s, rad/s; zero if the object is at rest.
    pub first_twist: [f64; 3],
    /// Numbers of masked and missing samples.
    pub counts: Counts,
    /// Cache of [`Prepared::motion`] and [`Prepared::filtered_motion`].
    pub motion_cache: MotionCache,
}

/// Largest delay of the wrench clock, s. The object is surely at rest until this long before the detected contact.
pub(crate) const REST_MARGIN_S: f64 = 0.2;

impl Prepared {
    /// Time until which the object is surely at rest, s; `None` if it may move from the start.
    pub fn rest_until(&self) -> Option<f64> {
        let first = self.pose.first()?.t;
        self.at_rest.then_some((self.contact - REST_MARGIN_S).max(first))
    }

    /// Smoothed motion: at each pose from all poses. Empty for fewer than five poses.
    pub fn motion(&self, noise: &Noise) -> Vec<Motion> {
        let rest_until = self.rest_until();
        let smooth = || motion::smooth_from(&self.pose, noise, rest_until);
        self.motion_cache.smoothed.get_or_estimate(&self.pose, noise, rest_until, smooth)
    }

    /// Variances of each pose due to the errors of the time stamps, `(velocity · error)²`, m², m², rad²; empty if the
    /// recording states no such error.
    pub fn timing_variances(&self, noise: &Noise) -> Vec<[f64; 3]> {
        if noise.time == 0.0 {
            return vec![];
        }
        let at = |m: &Motion| m.twist.map(|velocity| motion::timing_variance(velocity, noise));
        self.motion(noise).iter().map(at).collect()
    }

    /// Filtered motion: at each pose from the poses up to that time. Empty for fewer than five poses.
    pub fn filtered_motion(&self, noise: &Noise) -> Vec<Motion> {
        let rest_until = self.rest_until();
        let filter = || motion::filter_from(&self.pose, noise, rest_until);
        self.motion_cache.filtered.get_or_estimate(&self.pose, noise, rest_until, filter)
    }
}

/// Root mean square noise of the poses of some episodes, of the tracker and of the time stamps, m, m, rad.
pub fn mean_pose_noise<'a>(episodes: impl Iterator<Item = &'a Prepared>, noise: &Noise) -> [f64; 3] {
    let (mut sum, mut count) = ([0.0; 3], 0.0_f64);
    for variance in episodes.flat_map(|episode| episode.timing_variances(noise)) {
        sum = [0, 1, 2].map(|k| sum[k] + variance[k]);
        count += 1.0;
    }
    [0, 1, 2].map(|k| noise.pose[k].hypot((sum[k] / count.max(1.0)).sqrt()))
}

/// A prepared recording.
#[derive(Debug, Clone)]
pub struct Dataset {
    /// The recording's name.
    pub name: String,
    /// The object. Its mass is the stated one, or an initial guess for a fit.
    pub body: Body,
    /// Whether the object can move along x, along y, and about the vertical.
    pub dof: [bool; 3],
    /// Measurement noise, stated or estimated.
    pub noise: Noise,
    /// Whether the contact transmits no torque about the reference point of the reading.
    pub point_contact: bool,
    /// Whether the wrench is the command of a drive.
    pub commanded: bool,
    /// Rule for the pose that transforms each wrench to the object.
    pub wrench_pose: WrenchPose,
    /// Stated mass, kg; `None` if the mass is to be fitted.
    pub mass_given: Option<f64>,
    /// Training episodes.
    pub training: Vec<Prepared>,
    /// Held-out episodes, which are predicted but never fitted.
    pub held_out: Vec<Prepared>,
    /// Polygons of the fixed obstacles, m, world frame.
    pub obstacles: Vec<Vec<[f64; 2]>>,
}

impl Dataset {
    /// All episodes, training episodes first.
    pub fn episodes(&self) -> impl Iterator<Item = &Prepared> + Clone {
        self.training.iter().chain(&self.held_out)
    }

    /// Name of the episode with an ordinal, as effects choose it; `None` if there is none.
    pub fn episode_name(&self, ordinal: f64) -> Option<&str> {
        self.episodes().find(|episode| episode.ordinal as f64 == ordinal).map(|episode| &*episode.name)
    }
}
