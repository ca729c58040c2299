//! `recording.toml`: what the columns mean, and what is known of the object.

mod object;
mod wrench;

use serde::{Deserialize, Serialize};

pub use object::{Dof, FixtureMeta, ObjectMeta};
pub use wrench::{Contact, Frame, Precontact, Reference, Sign, Source, WrenchMeta};

/// The one value of `format` that this reader knows.
pub const FORMAT: &str = "trundle-recording/1";

/// Everything in `recording.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metadata {
    /// Always [`FORMAT`] in a valid recording.
    pub format: String,
    /// The recording's name, for people.
    pub name: String,
    /// Whether the object is at rest until contact begins.
    #[serde(default = "yes")]
    pub at_rest: bool,
    /// The object that is pushed.
    pub object: ObjectMeta,
    /// What the columns `force_*` and `torque_*` mean.
    pub wrench: WrenchMeta,
    /// Stated noise; estimated from the data where it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseMeta>,
    /// What is known to stand around.
    #[serde(default, skip_serializing_if = "Scene::is_empty")]
    pub scene: Scene,
    /// Which episodes are only predicted.
    #[serde(default, skip_serializing_if = "Split::is_empty")]
    pub split: Split,
    /// Kept, never interpreted.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub notes: toml::Table,
}

impl Metadata {
    /// Whether the object runs on a rail along x, so that `object_x` and `force_x` are all there is.
    pub fn on_rail(&self) -> bool {
        self.object.dof == [Dof::X]
    }

    /// Whether `episode` is only predicted, never fitted.
    pub fn is_held_out(&self, episode: &str) -> bool {
        self.split.held_out.iter().any(|name| name == episode)
    }
}

/// One standard deviation of what the instruments add.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseMeta {
    /// Of an object pose: x and y in m, theta in rad.
    pub pose: [f64; 3],
    /// Of each force axis, N.
    pub force: f64,
    /// Of each torque axis, N m; may be left out where no torque is measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<f64>,
    /// Of the time stamps, s.
    #[serde(default)]
    pub time: f64,
}

/// What is known to stand around.
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

/// One fixed obstacle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// Vertices of a simple polygon, m, world frame.
    pub polygon: Vec<[f64; 2]>,
}

/// Which episodes are fitted and which only predicted.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Split {
    /// Names of the episodes that are never fitted.
    #[serde(default)]
    pub held_out: Vec<String>,
}

impl Split {
    fn is_empty(&self) -> bool {
        self.held_out.is_empty()
    }
}

fn yes() -> bool {
    true
}
