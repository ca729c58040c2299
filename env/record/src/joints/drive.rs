//! The tables `[effort]`, `[target]`, `[encoder]` and `[episode.NAME]`.

use serde::{Deserialize, Serialize};

use super::per_joint::{FreeOr, PerJoint};

/// Meaning of the columns `effort_JOINT`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffortMeta {
    /// Origin of the effort. Default: measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<PerJoint<EffortSource>>,
    /// N m or N per recorded unit. Default: 1 for measured and commanded efforts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<PerJoint<FreeOr>>,
    /// Whether the effort has a sign. Default: true.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signed: Option<PerJoint<bool>>,
}

/// Drives of joints with a target and no effort: effort = stiffness (target - q) - damping v, limited.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetMeta {
    /// N m/rad or N/m. Default: free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<PerJoint<FreeOr>>,
    /// N m s/rad or N s/m. Default: free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<PerJoint<FreeOr>>,
    /// Largest effort, N m or N. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<PerJoint<f64>>,
}

/// Where the encoders are.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EncoderMeta {
    /// Side of the transmission. Default: the joint's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<PerJoint<EncoderSide>>,
}

/// Origin of an effort.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", expecting = "\"measured\", \"commanded\", \"current\" or \"voltage\"")]
pub enum EffortSource {
    /// Measured by a sensor; interpolated between samples.
    #[default]
    Measured,
    /// Commanded to the drive; held until the next sample.
    Commanded,
    /// Current of the motor; interpolated between samples.
    Current,
    /// Voltage of the motor; held until the next sample. Back-EMF is part of the damping while the drive is on.
    Voltage,
}

/// Side of a transmission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", expecting = "\"joint\" or \"drive\"")]
pub enum EncoderSide {
    /// Behind the gear, on the joint.
    #[default]
    Joint,
    /// Before the gear, on the drive.
    Drive,
}

/// What differs in one episode.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "EpisodeTable", into = "EpisodeTable")]
pub struct EpisodeMeta {
    /// A point mass on a body.
    pub payload: Option<Payload>,
    /// Another model with the same joints: a path inside the folder.
    pub model: Option<String>,
    /// Other values of keys of `[effort]`.
    pub effort: EffortMeta,
    /// Other values of keys of `[target]`.
    pub target: TargetMeta,
}

/// A point mass on a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// The body of the model.
    pub body: String,
    /// kg.
    pub mass: f64,
    /// Place of the mass in the axes of the body, m.
    pub com: [f64; 3],
}

/// The table `[episode.NAME]`: the keys of `[effort]` and `[target]` are its own keys, or in tables of these names.
#[derive(Default, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct EpisodeTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    source: Option<PerJoint<EffortSource>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gain: Option<PerJoint<FreeOr>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    signed: Option<PerJoint<bool>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stiffness: Option<PerJoint<FreeOr>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    damping: Option<PerJoint<FreeOr>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    limit: Option<PerJoint<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    payload: Option<Payload>,
    #[serde(skip_serializing)]
    effort: Option<EffortMeta>,
    #[serde(skip_serializing)]
    target: Option<TargetMeta>,
}

impl TryFrom<EpisodeTable> for EpisodeMeta {
    type Error = String;

    fn try_from(table: EpisodeTable) -> Result<Self, String> {
        let (effort, target) = (table.effort.unwrap_or_default(), table.target.unwrap_or_default());
        Ok(Self {
            payload: table.payload,
            model: table.model,
            effort: EffortMeta {
                source: once("source", "effort", table.source, effort.source)?,
                gain: once("gain", "effort", table.gain, effort.gain)?,
                signed: once("signed", "effort", table.signed, effort.signed)?,
            },
            target: TargetMeta {
                stiffness: once("stiffness", "target", table.stiffness, target.stiffness)?,
                damping: once("damping", "target", table.damping, target.damping)?,
                limit: once("limit", "target", table.limit, target.limit)?,
            },
        })
    }
}

fn once<T>(key: &str, group: &str, flat: Option<T>, nested: Option<T>) -> Result<Option<T>, String> {
    if flat.is_some() && nested.is_some() {
        return Err(format!("`{key}` and `{group}.{key}` are both set; keep one of them"));
    }
    Ok(flat.or(nested))
}

impl From<EpisodeMeta> for EpisodeTable {
    fn from(meta: EpisodeMeta) -> Self {
        Self {
            model: meta.model,
            source: meta.effort.source,
            gain: meta.effort.gain,
            signed: meta.effort.signed,
            stiffness: meta.target.stiffness,
            damping: meta.target.damping,
            limit: meta.target.limit,
            payload: meta.payload,
            effort: None,
            target: None,
        }
    }
}
