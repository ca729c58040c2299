//! Model predictive control of pushes.
//!
//! A [`Planner`] computes wrenches at the grasp that bring an object to a goal pose, by model predictive path integral
//! control over fitted models ([`trundle_model::Plant`]). It does not use the simulated world.

mod arm;
mod cost;
mod distance_field;
mod dynamics;
mod effort;
mod error;
mod grasp_comparison;
mod obstacle_map;
mod planner;
mod polygon;
mod rollout;
mod sampling;
mod settings;
mod value_of_information;

pub use arm::{ArmEstimate, ArmResponse, AxisResponse, CommandedArm};
pub use cost::{Cost, PlanningTask};
pub use dynamics::{Dynamics, FastStep};
pub use error::{BatchError, ControlError};
pub use obstacle_map::ObstacleMap;
pub use planner::Planner;
pub use settings::Settings;
