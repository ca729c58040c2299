//! A recording as the estimator wants it: planar, tared, masked, with contact found.

mod assemble;
mod contact;
mod mass;
mod noise;
mod outlier;
mod reading;
mod sampling;
mod tare;
mod track;
mod trajectory;
mod transform;

use serde::Serialize;
use trundle_model::Body;

use crate::error::Error;
use crate::motion::{self, Memo, Motion};
use crate::recording::Recording;

pub use noise::Noise;
pub(crate) use noise::estimated as seen_noise;
pub(crate) use sampling::{latest, median, median_step, quantile};
pub use tare::TareMethod;
pub(crate) use track::gaps;
pub use transform::{Wrench6, force_moment_transform, planar_transform, relative_pose, wrapped};

/// One wrench sample of an episode.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WrenchSample {
    /// Time, s, on the sensor's clock.
    pub t: f64,
    /// Force x, y in N and torque about the vertical in N m on the object: tared, in the sensor's axes about the sensor's
    /// origin; without gripper poses, in the axes and about the point that the recording names.
    pub reading: [f64; 3],
    /// x, y in m and angle in rad of the reading's frame in the object frame at `t`.
    pub frame: [f64; 3],
    /// What the uncertainty of that frame adds to the reading: variance times the time over which the error stays the
    /// same, N² s, N² s, N² m² s.
    pub blur: [f64; 3],
}

impl WrenchSample {
    /// The same wrench in object axes about the object's origin (equation 13).
    pub fn on_object(&self) -> [f64; 3] {
        planar_transform(&self.frame, &self.reading)
    }
}

/// One pose sample of an episode.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseSample {
    /// Time, s, on the tracker's clock.
    pub t: f64,
    /// x, y in m and theta in rad (continuous) of the object frame in the world.
    pub pose: [f64; 3],
}

/// What was masked or is missing in an episode.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Object poses that the tracker made up: jumps, spikes.
    pub pose_outliers: usize,
    /// Object poses that repeat the one before.
    pub pose_held: usize,
    /// Drop-outs of the object's poses: intervals several times as long as usual.
    pub pose_gaps: usize,
    /// Gripper poses that the tracker made up.
    pub gripper_outliers: usize,
    /// Gripper poses that repeat the one before.
    pub gripper_held: usize,
    /// Drop-outs of the wrench.
    pub wrench_gaps: usize,
    /// Wrench samples before the first pose, which use the first pose.
    pub before_first_pose: usize,
    /// Wrench samples whose latest pose is older than a drop-out.
    pub stale_pose: usize,
}

/// One episode, prepared.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Prepared {
    /// The episode's name.
    pub name: String,
    /// Its place among all episodes of the recording, from 0.
    pub ordinal: usize,
    /// In order of time.
    pub wrench: Vec<WrenchSample>,
    /// In order of time, outliers and held values left out, theta continuous.
    pub pose: Vec<PoseSample>,
    /// When contact begins, s: the first reading that exceeds its noise, the last if none does (the first, where the
    /// object is not at rest before contact).
    pub contact: f64,
    /// Whether a reading holds until the next one, as a drive's command does; otherwise readings are interpolated.
    pub held: bool,
    /// Standard deviation of the tare's error, reading axes; 0 where the reading is not raw.
    pub tare_sd: [f64; 3],
    /// Whether the object is at rest until contact: as the recording states, and as its poses show.
    pub at_rest: bool,
    /// Twist at the first pose, world axes, m/s, m/s, rad/s: zero where the object is at rest.
    pub first_twist: [f64; 3],
    /// What was masked.
    pub counts: Counts,
    /// What [`Prepared::motion`] and [`Prepared::motion_so_far`] found last.
    pub memo: Memo,
}

/// The wrench's clock may run late by this, s: so much before its contact the object surely rests.
pub(crate) const REST_MARGIN: f64 = 0.2;

