//! Streams and axes that the metadata require.

use crate::episode::Episode;
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::metadata::{Contact, Frame, Metadata, Reference};

pub(super) fn check(episode: &Episode, metadata: &Metadata) -> Result<(), Error> {
    let here = || Place::episode(&episode.name);
    if let Some((axis, reason)) = axis(episode, metadata) {
        return Err(Fault::MissingColumn { reason: reason.to_owned() }.at(here().column(axis)));
    }
    let needed = [
        ("wrench", episode.wrench().is_some(), Some("the model is fitted to the wrench")),
        ("object", episode.object().is_some(), Some("the model predicts the object's pose")),
        ("gripper", episode.gripper().is_some(), gripper(episode, metadata)),
    ];
    for (stream, present, reason) in needed {
        if let (false, Some(reason)) = (present, reason) {
            return Err(Fault::MissingStream { stream, reason }.at(here()));
        }
    }
    Ok(())
}

/// The first missing axis of the wrench, and why it is required.
fn axis(episode: &Episode, metadata: &Metadata) -> Option<(&'static str, &'static str)> {
    let planar = "a planar recording requires force_x and force_y";
    let needed = match (metadata.on_rail(), metadata.wrench.contact) {
        (true, _) => &[("force_x", "a recording on a rail requires force_x")][..],
        (false, Contact::Point) => &[("force_x", planar), ("force_y", planar)],
        (false, Contact::Grasp) => &[
            ("force_x", planar),
            ("force_y", planar),
            ("torque_z", "only a recording with contact = \"point\" may omit it"),
        ],
    };
    needed.iter().copied().find(|(axis, _)| !episode.columns.contains_key(*axis))
}

/// Why the gripper's pose is required; `None` if it is not. On a rail nothing rotates and no torque is used.
fn gripper(episode: &Episode, metadata: &Metadata) -> Option<&'static str> {
    if metadata.on_rail() {
        return None;
    }
    if metadata.wrench.frame == Frame::Sensor {
        return Some("frame = \"sensor\" gives the wrench in the axes of the gripper");
    }
    let about = episode.wrench().map(|wrench| metadata.wrench.reference_for(wrench.present));
    if about != Some(Reference::Sensor) {
        return None;
    }
    match metadata.wrench.reference() {
        Reference::Sensor => Some("reference = \"sensor\" gives the torque about the origin of the gripper"),
        Reference::Object => Some("without torque_z the force acts at the origin of the gripper"),
    }
}
