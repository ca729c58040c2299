//! Validation of the table of one episode: columns, times, samples.

use super::cells;
use crate::episode::{Episode, GRIPPER_LEVEL, GRIPPER_TILTING, OBJECT, WRENCH, check_title};
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::metadata::Metadata;

/// Largest deviation of the norm of a quaternion from 1.
const QUATERNION_TOLERANCE: f64 = 1e-3;

pub(super) fn check(episode: &Episode, metadata: &Metadata) -> Result<(), Error> {
    let table = Checked { episode, metadata };
    cells::check_columns(episode, &check_title)?;
    cells::check_numbers(episode)?;
    for stream in table.streams()? {
        table.samples(&stream)?;
    }
    cells::check_rows(episode)?;
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
