//! End effectors: a gripper that holds the object, or a point contact that only pushes.

use serde::{Deserialize, Serialize};
use trundle_model::{Body, Rigid, State};

use crate::gripper::compose;
use crate::point_contact::PointContact;
use crate::{Coupling, DriveMode, Gripper, Push, SimError};

/// Largest distance between the rim and the start of a point contact, m.
const MAX_RIM_DISTANCE_M: f64 = 0.02;

/// The tool at the end of the arm.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum EndEffector {
    /// Holds the object.
    Gripper(Gripper),
    /// Presses on the rim, with a constant heading.
    PointContact {
        /// Fingertip.
        contact: PointContact,
        /// Heading in the world, rad.
        heading: f64,
    },
}

impl EndEffector {
    /// The end effector at the start of a push.
    ///
    /// # Errors
    /// If a point contact does not start on the rim.
    pub fn new(push: &Push, body: &Body, coupling: Coupling) -> Result<Self, SimError> {
        if push.drive != DriveMode::PointContact {
            return Ok(Self::Gripper(Gripper::new(push.grasp, push.start, push.drive, coupling)));
        }
        let [x, y, angle] = push.grasp;
        // A point slightly outside the rim determines the outward normal.
        let out = [x - 1e-3 * angle.cos(), y - 1e-3 * angle.sin()];
        let (distance, normal) = body.outside(out);
        if distance <= 0.0 || distance > MAX_RIM_DISTANCE_M {
            let remedy = "a tip must start on the rim with its heading into the object (m, m, rad)";
            return Err(SimError::value("push.grasp", push.grasp, remedy));
        }
        let rim = [out[0] - distance * normal[0], out[1] - distance * normal[1]];
        let contact = PointContact::at_rim(rim, normal, push.start);
        Ok(Self::PointContact { contact, heading: push.start[2] + angle })
    }

    /// Advance by one step. Returns the mean wrench on the object over the step, object axes about the object origin.
    /// `max_force` limits the normal force of a point contact, N.
    pub fn step(
        &mut self,
        command: [f64; 3],
        max_force: f64,
        body: &Body,
        rigid: &Rigid<f64>,
        state: &State<f64>,
        dt: f64,
    ) -> [f64; 3] {
        match self {
            Self::Gripper(gripper) => gripper.step(command, state, rigid, dt),
            Self::PointContact { contact, .. } => {
                contact.step([command[0], command[1]], max_force, body, rigid, state, dt)
            }
        }
    }

    /// Pose of the gripper and sensor frame in the world, with the object at `object`.
    pub fn pose(&self, object: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Gripper(gripper) => gripper.pose(object),
            Self::PointContact { contact: PointContact { position: [x, y], .. }, heading } => {
                [*x, *y, *heading]
            }
        }
    }

    /// A retracted point contact at `at` (object frame), with the object at `object`.
    pub fn withdrawn(at: [f64; 3], object: [f64; 3]) -> Self {
        let [x, y, _] = compose(object, at);
        Self::PointContact {
            contact: PointContact { position: [x, y], is_withdrawn: true },
            heading: object[2],
        }
    }
}
