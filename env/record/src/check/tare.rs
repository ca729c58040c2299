//! Checks of the tare and of the interval without contact.

use crate::episode::Gripper;
use crate::metadata::Frame;
use crate::prepare::{Noise, WrenchSample, median, quantile};

use super::data::EpisodeData;
use super::finding::{Finding, Severity};
use super::group::grouped;
use super::input::CheckInput;

/// Minimum difference between the halves of the interval without contact, in standard deviations.
const MIN_CHANGE_SD: f64 = 6.0;
/// Apparent translation of an object at rest by drift of the tracker, in sizes of the object.
const MAX_TRACKER_DRIFT_SIZES: f64 = 0.005;
/// Apparent rotation of an object at rest by drift of the tracker, rad.
const MAX_TRACKER_DRIFT_RAD: f64 = 0.01;
/// Maximum difference of a tare from those of the other episodes in robust standard deviations.
const MAX_TARE_DIFFERENCE_SD: f64 = 8.0;
/// Maximum difference of a tare from those of the other episodes as a share of the largest force.
const MAX_TARE_DIFFERENCE_SHARE: f64 = 0.1;
/// Minimum number of episodes for a comparison of tares.
const MIN_EPISODES: usize = 4;

/// Tared readings before contact along `axis` (force x, force y, torque). They do not change if the gripper tilts.
fn tared(input: &CheckInput, episode: &EpisodeData, axis: usize) -> Vec<f64> {
    let Some([start, end]) = input.data.meta.wrench.precontact(episode.name()) else { return vec![] };
    let inside = episode.prepared.wrench.iter().filter(|w| start <= w.t && w.t <= end);
    inside.map(|w| w.reading[axis]).collect()
}

