//! `recording.toml`: what the columns mean, and what is known of the object.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use trundle_model::Fixture;

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

/// The object: its shape, and its mass where it was weighed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectMeta {
    /// Vertices of a simple polygon, m, object frame, in either orientation and kept as given; may be
    /// empty beside fixtures, or on a rail.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub footprint: Vec<[f64; 2]>,
    /// Weighed mass, kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Where feet or wheels touch the floor, m, object frame; empty if unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub support: Vec<[f64; 2]>,
    /// How the object can move.
    #[serde(default = "Dof::all")]
    pub dof: Vec<Dof>,
    /// Several shapes instead of one footprint; they count where both are given.
    #[serde(default, rename = "fixture", skip_serializing_if = "Vec::is_empty")]
    pub fixtures: Vec<FixtureMeta>,
}

impl ObjectMeta {
    /// The shape as the model wants it: the fixtures, which stand instead of a footprint, or else one
    /// polygon of density 1; empty on a rail without a shape.
    pub fn shape(&self) -> Vec<Fixture> {
        if self.footprint.is_empty() || !self.fixtures.is_empty() {
            return self.fixtures.iter().filter_map(FixtureMeta::shape).collect();
        }
        vec![Fixture::Polygon { vertices: self.footprint.clone(), density: 1.0 }]
    }
}

/// A polygon or a disc with its relative density. Exactly one of the two is given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixtureMeta {
    /// Vertices, m, object frame, in either orientation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polygon: Option<Vec<[f64; 2]>>,
    /// Centre x, y and radius, m, object frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disc: Option<[f64; 3]>,
    /// Density relative to the other fixtures.
    #[serde(default = "one")]
    pub density: f64,
}

impl FixtureMeta {
    fn shape(&self) -> Option<Fixture> {
        let density = self.density;
        match (&self.polygon, self.disc) {
            (Some(vertices), _) => Some(Fixture::Polygon { vertices: vertices.clone(), density }),
            (None, Some([x, y, radius])) => Some(Fixture::Disc { center: [x, y], radius, density }),
            (None, None) => None,
        }
    }
}

/// One degree of freedom of the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Dof {
    /// Along the world's x.
    X,
    /// Along the world's y.
    Y,
    /// About the vertical.
    Theta,
}

impl Dof {
    /// Free in the plane.
    pub fn all() -> Vec<Self> {
        vec![Self::X, Self::Y, Self::Theta]
    }
}

/// What the wrench columns mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WrenchMeta {
    /// Axes of the reading.
    pub frame: Frame,
    /// Point that the torque is about; where it is left out, the origin of the sensor frame for a
    /// reading in sensor axes and of the object frame otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// Whether the reading is the wrench on the object or its reaction.
    pub sign: Sign,
    /// Whether the reading still holds the sensor's offset and the gripper's weight.
    #[serde(default)]
    pub raw: bool,
    /// An interval without contact, for the tare.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub precontact: Option<Precontact>,
    /// How the gripper holds the object.
    #[serde(default)]
    pub contact: Contact,
    /// Where the reading comes from.
    #[serde(default)]
    pub source: Source,
    /// Mass of what hangs below the sensor, kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gripper_mass: Option<f64>,
    /// Its mass centre, m, sensor frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gripper_com: Option<[f64; 3]>,
}

impl WrenchMeta {
    /// The point that the torque is about.
    pub fn reference(&self) -> Reference {
        self.reference.unwrap_or(match self.frame {
            Frame::Sensor => Reference::Sensor,
            Frame::Object | Frame::World => Reference::Object,
        })
    }

    /// The point that the torque is about in an episode whose wrench has the axes `present`: a point
    /// contact without `torque_z` bears none about the sensor, whatever `reference` says.
    pub fn reference_for(&self, present: [bool; 6]) -> Reference {
        match (self.contact, present[5]) {
            (Contact::Point, false) => Reference::Sensor,
            _ => self.reference(),
        }
    }

    /// The interval without contact of `episode`, s.
    pub fn precontact(&self, episode: &str) -> Option<[f64; 2]> {
        match self.precontact.as_ref()? {
            Precontact::Everywhere(interval) => Some(*interval),
            Precontact::ByEpisode(table) => table.get(episode).copied(),
        }
    }
}

/// Axes of the reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Frame {
    /// Of the force-torque sensor, which is the gripper frame.
    Sensor,
    /// Of the object.
    Object,
    /// Of the world.
    World,
}

/// Point that the torque is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Reference {
    /// Origin of the sensor frame.
    Sensor,
    /// Origin of the object frame.
    Object,
}

/// Which of the two opposite wrenches is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sign {
    /// The wrench that acts on the object.
    OnObject,
    /// Its reaction, which acts on the sensor.
    OnSensor,
}

/// How the gripper holds the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Contact {
    /// Firmly: forces and a moment.
    #[default]
    Grasp,
    /// At a point: no moment about the gripper's origin.
    Point,
}

/// Where the reading comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// A sensor.
    #[default]
    Measured,
    /// A drive's command, whose delay may have either sign.
    Commanded,
}

/// An interval without contact, s: the same in each episode, or one by one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected [start, end] in seconds, or a table {EPISODE = [start, end]}")]
pub enum Precontact {
    /// The same in each episode.
    Everywhere([f64; 2]),
    /// By the episode's name.
    ByEpisode(BTreeMap<String, [f64; 2]>),
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

fn one() -> f64 {
    1.0
}

fn yes() -> bool {
    true
}
