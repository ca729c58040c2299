//! What is at the end of the arm: a gripper that holds, or a tip that only pushes.

use serde::{Deserialize, Serialize};
use trundle_model::{Body, Rigid, State};

use crate::gripper::compose;
use crate::tip::Tip;
use crate::{Coupling, Drive, Gripper, Push, SimError};

/// How far from the rim a tip may be put, m.
const BESIDE: f64 = 0.02;

/// At the end of the arm.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Hand {
    /// Has grasped the object.
    Holds(Gripper),
    /// Presses on the rim; it keeps the heading that it began with.
    Pushes {
        /// Where it is.
        tip: Tip,
        /// World, rad.
        heading: f64,
    },
}

impl Hand {
    /// At the beginning of a push.
    ///
    /// # Errors
    /// When a tip would be put elsewhere than on the rim.
    pub fn new(push: &Push, body: &Body, coupling: Coupling) -> Result<Self, SimError> {
        if push.drive != Drive::Tip {
            return Ok(Self::Holds(Gripper::new(push.grasp, push.start, push.drive, coupling)));
        }
        let [x, y, angle] = push.grasp;
        // From a little outside the rim shows which way is out.
        let out = [x - 1e-3 * angle.cos(), y - 1e-3 * angle.sin()];
        let (distance, normal) = body.outside(out);
        if distance <= 0.0 || distance > BESIDE {
            let remedy = "a tip begins on the rim, and its heading points into the object (m, m, rad)";
            return Err(SimError::value("push.grasp", push.grasp, remedy));
        }
        let rim = [out[0] - distance * normal[0], out[1] - distance * normal[1]];
        let tip = Tip::before(rim, normal, push.start);
        Ok(Self::Pushes { tip, heading: push.start[2] + angle })
    }

    /// The mean wrench on the object over the coming step, object axes about the object origin; what moves moves on.
    /// A tip presses with `most` at most, N.
    pub fn push(
        &mut self,
        command: [f64; 3],
        most: f64,
        body: &Body,
        rigid: &Rigid<f64>,
        state: &State<f64>,
        dt: f64,
    ) -> [f64; 3] {
        match self {
            Self::Holds(gripper) => gripper.push(command, state, rigid, dt),
            Self::Pushes { tip, .. } => tip.push([command[0], command[1]], most, body, rigid, state, dt),
        }
    }

    /// Pose of the gripper and sensor frame in the world, while the object is at `object`.
    pub fn pose(&self, object: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Holds(gripper) => gripper.pose(object),
            Self::Pushes { tip: Tip { at: [x, y], .. }, heading } => [*x, *y, *heading],
        }
    }

    /// A tip that touches nothing yet.
    pub fn withdrawn(at: [f64; 3], object: [f64; 3]) -> Self {
        let [x, y, _] = compose(object, at);
        Self::Pushes { tip: Tip { at: [x, y], withdrawn: true }, heading: object[2] }
    }
}
