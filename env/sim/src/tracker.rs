//! Pose tracker, for example cameras that see markers on the object and on the gripper.

use serde::{Deserialize, Serialize};

use trundle_model::Plant;

use crate::SimError;
use crate::gripper::compose;
use crate::sensor::{check_non_negative, check_rate};

/// A tracker of planar poses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tracker {
    /// Samples per second.
    pub rate: f64,
    /// Standard deviation of the pose of object and gripper, `[m, m, rad]`.
    pub noise: [f64; 3],
    /// Probability that a sample is lost.
    pub drop_out: f64,
}

impl Default for Tracker {
    /// Noise of 0.5 mm and 0.1° at 60 Hz.
    fn default() -> Self {
        Self { rate: 60.0, noise: [5e-4, 5e-4, 1.75e-3], drop_out: 0.0 }
    }
}

impl Tracker {
    /// Check the values.
    ///
    /// # Errors
    /// If the rate is not positive, a noise is negative, or the drop-out probability is not in [0, 1).
    pub fn check(&self) -> Result<(), SimError> {
        check_rate("tracker.rate", self.rate)?;
        for noise in self.noise {
            check_non_negative("tracker.noise", noise)?;
        }
        if !(0.0..1.0).contains(&self.drop_out) {
            return Err(SimError::value("tracker.drop_out", self.drop_out, "must lie in [0, 1)"));
        }
        Ok(())
    }

    /// Pose of the tracked frame without noise, with the object at `object`.
    pub fn tracked_pose(&self, object: [f64; 3], plant: &Plant<f64>) -> [f64; 3] {
        plant.mount().map_or(object, |mount| compose(object, mount))
    }
}
