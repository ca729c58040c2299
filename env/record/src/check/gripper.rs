//! Checks of the gripper's poses: unit of the angle, and frozen poses.

use std::ops::Range;

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
/// Minimum travel of a gripper relative to that of the point of the object that it touches.
const MIN_TRAVEL_RATIO: f64 = 0.1;
/// Minimum travel of this point in standard deviations of the poses.
const MIN_TRAVEL_SD: f64 = 20.0;
/// Minimum travel of this point in sizes of the object.
const MIN_TRAVEL_SIZES: f64 = 0.05;

/// Planar poses of object and gripper at one time.
struct Pair {
    t: f64,
    object: [f64; 3],
    gripper: [f64; 3],
}

/// Poses of object and gripper at the same times, from contact on.
fn pairs(episode: &EpisodeData) -> Vec<Pair> {
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
        .filter_map(|(&t, &gripper)| {
            Some(Pair { t, object: episode.prepared.pose[latest(&times, t)?].pose, gripper })
        })
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
        if range(pairs.iter().map(|pair| pair.object[2])) < MIN_ROTATION_RAD {
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
fn concentration(pairs: &[Pair], scale: f64) -> f64 {
    let angles = pairs.iter().map(|pair| wrapped(scale * pair.gripper[2] - pair.object[2]));
    let (sin, cos) = angles.fold((0.0, 0.0), |(s, c), a| (s + a.sin(), c + a.cos()));
    sin.hypot(cos) / pairs.len().max(1) as f64
}

/// Travel of the touched point of the object while the gripper's pose is frozen, m; `None` if the pose is not frozen.
pub(crate) fn frozen_travel(input: &CheckInput, episode: &EpisodeData) -> Option<f64> {
    if input.data.meta.on_rail() {
        return None;
    }
    let pairs = pairs(episode);
    // A grasp always follows the object; its stream may freeze during the push. A pusher follows it only while it pushes,
    // and may stop while the object still slides along it.
    let parts: Vec<Vec<Range<usize>>> = match input.data.meta.wrench.contact {
        Contact::Grasp => [1usize, 2, 4]
            .into_iter()
            .flat_map(|n| (0..n).map(move |k| (k, n)))
            .map(|(k, n)| std::iter::once(k * pairs.len() / n..(k + 1) * pairs.len() / n).collect())
            .collect(),
        Contact::Point => vec![loaded_spans(input, episode, &pairs)],
    };
    let sd = input.data.dataset.noise.pose;
    let min_travel = (MIN_TRAVEL_SD * sd[0].max(sd[1])).max(MIN_TRAVEL_SIZES * input.data.size);
    let frozen = |spans: &Vec<Range<usize>>| {
        let travels = spans.iter().filter_map(|span| travels(pairs.get(span.clone())?));
        let [expected, actual] =
            travels.fold([0.0; 2], |sum, travel| [sum[0] + travel[0], sum[1] + travel[1]]);
        (expected > min_travel && actual < MIN_TRAVEL_RATIO * expected).then_some(expected)
    };
    parts.iter().filter_map(frozen).reduce(f64::max)
}

/// Travels of the point of the object that the gripper touches at first, and of the gripper, m.
fn travels(pairs: &[Pair]) -> Option<[f64; 2]> {
    let first = pairs.first()?;
    let touched = relative_pose(&first.object, &first.gripper);
    let point = |pair: &Pair| {
        let (object, (sin, cos)) = (pair.object, pair.object[2].sin_cos());
        [object[0] + cos * touched[0] - sin * touched[1], object[1] + sin * touched[0] + cos * touched[1]]
    };
    let axis =
        |k: usize| [range(pairs.iter().map(|p| point(p)[k])), range(pairs.iter().map(|p| p.gripper[k]))];
    let (x, y) = (axis(0), axis(1));
    Some([x[0].hypot(y[0]), x[1].hypot(y[1])])
}

/// Runs of poses at which the readings before and after show a load.
fn loaded_spans(input: &CheckInput, episode: &EpisodeData, pairs: &[Pair]) -> Vec<Range<usize>> {
    let times: Vec<f64> = episode.prepared.wrench.iter().map(|w| w.t).collect();
    let shows_load = |i: usize| episode.prepared.wrench.get(i).is_some_and(|w| input.data.is_loaded(w));
    let is_pushed = |t: f64| latest(&times, t).is_some_and(|i| shows_load(i) && shows_load(i + 1));
    let mut spans: Vec<Range<usize>> = vec![];
    for i in (0..pairs.len()).filter(|&i| is_pushed(pairs[i].t)) {
        match spans.last_mut().filter(|span| span.end == i) {
            Some(span) => span.end = i + 1,
            None => spans.push(i..i + 1),
        }
    }
    spans
}

/// Checks for a gripper pose that is not updated.
pub(crate) fn frozen(input: &CheckInput) -> Vec<Finding> {
    let found = input.data.episodes.iter().filter_map(|episode| {
        let travel = frozen_travel(input, episode)?;
        let sentence = format!(
            "the gripper's pose is frozen while the point of the object that it touches moves by {:.0} mm",
            1e3 * travel
        );
        let remedy = "record the gripper's pose together with the object's, or remove the episode: the pose is needed to \
                      transform the wrench to the object";
        Some((travel, Finding::new("gripper", Severity::Error, sentence, remedy).in_episode(episode.name())))
    });
    grouped(found.collect())
}
