//! Preparation of a recording for estimation: planar tared wrenches, masked poses, start of contact.

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
use crate::motion::{self, Motion, MotionCache};
use crate::recording::Recording;

pub use noise::Noise;
pub(crate) use noise::estimated as estimated_noise;
pub(crate) use sampling::{latest, median, median_step, quantile};
pub use tare::TareMethod;
pub(crate) use track::gaps;
pub use transform::{Wrench6, force_moment_transform, planar_transform, relative_pose, wrapped};

/// A wrench sample of an episode.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WrenchSample {
    /// Time on the sensor's clock, s.
    pub t: f64,
    /// Tared force x, y in N and torque about the vertical in N m on the object. In sensor axes about the sensor's origin;
    /// without gripper poses, in the axes and about the reference point of the recording.
    pub reading: [f64; 3],
    /// Pose of the frame of the reading in the object frame at `t`: x, y in m, angle in rad.
    pub frame: [f64; 3],
    /// Noise density of the reading due to the uncertainty of `frame`: variance times correlation time, N² s, N² s,
    /// N² m² s.
    pub frame_noise: [f64; 3],
}

impl WrenchSample {
    /// The wrench in object axes about the object's origin (equation 13 of the paper).
    pub fn on_object(&self) -> [f64; 3] {
        planar_transform(&self.frame, &self.reading)
    }
}

/// A pose sample of an episode.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseSample {
    /// Time on the tracker's clock, s.
    pub t: f64,
    /// Pose of the object frame in the world: x, y in m, continuous theta in rad.
    pub pose: [f64; 3],
}

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

    /// Filtered motion: at each pose from the poses up to that time. Empty for fewer than five poses.
    pub fn filtered_motion(&self, noise: &Noise) -> Vec<Motion> {
        let rest_until = self.rest_until();
        let filter = || motion::filter_from(&self.pose, noise, rest_until);
        self.motion_cache.filtered.get_or_estimate(&self.pose, noise, rest_until, filter)
    }
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
}

/// Rule for the pose that transforms a wrench from the sensor to the object.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WrenchPose {
    /// The smoothed pose at the time of the wrench.
    #[default]
    OwnTime,
    /// The latest recorded pose (equation 13 of the paper).
    Latest,
}

/// Axes of the prepared readings.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ReadingAxes {
    /// Sensor axes, if gripper poses are recorded. Instrument effects are constant in these axes.
    #[default]
    Sensor,
    /// The axes that the recording states. The checks use these to find wrong statements.
    Published,
}

/// Options of [`prepare_with`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// How raw readings are tared.
    pub tare: TareMethod,
    /// Rule for the pose that transforms each wrench to the object.
    pub wrench_pose: WrenchPose,
    /// Axes of the prepared readings.
    pub axes: ReadingAxes,
    /// Acceleration of gravity in the recording's units of length and time. It gives the weight of a tilting gripper.
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

/// Prepares all episodes of `recording` with the default options.
///
/// # Errors
/// If a raw reading has no sample before contact for the tare, the weight of a tilting gripper is unknown and cannot be
/// estimated, required poses are missing, or the shape has no area.
pub fn prepare(recording: &Recording) -> Result<Dataset, Error> {
    prepare_with(recording, Options::default())
}

/// Like [`prepare`], with the given options.
///
/// # Errors
/// See [`prepare`].
pub fn prepare_with(recording: &Recording, options: Options) -> Result<Dataset, Error> {
    assemble::dataset(recording, options)
}

#[cfg(test)]
mod tests;
