//! Simulated pushing: a rapier2d world driven by the model's laws, a gripper with a wrist sensor, a pose tracker,
//! scenarios that produce recordings, and reinforcement-learning tasks.
//!
//! # Examples
//! ```
//! let (scenario, model) = trundle_sim::Scenario::demo()?;
//! let recording = trundle_sim::simulate(&scenario, &model, 0)?;
//! assert_eq!(recording.episodes.len(), 8);
//! # Ok::<(), trundle_sim::SimError>(())
//! ```

mod colliders;
mod contact;
mod end_effector;
mod episode_setup;
mod error;
mod excitation;
mod gripper;
mod hybrid_stepper;
mod instruments;
mod object;
mod obstacle_distance;
mod obstacle_stepper;
mod point_contact;
mod profile;
mod push;
mod scenario;
mod sensor;
mod simulate;
pub mod task;
mod threads;
mod toml_file;
mod tracker;
mod world;

pub use episode_setup::EpisodeSetup;
pub use error::SimError;
pub use excitation::Excitation;
pub use gripper::{Coupling, DriveMode, Gripper};
pub use hybrid_stepper::{ContactMethod, HybridStepper};
pub use instruments::{GroundTruth, Instruments, Row, episode};
pub use object::Object;
pub use obstacle_distance::can_touch;
pub use obstacle_stepper::ObstacleStepper;
pub use profile::Profile;
pub use push::Push;
pub use scenario::Scenario;
pub use sensor::{GripperLoad, GripperPayload, Sensor};
pub use simulate::{metadata, simulate};
pub use task::{Batch, Options, Outcome, PushTask, ResetOptions};
pub use threads::thread_pool;
pub use tracker::Tracker;
pub use world::{Snapshot, World};
