//! Recordings of joints: `trundle-recording/2`.

mod check;
mod columns;
mod document;
mod drive;
mod files;
mod gaussian;
mod includes;
mod info;
mod metadata;
mod per_joint;
mod recording;
mod settings;
mod tracks;
mod validate;

pub use check::check_joints;
pub(crate) use columns::stream_rank;
pub use drive::{EffortMeta, EffortSource, EncoderMeta, EncoderSide, EpisodeMeta, Payload, TargetMeta};
pub(crate) use files::owned_files;
pub use info::{JointEpisodeInfo, JointInfo, JointMotionInfo, JointNoiseInfo, inspect_joints};
pub use metadata::{Axis, DelayMeta, JOINT_FORMAT, JointMetadata, JointNoise, MechanismMeta, StartMeta};
pub use per_joint::{FreeOr, PerJoint};
pub use recording::JointRecording;
pub use settings::{EffortSettings, TargetSettings};
