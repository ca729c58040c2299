//! Values for all joints or by joint, and values that may be free.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, IntoDeserializer, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A value for all joints, or a table of values by joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum PerJoint<T> {
    /// The same value for all joints.
    All(T),
    /// Values by joint. A joint that the table omits has the default.
    ByJoint(BTreeMap<String, T>),
}

impl<T> PerJoint<T> {
    /// The value for `joint`; `None` if a table by joint omits it.
    pub fn of(&self, joint: &str) -> Option<&T> {
        match self {
            Self::All(value) => Some(value),
            Self::ByJoint(table) => table.get(joint),
        }
    }

    /// Each value with its joint; `None` for the value of all joints.
    pub fn entries(&self) -> Vec<(Option<&str>, &T)> {
        match self {
            Self::All(value) => vec![(None, value)],
            Self::ByJoint(table) => {
                table.iter().map(|(joint, value)| (Some(joint.as_str()), value)).collect()
            }
        }
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for PerJoint<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PerJointVisitor(PhantomData))
    }
}

/// A table is one by joint, everything else is a value. An untagged enum would lose the message of the inner type.
struct PerJointVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for PerJointVisitor<T> {
    type Value = PerJoint<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value for all joints, or a table {JOINT = value}")
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(PerJoint::All)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(PerJoint::All)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(PerJoint::All)
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(PerJoint::All)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        BTreeMap::deserialize(MapAccessDeserializer::new(map)).map(PerJoint::ByJoint)
    }
}

/// A number, or `"free"`: estimated from the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FreeOr {
    /// Estimated.
    Free,
    /// Given.
    Value(f64),
}

impl FreeOr {
    /// The given number; `None` if it is free.
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Free => None,
            Self::Value(value) => Some(value),
        }
    }
}

impl Serialize for FreeOr {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Free => serializer.serialize_str("free"),
            Self::Value(value) => serializer.serialize_f64(*value),
        }
    }
}

impl<'de> Deserialize<'de> for FreeOr {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FreeOrVisitor)
    }
}

struct FreeOrVisitor;

impl Visitor<'_> for FreeOrVisitor {
    type Value = FreeOr;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or \"free\"")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<FreeOr, E> {
        Ok(FreeOr::Value(value as f64))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<FreeOr, E> {
        Ok(FreeOr::Value(value))
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<FreeOr, E> {
        match value {
            "free" => Ok(FreeOr::Free),
            other => Err(E::invalid_value(serde::de::Unexpected::Str(other), &self)),
        }
    }
}
