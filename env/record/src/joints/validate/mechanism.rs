//! Validation of `[mechanism]`.

use super::refuse::refuse;
use crate::error::Error;
use crate::joints::metadata::{Axis, MechanismMeta};
use crate::joints::per_joint::PerJoint;
use crate::validate::is_printable;

const FREE_REMEDY: &str = "list \"armature\", \"damping\" and \"mass\" (of all recorded joints, all moving bodies), or single \
     ones as \"armature:JOINT\", \"damping:JOINT\", \"mass:BODY\"";

const WITH_MODEL: (&str, &str) = (
    "describes one axis without a model, but model is given",
    "remove it, or replace model by axis = \"hinge\" or \"slide\"",
);
const WITH_TYPES: (&str, &str) = (
    "describes one axis without a model, but types is given",
    "remove it, or replace types by axis = \"hinge\" or \"slide\"",
);

pub(super) fn check(mechanism: &MechanismMeta) -> Result<(), Error> {
    check_joints(&mechanism.joints)?;
    match (&mechanism.model, mechanism.axis, &mechanism.types) {
        (Some(_), Some(_), _) => {
            let remedy = "keep the model and remove axis, or keep the axis and remove model";
            return refuse("mechanism", "the mechanism".to_owned(), "has both model and axis", remedy);
        }
        (Some(_), None, Some(_)) | (None, Some(_), Some(_)) => {
            let remedy = "remove types: it is for joints of your own simulator, without model and axis";
            return refuse("mechanism.types", "the key".to_owned(), "is given with model or axis", remedy);
        }
        (None, None, None) => {
            let remedy = "set model to an MJCF or URDF document in the folder, axis = \"hinge\" or \"slide\" for one \
                 joint without a model, or types of the joints of your own simulator";
            return refuse("mechanism", "the mechanism".to_owned(), "has neither model nor axis", remedy);
        }
        (Some(_), None, None) => check_without_axis(mechanism, WITH_MODEL)?,
        (None, Some(axis), None) => check_axis(mechanism, axis)?,
        (None, None, Some(types)) => {
            check_types(types, &mechanism.joints)?;
            check_without_axis(mechanism, WITH_TYPES)?;
        }
    }
    let free = mechanism.free.iter().flatten().enumerate();
    free.map(|(i, entry)| (format!("mechanism.free[{}]", i + 1), entry))
        .try_for_each(|(key, entry)| check_free(&key, entry, mechanism))
}

fn check_joints(joints: &[String]) -> Result<(), Error> {
    if joints.is_empty() {
        return refuse(
            "mechanism.joints",
            "[]".to_owned(),
            "names no joint",
            "list the recorded joints: joints = [\"elbow\"]",
        );
    }
    for (i, joint) in joints.iter().enumerate() {
        let key = format!("mechanism.joints[{}]", i + 1);
        if joint.is_empty() || joint.trim() != joint || !joint.chars().all(is_printable) {
            let problem = "is not a name of a joint";
            let remedy = "use letters, digits and punctuation, and no space at the beginning or end";
            return refuse(&key, format!("{joint:?}"), problem, remedy);
        }
        if joints[..i].contains(joint) {
            return refuse(&key, format!("{joint:?}"), "is listed twice", "name each joint once");
        }
    }
    Ok(())
}

/// Refuses keys that describe an axis without a model, with a problem and its remedy.
fn check_without_axis(
    mechanism: &MechanismMeta,
    (problem, remedy): (&'static str, &'static str),
) -> Result<(), Error> {
    let keys = [
        ("imposed", mechanism.imposed),
        ("inertia", mechanism.inertia.is_some()),
        ("gravity", mechanism.gravity),
        ("gravity_torque", mechanism.gravity_torque.is_some()),
    ];
    match keys.iter().find(|(_, is_given)| *is_given) {
        None => Ok(()),
        Some((key, _)) => refuse(&format!("mechanism.{key}"), "the key".to_owned(), problem, remedy),
    }
}

fn check_types(types: &PerJoint<Axis>, joints: &[String]) -> Result<(), Error> {
    let known = joints.join(", ");
    let mut named = types.entries().into_iter().filter_map(|(joint, _)| joint);
    if let Some(unknown) = named.find(|name| joints.iter().all(|joint| joint != name)) {
        let value = format!("{unknown:?} (the recorded joints are {known})");
        let remedy = "use a name of joints";
        return refuse("mechanism.types", value, "does not name a recorded joint", remedy);
    }
    match joints.iter().find(|joint| types.of(joint).is_none()) {
        None => Ok(()),
        Some(joint) => {
            let remedy = "give \"hinge\" or \"slide\" for each joint, or one type for all";
            refuse("mechanism.types", format!("{joint:?}"), "is a joint without a type", remedy)
        }
    }
}

fn check_axis(mechanism: &MechanismMeta, axis: Axis) -> Result<(), Error> {
    let joints = &mechanism.joints;
    if joints.len() > 1 {
        return refuse(
            "mechanism.joints",
            format!("{joints:?}"),
            "has several joints, but an axis has one",
            "keep one joint, or give a model instead of axis",
        );
    }
    if let Some(inertia) = mechanism.inertia.filter(|inertia| !(*inertia > 0.0 && inertia.is_finite())) {
        let remedy = "give kg m^2 (hinge) or kg (slide), or remove the key if it is unknown";
        return refuse("mechanism.inertia", inertia.to_string(), "is not a positive, finite number", remedy);
    }
    if mechanism.gravity && axis == Axis::Slide {
        let remedy = "remove gravity; a constant force of a slide is an effort bias";
        return refuse("mechanism.gravity", "true".to_owned(), "is for a hinge, not for a slide", remedy);
    }
    match mechanism.gravity_torque {
        Some(torque) if !torque.is_finite() || torque == 0.0 => {
            let remedy = "give the torque in N m at q = pi/2, or remove the key if it is unknown";
            refuse("mechanism.gravity_torque", torque.to_string(), "is zero or not finite", remedy)
        }
        Some(torque) if !mechanism.gravity => {
            let problem = "is the gravity torque of a mechanism without gravity";
            refuse("mechanism.gravity_torque", torque.to_string(), problem, "also set gravity = true")
        }
        _ => Ok(()),
    }
}

fn check_free(key: &str, entry: &str, mechanism: &MechanismMeta) -> Result<(), Error> {
    let (kind, name) = entry.split_once(':').map_or((entry, None), |(kind, name)| (kind, Some(name)));
    let joints = &mechanism.joints;
    match (kind, name) {
        ("armature" | "damping" | "mass", Some("")) => {
            refuse(key, format!("{entry:?}"), "names nothing after the colon", FREE_REMEDY)
        }
        ("armature" | "damping", Some(joint)) if !joints.iter().any(|known| known == joint) => {
            let value = format!("{entry:?} (the recorded joints are {})", joints.join(", "));
            refuse(key, value, "does not name a recorded joint", FREE_REMEDY)
        }
        ("mass", Some(_)) if mechanism.model.is_none() => {
            let problem = "names a body, but an axis without a model has none";
            refuse(key, format!("{entry:?}"), problem, "list \"armature\" and \"damping\" only")
        }
        ("armature" | "damping" | "mass", _) => Ok(()),
        _ => refuse(key, format!("{entry:?}"), "cannot be free", FREE_REMEDY),
    }
}
