//! An episode: the table of one uninterrupted manipulation, and the streams in it.

use std::collections::BTreeMap;

use crate::fault::Fault;
use crate::joints::stream_rank;

/// Columns of the object's pose, in the order of [`Episode::object`].
pub const OBJECT: [&str; 3] = ["object_x", "object_y", "object_theta"];
/// Columns of a level gripper's pose.
pub const GRIPPER_LEVEL: [&str; 3] = ["gripper_x", "gripper_y", "gripper_theta"];
/// Columns of a tilting gripper's pose.
pub const GRIPPER_TILTING: [&str; 7] =
    ["gripper_x", "gripper_y", "gripper_z", "gripper_qw", "gripper_qx", "gripper_qy", "gripper_qz"];
/// Columns of the wrench, in the order of [`WrenchStream::value`].
pub const WRENCH: [&str; 6] = ["force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"];
/// Prefix of columns that are kept but never interpreted.
pub const NOTE_PREFIX: &str = "note_";

/// Table of one episode. NaN in a cell means that its stream has no sample at that time.
#[derive(Debug, Clone, Default)]
pub struct Episode {
    /// File name of the table without its extension.
    pub name: String,
    /// Sample times, s, strictly increasing.
    pub t: Vec<f64>,
    /// Numeric columns by name, each as long as `t`.
    pub columns: BTreeMap<String, Vec<f64>>,
    /// Columns that begin with `note_`, by name, each as long as `t`.
    pub notes: BTreeMap<String, Vec<String>>,
}

/// Samples of one stream. Rows without a sample are left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Stream<const N: usize> {
    /// Sample times, s.
    pub t: Vec<f64>,
    /// One value per time.
    pub value: Vec<[f64; N]>,
    /// Row of each sample in the table, counted from 0.
    pub row: Vec<usize>,
}

/// Poses of the sensor frame in the world.
#[derive(Debug, Clone, PartialEq)]
pub enum Gripper {
    /// x, y in m and theta in rad as recorded; theta may be wrapped.
    Level(Stream<3>),
    /// x, y, z in m and the unit quaternion w, x, y, z, world-from-sensor.
    Tilting(Stream<7>),
}

/// Wrench readings, in the axes and with the sign that the metadata state.
#[derive(Debug, Clone, PartialEq)]
pub struct WrenchStream {
    /// Sample times, s.
    pub t: Vec<f64>,
    /// Forces x, y, z in N and torques x, y, z in N m; 0 for an axis that is not measured.
    pub value: Vec<[f64; 6]>,
    /// Whether each of the six axes is measured.
    pub present: [bool; 6],
    /// Row of each sample in the table, counted from 0.
    pub row: Vec<usize>,
}

impl Episode {
    /// Adds a numeric column, or sets the times if `title` is `t`.
    pub fn insert(&mut self, title: String, values: Vec<f64>) {
        if title == "t" {
            self.t = values;
        } else {
            self.columns.insert(title, values);
        }
    }

    /// Names of all columns except `t`: those of planar recordings in the order of their format, those of joints by
    /// stream, notes last.
    pub fn header(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.columns.keys().map(String::as_str).collect();
        let planar = |name: &str| known_columns().position(|known| known == name).unwrap_or(usize::MAX);
        names.sort_by_key(|name| (planar(name), stream_rank(name)));
        names.extend(self.notes.keys().map(String::as_str));
        names
    }

    /// Poses of the object frame in the world; theta as recorded, possibly wrapped. On a rail, where only `object_x` is
    /// recorded, y and theta are 0. `None` if there is no sample.
    pub fn object(&self) -> Option<Stream<3>> {
        self.stream(OBJECT)
    }

    /// Poses of the gripper; `None` if there is no sample.
    pub fn gripper(&self) -> Option<Gripper> {
        if self.gripper_tilts() {
            self.stream(GRIPPER_TILTING).map(Gripper::Tilting)
        } else {
            self.stream(GRIPPER_LEVEL).map(Gripper::Level)
        }
    }

    /// Sensor readings; `None` if there is no sample.
    pub fn wrench(&self) -> Option<WrenchStream> {
        let Stream { t, value, row } = self.stream(WRENCH)?;
        let present = WRENCH.map(|name| self.columns.contains_key(name));
        Some(WrenchStream { t, value, present, row })
    }

    /// Whether the table gives the attitude of the gripper as a quaternion.
    pub(crate) fn gripper_tilts(&self) -> bool {
        self.columns.keys().any(|name| GRIPPER_TILTING[2..].contains(&name.as_str()))
    }

    /// Samples of the stream with columns `names`: the rows whose first existing column is not empty. Absent columns are 0.
    fn stream<const N: usize>(&self, names: [&str; N]) -> Option<Stream<N>> {
        let columns = names.map(|name| self.columns.get(name));
        let first = columns.iter().flatten().next()?;
        let row: Vec<usize> = (0..self.t.len()).filter(|&i| !first[i].is_nan()).collect();
        if row.is_empty() {
            return None;
        }
        let value_at = |&i: &usize| columns.map(|column| column.map_or(0.0, |values| values[i]));
        Some(Stream {
            t: row.iter().map(|&i| self.t[i]).collect(),
            value: row.iter().map(value_at).collect(),
            row,
        })
    }
}

/// Names of all columns of all streams.
pub(crate) fn known_columns() -> impl Iterator<Item = &'static str> {
    OBJECT.into_iter().chain(GRIPPER_LEVEL).chain(GRIPPER_TILTING.into_iter().skip(2)).chain(WRENCH)
}

/// Refuses a title that is not a numeric column of a planar recording.
pub(crate) fn check_title(title: &str) -> Result<(), Fault> {
    match known_columns().any(|known| known == title) {
        true => Ok(()),
        false => Err(Fault::unknown_column(title, known_columns().collect::<Vec<_>>().join(", "))),
    }
}

/// Episodes are equal if all their cells are equal; empty cells equal each other.
impl PartialEq for Episode {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
            && same(&self.t, &other.t)
            && self.notes == other.notes
            && self.columns.len() == other.columns.len()
            && self
                .columns
                .iter()
                .all(|(name, values)| other.columns.get(name).is_some_and(|v| same(values, v)))
    }
}

fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len()
        && a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan()))
}
