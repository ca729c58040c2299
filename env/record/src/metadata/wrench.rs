//! The `[wrench]` table.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Meaning of the wrench columns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WrenchMeta {
    /// Axes of the reading.
    pub frame: Frame,
    /// Reference point of the torque. Default: the origin of the sensor frame for readings in sensor axes, otherwise the
    /// origin of the object frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// Whether the reading is the wrench on the object or the reaction on the sensor.
    pub sign: Sign,
    /// Whether the reading still contains the sensor's offset and the gripper's weight.
    #[serde(default)]
    pub raw: bool,
    /// Interval without contact, used for the tare.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub precontact: Option<Precontact>,
    /// How the gripper holds the object.
    #[serde(default)]
    pub contact: Contact,
    /// Origin of the reading.
    #[serde(default)]
    pub source: Source,
    /// Mass of the gripper below the sensor, kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gripper_mass: Option<f64>,
    /// Centre of mass of the gripper, m, sensor frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gripper_com: Option<[f64; 3]>,
}

impl WrenchMeta {
    /// Reference point of the torque, with the default resolved.
    pub fn reference(&self) -> Reference {
        self.reference.unwrap_or(match self.frame {
            Frame::Sensor => Reference::Sensor,
            Frame::Object | Frame::World => Reference::Object,
        })
    }

    /// Reference point of the torque in an episode whose wrench has the axes `present`. A point contact without
    /// `torque_z` transmits no torque about the sensor, whatever `reference` is.
    pub fn reference_for(&self, present: [bool; 6]) -> Reference {
        match (self.contact, present[5]) {
            (Contact::Point, false) => Reference::Sensor,
            _ => self.reference(),
        }
    }

    /// Interval without contact of `episode`, s.
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

/// Reference point of the torque.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Reference {
    /// Origin of the sensor frame.
    Sensor,
    /// Origin of the object frame.
    Object,
}

/// Sign convention: the recorded one of two opposite wrenches.
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
    /// Firmly: transmits forces and a torque.
    #[default]
    Grasp,
    /// At a point: transmits no torque about the gripper's origin.
    Point,
}

/// Origin of the reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// Measured by a sensor.
    #[default]
    Measured,
    /// Commanded to a drive; the delay may have either sign.
    Commanded,
}

/// Interval without contact, s: one for all episodes, or one per episode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected [start, end] in seconds, or a table {EPISODE = [start, end]}")]
pub enum Precontact {
    /// The same interval in every episode.
    Everywhere([f64; 2]),
    /// Intervals by episode name.
    ByEpisode(BTreeMap<String, [f64; 2]>),
}
