//! What the wrench columns mean.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

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
