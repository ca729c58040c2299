//! Reinforcement-learning tasks: push an object with hidden effects to a pose, along a path, around an obstacle or through
//! a door.

mod action_mode;
mod action_model;
mod arm;
mod batch;
mod checksum;
mod command_queue;
pub mod constants;
mod costs;
mod episode;
mod external_step;
mod hidden;
mod measurement_delay;
mod memory;
mod object_sets;
mod options;
mod outcome;
mod push_task;
mod scene_layout;
mod sensors;
mod task_objects;

pub use action_mode::ActionMode;
pub use arm::{ArmOptions, WristOptions};
pub use batch::{Autoreset, Batch, Rows};
pub use costs::Costs;
pub use external_step::ExternalStep;
pub use hidden::HiddenEffects;
pub use object_sets::{Level, OBJECT_SETS, ObjectSet, Outline, Split, WheelLayout};
pub use options::{HiddenKind, Options, TaskKind};
pub use outcome::Outcome;
pub use push_task::PushTask;
pub use scene_layout::{ResetOptions, SceneLayout};
pub(crate) use task_objects::read_object;
pub use task_objects::{TaskObject, TaskObjects, household_names};
