//! Validation of the single values in `recording.toml`.

use std::collections::BTreeSet;

use super::name::is_printable;
use super::polygon;
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::metadata::{Dof, FORMAT, FixtureMeta, Frame, Metadata, NoiseMeta, ObjectMeta, Scene, WrenchMeta};

pub(super) fn check(metadata: &Metadata) -> Result<(), Error> {
    if metadata.format != FORMAT {
        let remedy = "set format = \"trundle-recording/1\"";
        return refuse("format", format!("{:?}", metadata.format), "is not a supported format", remedy);
    }
    if !metadata.name.chars().all(is_printable) {
        let remedy = "use one line of letters, digits, spaces and punctuation";
        return refuse(
            "name",
            format!("{:?}", metadata.name),
            "contains control or invisible characters",
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

/// Refuses a value that is not positive and finite. `None` is a key that is not set.
fn positive(key: &str, value: impl Into<Option<f64>>, remedy: &'static str) -> Result<(), Error> {
    match value.into() {
        Some(value) if !(value > 0.0 && value.is_finite()) => {
            refuse(key, value.to_string(), "is not a positive, finite number", remedy)
        }
        _ => Ok(()),
    }
}

fn finite(key: &str, values: &[f64]) -> Result<(), Error> {
    match values.iter().all(|value| value.is_finite()) {
        true => Ok(()),
        false => refuse(key, format!("{values:?}"), "is not finite", "give finite numbers in SI units"),
    }
}

fn simple(key: &str, corners: &[[f64; 2]]) -> Result<(), Error> {
    match polygon::fault(corners) {
        None => Ok(()),
        Some(problem) => Err(Fault::Polygon { problem }.at(Place::field(key))),
    }
}

/// A recording may have both a footprint and fixtures; the fixtures then define the shape.
fn check_shape(object: &ObjectMeta, rail: bool) -> Result<(), Error> {
    let ObjectMeta { footprint, fixtures, .. } = object;
    if footprint.is_empty() && fixtures.is_empty() && !rail {
        let message = "missing field `footprint`: list the corners of the object's outline in m, or define [[object.fixture]]";
        return Err(Fault::Key { message: message.to_owned() }.at(Place::field("object")));
    }
    if !footprint.is_empty() {
        simple("object.footprint", footprint)?;
    }
    let mut fixtures = fixtures.iter().enumerate();
    fixtures.try_for_each(|(i, fixture)| check_fixture(&format!("object.fixture[{}]", i + 1), fixture))
}

fn check_fixture(key: &str, fixture: &FixtureMeta) -> Result<(), Error> {
    positive(&format!("{key}.density"), fixture.density, "give its density relative to the other fixtures")?;
    match (&fixture.polygon, fixture.disc) {
        (Some(corners), None) => simple(&format!("{key}.polygon"), corners),
        (None, Some(disc)) => {
            let key = format!("{key}.disc");
            finite(&key, &disc)?;
            positive(&key, disc[2], "set disc = [x, y, radius] in m with a positive radius")
        }
        (None, None) => refuse(key, "the fixture".to_owned(), "has no shape", "set polygon or disc"),
        (Some(_), Some(_)) => {
            refuse(key, "the fixture".to_owned(), "has both polygon and disc", "split it into two fixtures")
        }
    }
}

fn check_object(object: &ObjectMeta) -> Result<(), Error> {
    positive("object.mass", object.mass, "give the mass in kg, or remove the key if the mass is unknown")?;
    finite("object.support", object.support.as_flattened())?;
    let distinct: BTreeSet<Dof> = object.dof.iter().copied().collect();
    if object.dof.is_empty() || distinct.len() < object.dof.len() {
        let remedy = "list at least one of \"x\", \"y\" and \"theta\", each at most once";
        return refuse(
            "object.dof",
            format!("{:?}", object.dof),
            "is not a set of degrees of freedom",
            remedy,
        );
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
    positive(
        "wrench.gripper_mass",
        wrench.gripper_mass,
        "give the mass in kg, or remove the key if the mass is unknown",
    )?;
    finite("wrench.gripper_com", wrench.gripper_com.as_ref().map_or(&[], |com| com.as_slice()))?;
    if let (None, Some(com)) = (wrench.gripper_mass, wrench.gripper_com) {
        let remedy = "also set wrench.gripper_mass in kg";
        return refuse(
            "wrench.gripper_com",
            format!("{com:?}"),
            "is a centre of mass without a mass",
            remedy,
        );
    }
    Ok(())
}

/// The noise of a fixed degree of freedom may be zero.
fn check_noise(noise: Option<&NoiseMeta>, dof: &[Dof]) -> Result<(), Error> {
    let Some(noise) = noise else { return Ok(()) };
    let remedy =
        "give one standard deviation in SI units, or remove [noise] to estimate the noise from the data";
    for (i, (direction, sd)) in Dof::all().iter().zip(noise.pose).enumerate() {
        if dof.contains(direction) || sd != 0.0 {
            positive(&format!("noise.pose[{}]", i + 1), sd, remedy)?;
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
