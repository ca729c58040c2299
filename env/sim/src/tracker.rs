//! The pose tracker: cameras that see markers on the object and on the gripper.

use serde::{Deserialize, Serialize};

use trundle_model::Plant;

use crate::SimError;
use crate::gripper::compose;
use crate::sensor::{check_noise, check_rate};

/// A tracker of planar poses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tracker {
    /// Samples per second.
    pub rate: f64,
    /// Standard deviation of a pose, `[m, m, rad]`, of the object and of the gripper alike.
    pub noise: [f64; 3],
    /// Probability that a sample is lost.
    pub drop_out: f64,
}

impl Default for Tracker {
    /// 0.5 mm and 0.1°.
    fn default() -> Self {
        Self { rate: 60.0, noise: [5e-4, 5e-4, 1.75e-3], drop_out: 0.0 }
    }
}

impl Tracker {
    /// Refuse what cannot be.
    ///
    /// # Errors
    /// When the rate is not positive, a noise negative, or the drop-out no probability below one.
    pub fn check(&self) -> Result<(), SimError> {
        check_rate("tracker.rate", self.rate)?;
        for noise in self.noise {
            check_noise("tracker.noise", noise)?;
        }
        if !(0.0..1.0).contains(&self.drop_out) {
            return Err(SimError::value("tracker.drop_out", self.drop_out, "must lie in [0, 1)"));
        }
        Ok(())
    }

    /// The pose that it takes for the object's, without noise, when the object is at `object`: that of the frame on the
    /// object which is tracked.
    pub fn sees(&self, object: [f64; 3], plant: &Plant<f64>) -> [f64; 3] {
        plant.mount().map_or(object, |mount| compose(object, mount))
    }
}
