//! Content of `recording.toml` of a recording of joints.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::drive::{EffortMeta, EncoderMeta, EpisodeMeta, TargetMeta};
use super::per_joint::PerJoint;
use crate::metadata::Split;

/// The value of `format` of a recording of joints.
pub const JOINT_FORMAT: &str = "trundle-recording/2";

/// Content of `recording.toml` of a recording of joints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointMetadata {
    /// Always [`JOINT_FORMAT`] in a valid recording.
    pub format: String,
    /// Display name of the recording.
    pub name: String,
    /// The mechanism.
    pub mechanism: MechanismMeta,
    /// Meaning of the columns `effort_*`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub effort: EffortMeta,
    /// Drives of joints with a target and no effort.
    #[serde(default, skip_serializing_if = "is_default")]
    pub target: TargetMeta,
    /// Where the encoders are.
    #[serde(default, skip_serializing_if = "is_default")]
    pub encoder: EncoderMeta,
    /// Stated noise; if absent, it is estimated from the data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<JointNoise>,
    /// Known delays of the streams.
    #[serde(default, skip_serializing_if = "is_default")]
    pub delay: DelayMeta,
    /// What differs in single episodes, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub episode: BTreeMap<String, EpisodeMeta>,
    /// Partition into training and held-out episodes.
    #[serde(default, skip_serializing_if = "is_default")]
    pub split: Split,
    /// State at the first sample.
    #[serde(default, skip_serializing_if = "is_default")]
    pub start: StartMeta,
    /// Free-form notes, never interpreted.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub notes: toml::Table,
}

/// A model with its recorded joints, one axis without a model, or joints whose simulator is a function of the user.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MechanismMeta {
    /// MJCF or URDF: a path inside the folder, with `/`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Type of the only joint, if there is no model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<Axis>,
    /// Types of the joints of the user's own simulator, if there is neither a model nor an axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub types: Option<PerJoint<Axis>>,
    /// Names of the recorded joints.
    pub joints: Vec<String>,
    /// What may be refitted, for example `armature:elbow`. Default: armature and damping of all recorded joints, and the
    /// masses of all moving bodies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub free: Option<Vec<String>>,
    /// Axis only: the motion is imposed from outside, and the effort measured.
    #[serde(default, skip_serializing_if = "is_default")]
    pub imposed: bool,
    /// Axis only: known inertia, kg m^2 or kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<f64>,
    /// Hinge without a model only: the nominal model has the gravity torque -(a sin q + b cos q).
    #[serde(default, skip_serializing_if = "is_default")]
    pub gravity: bool,
    /// Known a of the gravity torque, N m; then b = 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity_torque: Option<f64>,
}

/// Type of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", expecting = "\"hinge\" or \"slide\"")]
pub enum Axis {
    /// Rotation; positions in rad, efforts in N m.
    Hinge,
    /// Translation; positions in m, efforts in N.
    Slide,
}

/// Stated measurement noise, one standard deviation each.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointNoise {
    /// Of a position, quantisation included, rad or m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<PerJoint<f64>>,
    /// Step of the encoder, rad or m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_step: Option<PerJoint<f64>>,
    /// Of a measured velocity, rad/s or m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<PerJoint<f64>>,
    /// Of an effort, in recorded units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effort: Option<PerJoint<f64>>,
}

/// Known delays of the streams, s: by how much each is late.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DelayMeta {
    /// Of the positions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub q: Option<PerJoint<f64>>,
    /// Of the measured velocities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub v: Option<PerJoint<f64>>,
    /// Of the efforts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effort: Option<PerJoint<f64>>,
    /// Of the targets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<PerJoint<f64>>,
}

/// State at the first sample of an episode.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartMeta {
    /// Whether the mechanism is at rest; otherwise the first velocities are estimated.
    #[serde(default)]
    pub at_rest: bool,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
