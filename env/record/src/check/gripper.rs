//! Whether the gripper's poses are in radians and follow the object.

use crate::episode::Gripper;
use crate::metadata::Contact;
use crate::prepare::{latest, quantile, relative_pose, wrapped};

use super::group::grouped;
use super::subject::{Look, Subject};
use super::{Finding, Severity};

/// Concentration (length of the mean direction) of the gripper's angle on the object: firm, and loose.
const FIRM: f64 = 0.98;
const LOOSE: f64 = 0.9;
/// Turn of the object that shows it, rad.
const TURNS: f64 = 0.1;
/// Share of the way of its place on the object that a gripper which follows it goes at least.
const FOLLOWS: f64 = 0.1;
/// Way that shows it: standard deviations of the poses, and sizes of the object.
const WAY: (f64, f64) = (20.0, 0.05);

/// Poses of a level gripper and of the object at the same times, from contact on: object, gripper.
fn pairs(look: &Look) -> Vec<([f64; 3], [f64; 3])> {
    let stream = match look.episode.gripper() {
        Some(Gripper::Level(stream)) => stream,
        Some(Gripper::Tilting(s)) => {
            let value = s.value.iter().map(|v| [v[0], v[1], 2.0 * v[6].atan2(v[3])]).collect();
            crate::episode::Stream { t: s.t, value, row: s.row }
        }
        None => return vec![],
    };
    let times: Vec<f64> = look.prepared.pose.iter().map(|p| p.t).collect();
    let held = stream.t.iter().zip(&stream.value).filter(|(t, _)| **t >= look.prepared.contact);
    held.filter_map(|(t, pose)| Some((look.prepared.pose[latest(&times, *t)?].pose, *pose))).collect()
}

fn width(values: impl Iterator<Item = f64> + Clone) -> f64 {
    quantile(values.clone(), 0.95).unwrap_or(0.0) - quantile(values, 0.05).unwrap_or(0.0)
}

/// Angles of the gripper in degrees while those of the object are in radians.
pub(crate) fn degrees(subject: &Subject) -> Vec<Finding> {
    if subject.meta.on_rail() {
        return vec![];
    }
    let (mut radians, mut degrees, mut weight) = (0.0, 0.0, 0.0);
    for look in &subject.episodes {
        let Some(Gripper::Level(_)) = look.episode.gripper() else { continue };
        let pairs = pairs(look);
        if width(pairs.iter().map(|(o, _)| o[2])) < TURNS {
            continue;
        }
        let n = pairs.len() as f64;
        radians += n * concentration(&pairs, 1.0);
        degrees += n * concentration(&pairs, 1f64.to_radians());
        weight += n;
    }
    if weight == 0.0 || degrees < FIRM * weight || radians > LOOSE * weight {
        return vec![];
    }
    vec![Finding::new(
        "units",
        Severity::Error,
        "gripper_theta seems to be in degrees: only so does the gripper keep its angle on the object".into(),
        "multiply gripper_theta by π/180: the format is in radians",
    )]
}

fn concentration(pairs: &[([f64; 3], [f64; 3])], scale: f64) -> f64 {
    let angles = pairs.iter().map(|(object, gripper)| wrapped(scale * gripper[2] - object[2]));
    let (sin, cos) = angles.fold((0.0, 0.0), |(s, c), a| (s + a.sin(), c + a.cos()));
    sin.hypot(cos) / pairs.len().max(1) as f64
}

/// Whether the gripper stands still while its place on the object goes elsewhere; the way it should have gone, m.
pub(crate) fn frozen_in(subject: &Subject, look: &Look) -> Option<f64> {
    if subject.meta.on_rail() || subject.meta.wrench.contact != Contact::Grasp {
        return None;
    }
    let pairs = pairs(look);
    let (first, last) = (pairs.first()?, pairs.len());
    let place = relative_pose(&first.0, &first.1);
    let expected = |object: &[f64; 3]| {
        let (sin, cos) = object[2].sin_cos();
        [object[0] + cos * place[0] - sin * place[1], object[1] + sin * place[0] + cos * place[1]]
    };
    let should: Vec<[f64; 2]> = pairs.iter().map(|(object, _)| expected(object)).collect();
    let way = |from: usize, to: usize, of: &dyn Fn(usize, usize) -> f64| {
        width((from..to).map(|i| of(i, 0))).hypot(width((from..to).map(|i| of(i, 1))))
    };
    let sd = subject.dataset.noise.pose;
    let least = (WAY.0 * sd[0].max(sd[1])).max(WAY.1 * subject.size);
    // The whole push, and its halves and quarters: a stream may freeze on the way.
    let parts = [1usize, 2, 4].into_iter().flat_map(|n| (0..n).map(move |k| (k, n)));
    parts
        .filter_map(|(k, n)| {
            let (from, to) = (k * last / n, (k + 1) * last / n);
            let wanted = way(from, to, &|i, axis| should[i][axis]);
            let gone = way(from, to, &|i, axis| pairs[i].1[axis]);
            (wanted > least && gone < FOLLOWS * wanted).then_some(wanted)
        })
        .reduce(f64::max)
}

/// A gripper's pose that is not updated.
pub(crate) fn frozen(subject: &Subject) -> Vec<Finding> {
    let found = subject.episodes.iter().filter_map(|look| {
        let way = frozen_in(subject, look)?;
        let sentence = format!(
            "the gripper's pose stands still while its place on the object moves by {:.0} mm",
            1e3 * way
        );
        let remedy = "record the gripper's pose with the object's, or leave the episode out: the wrench is brought \
                      to the object by it";
        Some((way, Finding::new("gripper", Severity::Error, sentence, remedy).of(look.name())))
    });
    grouped(found.collect())
}
