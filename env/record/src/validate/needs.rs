//! Streams and axes that the metadata ask for.

use crate::episode::Episode;
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::metadata::{Contact, Frame, Metadata, Reference};

pub(super) fn check(episode: &Episode, metadata: &Metadata) -> Result<(), Error> {
    let here = || Place::episode(&episode.name);
    if let Some((axis, needed_by)) = axis(episode, metadata) {
        return Err(Fault::MissingColumn { needed_by: needed_by.to_owned() }.at(here().column(axis)));
    }
    let needed = [
        ("wrench", episode.wrench().is_some(), Some("a model is fitted to the wrench")),
        ("object", episode.object().is_some(), Some("its pose is what a model must predict")),
        ("gripper", episode.gripper().is_some(), gripper(episode, metadata)),
    ];
    for (stream, present, needed_by) in needed {
        if let (false, Some(needed_by)) = (present, needed_by) {
            return Err(Fault::MissingStream { stream, needed_by }.at(here()));
        }
    }
    Ok(())
}

/// The first axis of the wrench that is missing, and why it is needed.
fn axis(episode: &Episode, metadata: &Metadata) -> Option<(&'static str, &'static str)> {
    let planar = "a planar recording has at least force_x, force_y and torque_z";
    let needed = match (metadata.on_rail(), metadata.wrench.contact) {
        (true, _) => &[("force_x", "a rail recording has at least force_x")][..],
        (false, Contact::Point) => &[("force_x", planar), ("force_y", planar)],
        (false, Contact::Grasp) => &[
            ("force_x", planar),
            ("force_y", planar),
            ("torque_z", "it may be absent with contact = \"point\" alone"),
        ],
    };
    needed.iter().copied().find(|(axis, _)| !episode.columns.contains_key(*axis))
}

/// Why the gripper's pose is needed, if it is. On a rail nothing turns and no torque is used.
fn gripper(episode: &Episode, metadata: &Metadata) -> Option<&'static str> {
    if metadata.on_rail() {
        return None;
    }
    if metadata.wrench.frame == Frame::Sensor {
        return Some("frame = \"sensor\" gives the reading in its axes");
    }
    let about = episode.wrench().map(|wrench| metadata.wrench.reference_for(wrench.present));
    if about != Some(Reference::Sensor) {
        return None;
    }
    match metadata.wrench.reference() {
        Reference::Sensor => Some("reference = \"sensor\" gives the torque about its origin"),
        Reference::Object => Some("without torque_z the force acts at its origin"),
    }
}
