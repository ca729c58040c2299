//! Discriminating trajectories: how far two explanations of a recording differ along an imposed motion.
//!
//! The recorded effort that the true model predicts for a motion follows from inverse dynamics, so that nothing is
//! simulated. The other model is refitted to it, together with what the recording tells about its parameters.

mod competing_model;
mod designer;
mod limits;
mod plan;
mod predicted_commands;
mod separation;

pub use designer::{JointDesigner, NamedEffect, Separation};
pub use limits::JointLimits;
pub use plan::Plan;
