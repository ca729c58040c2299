//! Where to push next: sampled plans, rolled out on the very laws that were fitted.
//!
//! A [`Planner`] looks for the wrenches at the grasp that bring an object to a pose, by model
//! predictive path integral control over [`trundle_model::Plant`]. It never sees a simulated world.

mod cost;
mod dynamics;
mod error;
mod field;
mod grasp;
mod planner;
mod polygon;
mod rollout;
mod room;
mod sampling;
mod settings;
mod worth;

pub use cost::{Cost, Task};
pub use dynamics::Dynamics;
pub use error::ControlError;
pub use planner::Planner;
pub use room::Room;
pub use settings::Settings;
