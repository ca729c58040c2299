//! Recordings of pushed objects and of joints: reading, writing, validation, checks, and preparation for estimation.

mod any_recording;
mod check;
mod document;
mod episode;
mod error;
mod escaped;
mod fault;
mod folder;
mod inertia;
mod info;
mod joints;
mod metadata;
mod motion;
mod prepare;
mod recording;
mod replace;
mod scaled;
mod table;
mod validate;
mod write;

pub use any_recording::AnyRecording;
pub use check::{Finding, Severity, check};
pub use episode::{Episode, Gripper, Stream, WrenchStream};
pub use error::{Error, File, Place};
pub use fault::Fault;
pub use inertia::{InertialShare, MAX_QUASI_STATIC_SHARE};
pub use info::{EpisodeInfo, Info, StreamInfo, inspect};
pub use joints::{
    Axis, DelayMeta, EffortMeta, EffortSettings, EffortSource, EncoderMeta, EncoderSide, EpisodeMeta, FreeOr,
    JOINT_FORMAT, JointEpisodeInfo, JointInfo, JointMetadata, JointMotionInfo, JointNoise, JointNoiseInfo,
    JointRecording, MechanismMeta, Payload, PerJoint, StartMeta, TargetMeta, TargetSettings, check_joints,
    inspect_joints,
};
pub use metadata::{
    Contact, Dof, FORMAT, FixtureMeta, Frame, Metadata, NoiseMeta, ObjectMeta, Obstacle, Precontact,
    Reference, Scene, Sign, Source, Split, WrenchMeta,
};
pub use motion::{
    MIN_POSES_FOR_MOTION, Motion, MotionCache, filter, filter_from, low_pass, smooth, smooth_from,
};
pub use prepare::{
    Counts, Dataset, Noise, Options as PrepareOptions, PoseSample, Prepared, ReadingAxes, TareMethod,
    Wrench6, WrenchPose, WrenchSample, force_moment_transform, mean_pose_noise, planar_transform, prepare,
    prepare_with, relative_pose, wrapped,
};
pub use recording::Recording;
pub use replace::{recover_folder, replace_folder};
pub use table::{Column, Table, write_parquet};
