//! Content of `recording.toml`: the meaning of the columns, and properties of the object.

mod object;
mod wrench;

use serde::{Deserialize, Serialize};

pub use object::{Dof, FixtureMeta, ObjectMeta};
pub use wrench::{Contact, Frame, Precontact, Reference, Sign, Source, WrenchMeta};

/// The only supported value of `format`.
pub const FORMAT: &str = "trundle-recording/1";

/// Content of `recording.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metadata {
    /// Always [`FORMAT`] in a valid recording.
    pub format: String,
    /// Display name of the recording.
    pub name: String,
    /// Whether the object is at rest until contact.
    #[serde(default = "default_at_rest")]
    pub at_rest: bool,
    /// The pushed object.
    pub object: ObjectMeta,
    /// Meaning of the columns `force_*` and `torque_*`.
    pub wrench: WrenchMeta,
    /// Stated noise; if absent, it is estimated from the data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseMeta>,
    /// Known surroundings.
    #[serde(default, skip_serializing_if = "Scene::is_empty")]
    pub scene: Scene,
    /// Partition into training and held-out episodes.
    #[serde(default, skip_serializing_if = "Split::is_empty")]
    pub split: Split,
    /// Free-form notes, never interpreted.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub notes: toml::Table,
}

impl Metadata {
    /// Whether the object moves on a rail along x, so that only `object_x` and `force_x` are used.
    pub fn on_rail(&self) -> bool {
        self.object.dof == [Dof::X]
    }

    /// Whether `episode` is held out: predicted, never fitted.
    pub fn is_held_out(&self, episode: &str) -> bool {
        self.split.held_out.iter().any(|name| name == episode)
    }
}

/// Stated measurement noise, one standard deviation each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseMeta {
    /// Of an object pose: x and y in m, theta in rad.
    pub pose: [f64; 3],
    /// Of each force axis, N.
    pub force: f64,
    /// Of each torque axis, N m; optional if no torque is measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<f64>,
    /// Of the time stamps, s.
    #[serde(default)]
    pub time: f64,
}

/// Known surroundings of the object.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Fixed obstacles.
    #[serde(default, rename = "obstacle")]
    pub obstacles: Vec<Obstacle>,
}

impl Scene {
    fn is_empty(&self) -> bool {
        self.obstacles.is_empty()
    }
}

/// A fixed obstacle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// Vertices of a simple polygon, m, world frame.
    pub polygon: Vec<[f64; 2]>,
}

/// Partition of the episodes into training and held-out episodes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Split {
    /// Names of the held-out episodes, which are predicted but never fitted.
    #[serde(default)]
    pub held_out: Vec<String>,
}

impl Split {
    fn is_empty(&self) -> bool {
        self.held_out.is_empty()
    }
}

fn default_at_rest() -> bool {
    true
}
