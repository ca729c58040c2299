//! Validation of the table of one episode: columns, times, samples.

use crate::episode::{Episode, GRIPPER_LEVEL, GRIPPER_TILTING, NOTE_PREFIX, OBJECT, WRENCH, known_columns};
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::metadata::Metadata;

/// Largest deviation of the norm of a quaternion from 1.
const QUATERNION_TOLERANCE: f64 = 1e-3;

pub(super) fn check(episode: &Episode, metadata: &Metadata) -> Result<(), Error> {
    let table = Checked { episode, metadata };
    table.columns()?;
    table.times()?;
    table.finite()?;
    for stream in table.streams()? {
        table.samples(&stream)?;
    }
    table.rows()?;
    table.attitudes()
}

/// A stream, and the columns that each of its samples fills.
struct Group {
    name: &'static str,
    columns: Vec<&'static str>,
}

struct Checked<'a> {
    episode: &'a Episode,
    metadata: &'a Metadata,
}

impl Checked<'_> {
    fn place(&self) -> Place {
        Place::episode(&self.episode.name)
    }

    fn has(&self, column: &str) -> bool {
        self.episode.columns.contains_key(column)
    }

    fn columns(&self) -> Result<(), Error> {
        let Episode { t, columns, notes, .. } = self.episode;
        let unknown = columns.keys().find(|name| !known_columns().any(|known| known == *name));
        let unknown = unknown.or_else(|| notes.keys().find(|name| !name.starts_with(NOTE_PREFIX)));
        if let Some(name) = unknown {
            return Err(Fault::unknown_column(name).at(self.place().column(name)));
        }
        let numbers = columns.iter().map(|(name, cells)| (name, cells.len()));
        let texts = notes.iter().map(|(name, cells)| (name, cells.len()));
        match (t.len(), numbers.chain(texts).find(|(_, found)| *found != t.len())) {
            (0, None) => Err(Fault::NoRows.at(self.place())),
            (0, Some(_)) => {
                let reason = "every row needs a time in seconds".to_owned();
                Err(Fault::MissingColumn { reason }.at(self.place().column("t")))
            }
            (expected, Some((name, found))) => {
                Err(Fault::Length { found, expected }.at(self.place().column(name)))
            }
            (_, None) => Ok(()),
        }
    }

    fn times(&self) -> Result<(), Error> {
        let t = &self.episode.t;
        for (row, &value) in t.iter().enumerate() {
            let previous = if row == 0 { f64::NEG_INFINITY } else { t[row - 1] };
            let fault = if value.is_nan() {
                Fault::NoTime
            } else if value.is_infinite() {
                Fault::Infinite { value }
            } else if value <= previous {
                Fault::NotIncreasing { value, previous }
            } else {
                continue;
            };
            return Err(fault.at(self.place().row(row + 1).column("t")));
        }
        Ok(())
    }

    fn finite(&self) -> Result<(), Error> {
        for (name, cells) in &self.episode.columns {
            if let Some(row) = cells.iter().position(|cell| cell.is_infinite()) {
                let fault = Fault::Infinite { value: cells[row] };
                return Err(fault.at(self.place().row(row + 1).column(name)));
            }
        }
        Ok(())
    }

    /// The streams of the table with their columns.
    fn streams(&self) -> Result<Vec<Group>, Error> {
        let rail_object = self.metadata.on_rail() && !self.has(OBJECT[1]) && !self.has(OBJECT[2]);
        let object = if rail_object { &OBJECT[..1] } else { &OBJECT[..] };
        let tilts = self.episode.gripper_tilts();
        let gripper = if tilts { &GRIPPER_TILTING[..] } else { &GRIPPER_LEVEL[..] };
        if tilts && self.has(GRIPPER_LEVEL[2]) {
            let value = format!("gripper_theta in addition to {}", GRIPPER_TILTING[3..].join(", "));
            let remedy = "keep the angle if the gripper is level, or the quaternion if it tilts";
            let fault = Fault::Value { value, problem: "states the attitude twice", remedy };
            return Err(fault.at(self.place().column(GRIPPER_LEVEL[2])));
        }
        let wrench: Vec<&str> = WRENCH.into_iter().filter(|name| self.has(name)).collect();
        let streams = [("object", object.to_vec()), ("gripper", gripper.to_vec()), ("wrench", wrench)];
        let mut groups = Vec::new();
        for (name, columns) in streams {
            let Some(present) = columns.iter().find(|column| self.has(column)) else { continue };
            if let Some(missing) = columns.iter().find(|column| !self.has(column)) {
                let reason = format!(
                    "the table has {present}, and a sample of the {name} has the columns {}",
                    columns.join(", ")
                );
                return Err(Fault::MissingColumn { reason }.at(self.place().column(missing)));
            }
            groups.push(Group { name, columns });
        }
        Ok(groups)
    }

    /// Checks that each sample fills all columns of its stream.
    fn samples(&self, stream: &Group) -> Result<(), Error> {
        let cells: Vec<&Vec<f64>> =
            stream.columns.iter().filter_map(|name| self.episode.columns.get(*name)).collect();
        for row in 0..self.episode.t.len() {
            let empty = cells.iter().position(|column| column[row].is_nan());
            let full = cells.iter().position(|column| !column[row].is_nan());
            let (Some(empty), Some(full)) = (empty, full) else { continue };
            let fault = Fault::HalfSample {
                stream: stream.name,
                other: stream.columns[full].to_owned(),
                value: cells[full][row],
                columns: stream.columns.join(", "),
            };
            return Err(fault.at(self.place().row(row + 1).column(stream.columns[empty])));
        }
        Ok(())
    }

    /// Checks that each row has a sample.
    fn rows(&self) -> Result<(), Error> {
        let empty = |row: &usize| self.episode.columns.values().all(|column| column[*row].is_nan());
        match (0..self.episode.t.len()).find(empty) {
            Some(row) => Err(Fault::EmptyRow { t: self.episode.t[row] }.at(self.place().row(row + 1))),
            None => Ok(()),
        }
    }

    fn attitudes(&self) -> Result<(), Error> {
        let Some(crate::Gripper::Tilting(stream)) = self.episode.gripper() else { return Ok(()) };
        for (pose, row) in stream.value.iter().zip(&stream.row) {
            let [_, _, _, value @ ..] = *pose;
            let length = value.iter().map(|q| q * q).sum::<f64>().sqrt();
            if (length - 1.0).abs() > QUATERNION_TOLERANCE {
                let fault = Fault::NotUnit { value, length };
                return Err(fault.at(self.place().row(row + 1).column("gripper_qw")));
            }
        }
        Ok(())
    }
}
