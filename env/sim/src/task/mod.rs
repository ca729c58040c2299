//! Reinforcement-learning tasks: push an object with hidden effects to a pose, along a path, around an obstacle or through
//! a door.

mod action_model;
mod batch;
mod checksum;
pub mod constants;
mod episode;
mod hidden;
mod memory;
mod options;
mod outcome;
mod push_task;
mod scene_layout;
mod sensors;
mod task_objects;

pub use batch::{Autoreset, Batch, Rows};
pub use hidden::HiddenEffects;
pub use options::{ActionMode, HiddenKind, Options, TaskKind};
pub use outcome::Outcome;
pub use push_task::PushTask;
pub use scene_layout::{ResetOptions, SceneLayout};
pub(crate) use task_objects::read_object;
pub use task_objects::{TaskObject, TaskObjects, household_names};