impl Prepared {
    /// Until when the object surely rests, s; `None` if it may move from the start.
    pub fn rest_until(&self) -> Option<f64> {
        let first = self.pose.first()?.t;
        self.at_rest.then_some((self.contact - REST_MARGIN).max(first))
    }

    /// Motion at each pose from all poses; empty for fewer than five.
    pub fn motion(&self, noise: &Noise) -> Vec<Motion> {
        let rest_until = self.rest_until();
        let smooth = || motion::smooth_from(&self.pose, noise, rest_until);
        self.memo.smoothed.recall(&self.pose, noise, rest_until, smooth)
    }

    /// Motion at each pose from the poses up to it only; empty for fewer than five.
    pub fn motion_so_far(&self, noise: &Noise) -> Vec<Motion> {
        let rest_until = self.rest_until();
        let filter = || motion::filter_from(&self.pose, noise, rest_until);
        self.memo.so_far.recall(&self.pose, noise, rest_until, filter)
    }
}

/// A whole recording, prepared.
#[derive(Debug, Clone)]
pub struct Dataset {
    /// The recording's name.
    pub name: String,
    /// The object; its mass is the given one, or a guess to start a fit from.
    pub body: Body,
    /// Whether it moves along x, along y, about the vertical.
    pub dof: [bool; 3],
    /// Stated or estimated.
    pub noise: Noise,
    /// Whether the contact bears no moment about the reading's reference point.
    pub point_contact: bool,
    /// Whether the wrench is a drive's command.
    pub commanded: bool,
    /// The pose that brings each wrench to the object.
    pub wrench_pose: WrenchPose,
    /// The weighed mass, kg; `None` where it is to be fitted.
    pub mass_given: Option<f64>,
    /// Episodes to fit.
    pub training: Vec<Prepared>,
    /// Episodes only to predict.
    pub held_out: Vec<Prepared>,
    /// Polygons known to stand there, m, world frame.
    pub obstacles: Vec<Vec<[f64; 2]>>,
}

impl Dataset {
    /// All episodes, those to fit first.
    pub fn episodes(&self) -> impl Iterator<Item = &Prepared> + Clone {
        self.training.iter().chain(&self.held_out)
    }
}

/// The pose that brings a wrench from the sensor to the object.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WrenchPose {
    /// The smoothed pose at the wrench's own time.
    #[default]
    OwnTime,
    /// The latest recorded pose (equation 13 of the paper).
    Latest,
}

/// The axes that prepared readings are given in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ReadingAxes {
    /// The sensor's own, where gripper poses are recorded: what instruments do, they do there.
    #[default]
    Sensor,
    /// As the recording publishes them: what may be published wrongly is looked for there.
    Published,
}

/// How a recording is prepared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// How raw readings are tared.
    pub tare: TareMethod,
    /// The pose that brings each wrench to the object.
    pub wrench_pose: WrenchPose,
    /// The axes that readings are given in.
    pub axes: ReadingAxes,
    /// Acceleration of gravity, in the recording's units of length and time; it weighs a tilting gripper.
    pub gravity: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            tare: TareMethod::default(),
            wrench_pose: WrenchPose::default(),
            axes: ReadingAxes::default(),
            gravity: tare::GRAVITY,
        }
    }
}

/// Prepares every episode of `recording`, each tared as the format states it.
///
/// # Errors
/// If a raw reading has no sample before contact to tare it, if a tilting gripper's weight is not known and
/// cannot be found, if poses that a reading needs are missing, or if the shape has no area.
pub fn prepare(recording: &Recording) -> Result<Dataset, Error> {
    prepare_with(recording, Options::default())
}

/// As [`prepare`], with the methods chosen.
///
/// # Errors
/// As [`prepare`].
pub fn prepare_with(recording: &Recording, options: Options) -> Result<Dataset, Error> {
    assemble::dataset(recording, options)
}

#[cfg(test)]
mod tests;
