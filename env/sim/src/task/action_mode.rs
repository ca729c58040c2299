//! Meanings of an action.

use serde::{Deserialize, Serialize};

use super::constants::*;

/// Meaning of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ActionMode {
    /// Wrench at the grasp, gripper axes.
    Wrench,
    /// Velocity of the gripper, world axes.
    Velocity,
    /// Push with a fingertip: contact position, push direction and speed.
    Push,
    /// As `Wrench`, followed by the next grasp position, as fractions of half the object's sides, and a request to regrasp.
    Regrasp,
}

impl ActionMode {
    /// Physical values of an action of ones.
    pub fn full_scale(self) -> &'static [f64] {
        match self {
            Self::Wrench => &FULL_WRENCH,
            Self::Velocity => &FULL_VELOCITY,
            Self::Push => &FULL_PUSH,
            Self::Regrasp => &FULL_REGRASP,
        }
    }

    /// Number of entries of an action.
    pub fn width(self) -> usize {
        self.full_scale().len()
    }
}
