//! Checks of the gripper's poses: unit of the angle, and frozen poses.

use crate::episode::Gripper;
use crate::metadata::Contact;
use crate::prepare::{latest, quantile, relative_pose, wrapped};

use super::data::EpisodeData;
use super::finding::{Finding, Severity};
use super::group::grouped;
use super::input::CheckInput;

/// Minimum concentration (length of the mean direction) of the gripper's angle on the object, read as degrees.
const MIN_CONCENTRATION_IN_DEGREES: f64 = 0.98;
/// Maximum concentration of the same angle, read as radians.
const MAX_CONCENTRATION_IN_RADIANS: f64 = 0.9;
/// Minimum rotation of the object for a check of the angle, rad.
const MIN_ROTATION_RAD: f64 = 0.1;
/// Minimum travel of a gripper relative to that of its grasp point on the object.
const MIN_TRAVEL_RATIO: f64 = 0.1;
/// Minimum travel of the grasp point in standard deviations of the poses.
const MIN_TRAVEL_SD: f64 = 20.0;
/// Minimum travel of the grasp point in sizes of the object.
const MIN_TRAVEL_SIZES: f64 = 0.05;

/// Planar poses of object and gripper at the same times, from contact on.
fn pairs(episode: &EpisodeData) -> Vec<([f64; 3], [f64; 3])> {
    let stream = match episode.raw.gripper() {
        Some(Gripper::Level(stream)) => stream,
        Some(Gripper::Tilting(s)) => {
            let value = s.value.iter().map(|v| [v[0], v[1], 2.0 * v[6].atan2(v[3])]).collect();
            crate::episode::Stream { t: s.t, value, row: s.row }
        }
        None => return vec![],
    };
    let times: Vec<f64> = episode.prepared.pose.iter().map(|p| p.t).collect();
    let in_contact = stream.t.iter().zip(&stream.value).filter(|(t, _)| **t >= episode.prepared.contact);
    in_contact
        .filter_map(|(t, pose)| Some((episode.prepared.pose[latest(&times, *t)?].pose, *pose)))
        .collect()
}

/// Range of `values` between the 5 % and 95 % quantiles.
fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
    quantile(values.clone(), 0.95).unwrap_or(0.0) - quantile(values, 0.05).unwrap_or(0.0)
}

/// Checks for gripper angles in degrees while those of the object are in radians.
pub(crate) fn angles(input: &CheckInput) -> Vec<Finding> {
    if input.data.meta.on_rail() {
        return vec![];
    }
    let (mut radians, mut degrees, mut weight) = (0.0, 0.0, 0.0);
    for episode in &input.data.episodes {
        let Some(Gripper::Level(_)) = episode.raw.gripper() else { continue };
        let pairs = pairs(episode);
        if range(pairs.iter().map(|(o, _)| o[2])) < MIN_ROTATION_RAD {
            continue;
        }
        let n = pairs.len() as f64;
        radians += n * concentration(&pairs, 1.0);
        degrees += n * concentration(&pairs, 1f64.to_radians());
        weight += n;
    }
    if weight == 0.0
        || degrees < MIN_CONCENTRATION_IN_DEGREES * weight
        || radians > MAX_CONCENTRATION_IN_RADIANS * weight
    {
        return vec![];
    }
    vec![Finding::new(
        "units",
        Severity::Error,
        "gripper_theta appears to be in degrees: only then does the gripper keep its angle on the object"
            .into(),
        "multiply gripper_theta by π/180: the format uses radians",
    )]
}

/// Concentration of the gripper's angle on the object, the angle multiplied by `scale`.
fn concentration(pairs: &[([f64; 3], [f64; 3])], scale: f64) -> f64 {
    let angles = pairs.iter().map(|(object, gripper)| wrapped(scale * gripper[2] - object[2]));
    let (sin, cos) = angles.fold((0.0, 0.0), |(s, c), a| (s + a.sin(), c + a.cos()));
    sin.hypot(cos) / pairs.len().max(1) as f64
}

/// Travel of the grasp point on the object while the gripper's pose is frozen, m; `None` if the pose is not frozen.
pub(crate) fn frozen_travel(input: &CheckInput, episode: &EpisodeData) -> Option<f64> {
    if input.data.meta.on_rail() || input.data.meta.wrench.contact != Contact::Grasp {
        return None;
    }
    let pairs = pairs(episode);
    let (first, last) = (pairs.first()?, pairs.len());
    let grasp = relative_pose(&first.0, &first.1);
    let grasp_point = |object: &[f64; 3]| {
        let (sin, cos) = object[2].sin_cos();
        [object[0] + cos * grasp[0] - sin * grasp[1], object[1] + sin * grasp[0] + cos * grasp[1]]
    };
    let grasp_points: Vec<[f64; 2]> = pairs.iter().map(|(object, _)| grasp_point(object)).collect();
    let travel = |from: usize, to: usize, of: &dyn Fn(usize, usize) -> f64| {
        range((from..to).map(|i| of(i, 0))).hypot(range((from..to).map(|i| of(i, 1))))
    };
    let sd = input.data.dataset.noise.pose;
    let min_travel = (MIN_TRAVEL_SD * sd[0].max(sd[1])).max(MIN_TRAVEL_SIZES * input.data.size);
    // The whole push, its halves and its quarters, because a stream may freeze during the push.
    let parts = [1usize, 2, 4].into_iter().flat_map(|n| (0..n).map(move |k| (k, n)));
    parts
        .filter_map(|(k, n)| {
            let (from, to) = (k * last / n, (k + 1) * last / n);
            let expected = travel(from, to, &|i, axis| grasp_points[i][axis]);
            let actual = travel(from, to, &|i, axis| pairs[i].1[axis]);
            (expected > min_travel && actual < MIN_TRAVEL_RATIO * expected).then_some(expected)
        })
        .reduce(f64::max)
}

/// Checks for a gripper pose that is not updated.
pub(crate) fn frozen(input: &CheckInput) -> Vec<Finding> {
    let found = input.data.episodes.iter().filter_map(|episode| {
        let travel = frozen_travel(input, episode)?;
        let sentence = format!(
            "the gripper's pose is frozen while the grasp point on the object moves by {:.0} mm",
            1e3 * travel
        );
        let remedy = "record the gripper's pose together with the object's, or remove the episode: the pose is needed to \
                      transform the wrench to the object";
        Some((travel, Finding::new("gripper", Severity::Error, sentence, remedy).in_episode(episode.name())))
    });
    grouped(found.collect())
}