/// Readings before contact along `axis` as recorded.
fn untared(input: &CheckInput, episode: &EpisodeData, axis: usize) -> Vec<f64> {
    let (Some([start, end]), Some(wrench)) =
        (input.data.meta.wrench.precontact(episode.name()), episode.raw.wrench())
    else {
        return vec![];
    };
    let inside = wrench.t.iter().zip(&wrench.value).filter(|(t, _)| start <= **t && **t <= end);
    inside.map(|(_, value)| value[axis]).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Checks for a change of the load or a motion of the object in the interval without contact.
pub(crate) fn load_before_contact(input: &CheckInput) -> Vec<Finding> {
    if !input.data.meta.wrench.raw {
        return vec![];
    }
    let finding = |episode: &EpisodeData| load_change(input, episode).or_else(|| motion(input, episode));
    grouped(input.data.episodes.iter().filter_map(|episode| Some((0.0, finding(episode)?))).collect())
}

fn load_change(input: &CheckInput, episode: &EpisodeData) -> Option<Finding> {
    let Noise { force, torque, .. } = input.data.dataset.noise;
    let min_force = 0.02 * input.data.peak_force();
    let step = |axis: usize| {
        let values = tared(input, episode, axis);
        let (early, late) = values.split_at(values.len() / 2);
        (mean(late) - mean(early), (4.0 / values.len().max(1) as f64).sqrt())
    };
    let (x, y, z) = (step(0), step(1), step(2));
    let force_step = x.0.hypot(y.0);
    let is_loaded = force_step > (MIN_CHANGE_SD * force * x.1).max(min_force);
    let is_turned = z.0.abs() > (MIN_CHANGE_SD * torque * z.1).max(min_force * input.data.size);
    (is_loaded || is_turned).then(|| {
        let sentence = format!(
            "the reading changes by {force_step:.2} N and {:.3} N m in the interval without contact: something touches the gripper",
            z.0.abs()
        );
        Finding::new("tare", Severity::Warning, sentence, REMEDY).in_episode(episode.name())
    })
}

const REMEDY: &str = "set wrench.precontact to an interval in which nothing touches the gripper, if necessary for each episode";

fn motion(input: &CheckInput, episode: &EpisodeData) -> Option<Finding> {
    let [start, end] = input.data.meta.wrench.precontact(episode.name())?;
    let sd = input.data.dataset.noise.pose;
    let poses: Vec<[f64; 3]> =
        episode.prepared.pose.iter().filter(|p| start <= p.t && p.t <= end).map(|p| p.pose).collect();
    let (early, late) = poses.split_at(poses.len() / 2);
    let center = |half: &[[f64; 3]], k: usize| mean(&half.iter().map(|p| p[k]).collect::<Vec<f64>>());
    let moved = |k: usize| (center(late, k) - center(early, k)).abs();
    let drift = [
        MAX_TRACKER_DRIFT_SIZES * input.data.size,
        MAX_TRACKER_DRIFT_SIZES * input.data.size,
        MAX_TRACKER_DRIFT_RAD,
    ];
    let has_moved = |k: usize| moved(k) > (MIN_CHANGE_SD * sd[k]).max(drift[k]);
    if !input.data.meta.at_rest || early.is_empty() || !(0..3).any(has_moved) {
        return None;
    }
    let sentence = format!(
        "the object moves by {:.1} mm and {:.2}° in the interval without contact",
        1e3 * moved(0).hypot(moved(1)),
        moved(2).to_degrees()
    );
    Some(Finding::new("tare", Severity::Warning, sentence, REMEDY).in_episode(episode.name()))
}

/// Checks for tares that differ from those of the other episodes. The offset of a sensor is constant, so such a tare was
/// taken during contact.
pub(crate) fn inconsistent(input: &CheckInput) -> Vec<Finding> {
    if input.data.episodes.iter().any(|episode| matches!(episode.raw.gripper(), Some(Gripper::Tilting(_)))) {
        return vec![]; // the weight depends on the attitude
    }
    let means = |episode: &EpisodeData| [0, 1].map(|axis| mean(&untared(input, episode, axis)));
    let tares: Vec<[f64; 2]> = input.data.episodes.iter().map(means).collect();
    let Some(typical) = medians(&tares).filter(|_| input.data.meta.wrench.raw && tares.len() >= MIN_EPISODES)
    else {
        return vec![];
    };
    let difference = |t: &[f64; 2]| (t[0] - typical[0]).hypot(t[1] - typical[1]);
    let spread = 1.5 * median(tares.iter().map(difference)).unwrap_or(0.0);
    let limit = (MAX_TARE_DIFFERENCE_SD * spread).max(MAX_TARE_DIFFERENCE_SHARE * input.data.peak_force());
    let deviating = input.data.episodes.iter().zip(&tares).filter(|(_, tare)| difference(tare) > limit);
    let finding = |(episode, tare): (&EpisodeData, &[f64; 2])| {
        (difference(tare), tare_difference(difference(tare)).in_episode(episode.name()))
    };
    grouped(deviating.map(finding).collect())
}

fn medians(tares: &[[f64; 2]]) -> Option<[f64; 2]> {
    Some([median(tares.iter().map(|t| t[0]))?, median(tares.iter().map(|t| t[1]))?])
}

fn tare_difference(difference: f64) -> Finding {
    let sentence = format!(
        "the tare differs from that of the other episodes by {difference:.2} N: it may have been taken during contact"
    );
    Finding::new("tare", Severity::Warning, sentence, REMEDY)
}

/// Minimum offset at rest in standard deviations.
const MIN_OFFSET_SD: f64 = 6.0;
/// Minimum offset at rest as a share of the peak force.
const MIN_OFFSET_SHARE: f64 = 0.02;
/// Maximum spread of the offset over the episodes, as a share of the offset.
const MAX_OFFSET_SPREAD: f64 = 0.3;
/// Minimum number of samples at rest.
const MIN_RESTING_SAMPLES: usize = 10;

/// Checks for a missing tare: an equal nonzero reading in all episodes while the object is at rest.
pub(crate) fn missing(input: &CheckInput) -> Vec<Finding> {
    let wrench = &input.data.meta.wrench;
    if wrench.raw || !input.data.meta.at_rest || input.data.meta.on_rail() || input.data.dataset.commanded {
        return vec![];
    }
    let Some(rests) = input.data.episodes.iter().map(at_rest).collect::<Option<Vec<[f64; 2]>>>() else {
        return vec![];
    };
    let Some(offset) = medians(&rests).filter(|_| rests.len() >= 2) else { return vec![] };
    let size = offset[0].hypot(offset[1]);
    let spread = rests.iter().map(|r| (r[0] - offset[0]).hypot(r[1] - offset[1])).fold(0.0, f64::max);
    let noise = input.data.estimated_noise.force / (MIN_RESTING_SAMPLES as f64).sqrt();
    if size < (MIN_OFFSET_SD * noise).max(MIN_OFFSET_SHARE * input.data.peak_force())
        || spread > MAX_OFFSET_SPREAD * size + 3.0 * noise
    {
        return vec![];
    }
    let sentence = format!(
        "the wrench is not tared: while the object is at rest, it is [{:.3}, {:.3}] N in sensor axes in every episode",
        offset[0], offset[1]
    );
    let remedy = if wrench.frame == Frame::Sensor {
        "set wrench.raw = true and wrench.precontact to an interval without contact, or subtract the offset"
    } else {
        "subtract the sensor's offset in sensor axes, before the transformation to other axes"
    };
    vec![Finding::new("tare", Severity::Error, sentence, remedy)]
}

/// Median force in sensor axes before the object moves, N; `None` if the object moves too soon or the force varies.
fn at_rest(episode: &EpisodeData) -> Option<[f64; 2]> {
    let start = episode.moves_from()?;
    let before: Vec<&WrenchSample> = episode.prepared.wrench.iter().take_while(|w| w.t < start).collect();
    let early = &before[..before.len() / 2];
    if early.len() < MIN_RESTING_SAMPLES {
        return None;
    }
    let angle = episode.sensor_angle();
    let force = |w: &&WrenchSample| {
        let (sin, cos) = (w.frame[2] - angle).sin_cos();
        [cos * w.reading[0] - sin * w.reading[1], sin * w.reading[0] + cos * w.reading[1]]
    };
    let values: Vec<[f64; 2]> = early.iter().map(force).collect();
    let axis = |k: usize| values.iter().map(move |v| v[k]);
    let mean = [median(axis(0))?, median(axis(1))?];
    let spread = |k: usize| Some(quantile(axis(k), 0.9)? - quantile(axis(k), 0.1)?);
    let size = mean[0].hypot(mean[1]);
    // The force of a push rises; an offset is constant except for the noise.
    let (head, tail) = values.split_at(values.len() / 2);
    let center =
        |half: &[[f64; 2]], k: usize| half.iter().map(|v| v[k]).sum::<f64>() / half.len().max(1) as f64;
    let rise = (center(tail, 0) - center(head, 0)).hypot(center(tail, 1) - center(head, 1));
    let noise = spread(0)?.hypot(spread(1)?) / (values.len() as f64).sqrt();
    (rise < 0.1 * size + 3.0 * noise).then_some(mean)
}
