//! Command of one push.

use serde::{Deserialize, Serialize};

use crate::DriveMode;

/// Command of one episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// Initial pose of the object at rest, world frame, m and rad.
    #[serde(default)]
    pub start: [f64; 3],
    /// Pose of the gripper in the object frame, m and rad. A tip starts on the rim, with its heading into the object.
    pub grasp: [f64; 3],
    /// Meaning of the knots.
    pub drive: DriveMode,
    /// Piecewise linear command: knots `[t, x, y, about z]`, with t in s since contact.
    pub knots: Vec<[f64; 4]>,
}
