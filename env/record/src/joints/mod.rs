//! Recordings of joints: `trundle-recording/2`.

mod columns;
mod document;
mod drive;
mod files;
mod includes;
mod metadata;
mod per_joint;
mod recording;
mod settings;
mod validate;

pub(crate) use columns::stream_rank;
pub use drive::{EffortMeta, EffortSource, EncoderMeta, EncoderSide, EpisodeMeta, Payload, TargetMeta};
pub(crate) use files::owned_files;
pub use metadata::{Axis, DelayMeta, JOINT_FORMAT, JointMetadata, JointNoise, MechanismMeta, StartMeta};
pub use per_joint::{FreeOr, PerJoint};
pub use recording::JointRecording;
pub use settings::{EffortSettings, TargetSettings};
