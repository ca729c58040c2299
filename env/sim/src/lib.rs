//! The world that is pushed: rapier's engine under the model's laws, a gripper with a wrist sensor, a
//! pose tracker, and scenarios that turn all of it into recordings.

mod contact;
mod error;
mod excite;
mod gripper;
mod hand;
mod instruments;
mod mover;
mod object;
mod object_file;
mod profile;
mod push;
mod scenario;
mod sensor;
mod simulate;
pub mod task;
mod threads;
mod tip;
mod tracker;
mod world;

pub use contact::{Obstructed, can_touch};
pub use error::SimError;
pub use excite::Excitation;
pub use gripper::{Coupling, Drive, Gripper};
pub use instruments::{Instruments, Row, Scene, episode};
pub use mover::Mover;
pub use object_file::Object;
pub use profile::Profile;
pub use push::{Push, Setting};
pub use scenario::Scenario;
pub use sensor::{Felt, Hanging, Sensor};
pub use simulate::{metadata, simulate};
pub use task::{Batch, Options, Outcome, Pushing, Reset};
pub use threads::thread_pool;
pub use tracker::Tracker;
pub use world::{Snapshot, World};
