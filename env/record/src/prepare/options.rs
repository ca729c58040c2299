//! Options of the preparation.

use serde::Serialize;

use super::tare::TareMethod;

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

/// Options of [`prepare_with`](super::prepare_with).
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
            gravity: trundle_model::STANDARD_GRAVITY_M_PER_S2,
        }
    }
}
