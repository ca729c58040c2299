//! Values in `recording.toml`, each by itself.

use std::collections::BTreeSet;

use super::polygon;
use super::split::is_printable;
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::metadata::{Dof, FORMAT, FixtureMeta, Frame, Metadata, NoiseMeta, ObjectMeta, Scene, WrenchMeta};

pub(super) fn check(metadata: &Metadata) -> Result<(), Error> {
    if metadata.format != FORMAT {
        let remedy = "this reader knows \"trundle-recording/1\"";
        return refuse("format", format!("{:?}", metadata.format), "is another format", remedy);
    }
    if !metadata.name.chars().all(is_printable) {
        let remedy = "write a name of one line, of letters, digits, spaces and punctuation";
        return refuse(
            "name",
            format!("{:?}", metadata.name),
            "holds characters that cannot be shown",
            remedy,
        );
    }
    check_shape(&metadata.object, metadata.on_rail())?;
    check_object(&metadata.object)?;
    check_wrench(&metadata.wrench)?;
    check_noise(metadata.noise.as_ref(), &metadata.object.dof)?;
    check_scene(&metadata.scene)
}

fn refuse(key: &str, value: String, problem: &'static str, remedy: &'static str) -> Result<(), Error> {
    Err(Fault::Value { value, problem, remedy }.at(Place::field(key)))
}

/// `None` stands for a key that was left out.
fn positive(key: &str, value: impl Into<Option<f64>>, remedy: &'static str) -> Result<(), Error> {
    match value.into() {
        Some(value) if !(value > 0.0 && value.is_finite()) => {
            refuse(key, value.to_string(), "is not a positive number", remedy)
        }
        _ => Ok(()),
    }
}

fn finite(key: &str, values: &[f64]) -> Result<(), Error> {
    match values.iter().all(|value| value.is_finite()) {
        true => Ok(()),
        false => refuse(key, format!("{values:?}"), "is not finite", "give numbers in SI units"),
    }
}

fn simple(key: &str, corners: &[[f64; 2]]) -> Result<(), Error> {
    match polygon::fault(corners) {
        None => Ok(()),
        Some(problem) => Err(Fault::Polygon { problem }.at(Place::field(key))),
    }
}

/// A footprint beside fixtures is what the format's own example has: then the fixtures count.
fn check_shape(object: &ObjectMeta, rail: bool) -> Result<(), Error> {
    let ObjectMeta { footprint, fixtures, .. } = object;
    if footprint.is_empty() && fixtures.is_empty() && !rail {
        let message =
            "missing field `footprint`: give the corners of the object's outline, or [[object.fixture]]";
        return Err(Fault::Key { message: message.to_owned() }.at(Place::field("object")));
    }
    if !footprint.is_empty() {
        simple("object.footprint", footprint)?;
    }
    let mut fixtures = fixtures.iter().enumerate();
    fixtures.try_for_each(|(i, fixture)| check_fixture(&format!("object.fixture[{}]", i + 1), fixture))
}

fn check_fixture(key: &str, fixture: &FixtureMeta) -> Result<(), Error> {
    positive(&format!("{key}.density"), fixture.density, "give the density relative to the other fixtures")?;
    match (&fixture.polygon, fixture.disc) {
        (Some(corners), None) => simple(&format!("{key}.polygon"), corners),
        (None, Some(disc)) => {
            let key = format!("{key}.disc");
            finite(&key, &disc)?;
            positive(&key, disc[2], "give disc = [x, y, radius] in m")
        }
        (None, None) => refuse(key, "a fixture".to_owned(), "has no shape", "give a polygon or a disc"),
        (Some(_), Some(_)) => {
            refuse(key, "a fixture".to_owned(), "is polygon and disc", "make two fixtures of it")
        }
    }
}

fn check_object(object: &ObjectMeta) -> Result<(), Error> {
    positive("object.mass", object.mass, "give kg, or leave it out where nobody weighed the object")?;
    finite("object.support", object.support.as_flattened())?;
    let distinct: BTreeSet<Dof> = object.dof.iter().copied().collect();
    if object.dof.is_empty() || distinct.len() < object.dof.len() {
        let remedy = "name each of \"x\", \"y\" and \"theta\" along which it can move once";
        return refuse("object.dof", format!("{:?}", object.dof), "is no set of directions", remedy);
    }
    Ok(())
}

fn check_wrench(wrench: &WrenchMeta) -> Result<(), Error> {
    let other = match wrench.frame {
        Frame::Sensor => None,
        Frame::Object => Some("object"),
        Frame::World => Some("world"),
    };
    if let (true, Some(frame)) = (wrench.raw, other) {
        return Err(Fault::RawFrame { frame }.at(Place::field("wrench.raw")));
    }
    positive("wrench.gripper_mass", wrench.gripper_mass, "give kg, or leave it out")?;
    finite("wrench.gripper_com", wrench.gripper_com.as_ref().map_or(&[], |com| com.as_slice()))?;
    if let (None, Some(com)) = (wrench.gripper_mass, wrench.gripper_com) {
        let remedy = "give wrench.gripper_mass in kg as well";
        return refuse("wrench.gripper_com", format!("{com:?}"), "is the centre of an unknown mass", remedy);
    }
    Ok(())
}

/// A direction in which the object cannot move needs no noise.
fn check_noise(noise: Option<&NoiseMeta>, dof: &[Dof]) -> Result<(), Error> {
    let Some(noise) = noise else { return Ok(()) };
    let remedy = "give one standard deviation, or leave [noise] out to have it estimated";
    for (direction, sd) in Dof::all().iter().zip(noise.pose) {
        if dof.contains(direction) || sd != 0.0 {
            positive("noise.pose", sd, remedy)?;
        }
    }
    positive("noise.force", noise.force, remedy)?;
    if dof.contains(&Dof::Theta) || noise.torque != Some(0.0) {
        positive("noise.torque", noise.torque, remedy)?;
    }
    if !(noise.time >= 0.0 && noise.time.is_finite()) {
        return refuse("noise.time", noise.time.to_string(), "is negative or not finite", remedy);
    }
    Ok(())
}

fn check_scene(scene: &Scene) -> Result<(), Error> {
    let mut obstacles = scene.obstacles.iter().enumerate();
    obstacles.try_for_each(|(i, obstacle)| {
        simple(&format!("scene.obstacle[{}].polygon", i + 1), &obstacle.polygon)
    })
}
