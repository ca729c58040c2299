//! Where to push next: sampled plans, rolled out on the very laws that were fitted.
//!
//! A [`Planner`] looks for the wrenches at the grasp that bring an object to a pose, by model
//! predictive path integral control over [`trundle_model::Plant`]. It never sees a simulated world.

mod cost;
mod distance_field;
mod dynamics;
mod error;
mod grasp_comparison;
mod obstacle_map;
mod planner;
mod polygon;
mod rollout;
mod sampling;
mod settings;
mod value_of_information;

pub use cost::{Cost, PlanningTask};
pub use dynamics::Dynamics;
pub use error::ControlError;
pub use obstacle_map::ObstacleMap;
pub use planner::Planner;
pub use settings::Settings;
