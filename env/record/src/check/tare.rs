//! Whether the interval without contact is one.

use crate::prepare::{Noise, median};

use super::subject::{Look, Subject};
use super::{Finding, Severity};

/// Standard deviations by which the halves of a quiet interval do not differ.
const UNSTEADY: f64 = 6.0;
/// Apparent motion of an object at rest, in its sizes and in rad: trackers drift a little.
const DRIFT: (f64, f64) = (0.005, 0.01);
/// How much a tare may differ from those of the other episodes: robust standard deviations, and share of the
/// largest force.
const UNLIKE: (f64, f64) = (8.0, 0.1);
/// Fewer episodes than this show no usual tare.
const FEWEST: usize = 4;

/// Readings before contact: times and values of `axis`.
fn quiet(subject: &Subject, look: &Look, axis: usize) -> Vec<f64> {
    let (Some([start, end]), Some(wrench)) =
        (subject.meta.wrench.precontact(look.name()), look.episode.wrench())
    else {
        return vec![];
    };
    let inside = wrench.t.iter().zip(&wrench.value).filter(|(t, _)| start <= **t && **t <= end);
    inside.map(|(_, value)| value[axis]).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// A load that comes or goes within the interval, or an object that moves.
pub(crate) fn steady(subject: &Subject) -> Vec<Finding> {
    if !subject.meta.wrench.raw {
        return vec![];
    }
    let unsteady = |look: &Look| changes(subject, look).or_else(|| moves(subject, look));
    subject.episodes.iter().filter_map(unsteady).collect()
}

fn changes(subject: &Subject, look: &Look) -> Option<Finding> {
    let Noise { force, torque, .. } = subject.dataset.noise;
    let least = 0.02 * subject.peak_force();
    let step = |axis: usize| {
        let values = quiet(subject, look, axis);
        let (early, late) = values.split_at(values.len() / 2);
        (mean(late) - mean(early), (4.0 / values.len().max(1) as f64).sqrt())
    };
    let (x, y, z) = (step(0), step(1), step(5));
    let force_step = x.0.hypot(y.0);
    let loaded = force_step > (UNSTEADY * force * x.1).max(least);
    let turned = z.0.abs() > (UNSTEADY * torque * z.1).max(least * subject.size);
    (loaded || turned).then(|| {
        let sentence = format!(
            "the reading changes by {force_step:.2} N and {:.3} N m within the interval without contact: something touches",
            z.0.abs()
        );
        Finding::new("tare", Severity::Warning, sentence, REMEDY).of(look.name())
    })
}

const REMEDY: &str = "choose wrench.precontact where nothing touches, for this episode alone if need be";

fn moves(subject: &Subject, look: &Look) -> Option<Finding> {
    let [start, end] = subject.meta.wrench.precontact(look.name())?;
    let sd = subject.dataset.noise.pose;
    let poses: Vec<[f64; 3]> =
        look.prepared.pose.iter().filter(|p| start <= p.t && p.t <= end).map(|p| p.pose).collect();
    let (early, late) = poses.split_at(poses.len() / 2);
    let center = |half: &[[f64; 3]], k: usize| mean(&half.iter().map(|p| p[k]).collect::<Vec<f64>>());
    let moved = |k: usize| (center(late, k) - center(early, k)).abs();
    let least = [DRIFT.0 * subject.size, DRIFT.0 * subject.size, DRIFT.1];
    let far = |k: usize| moved(k) > (UNSTEADY * sd[k]).max(least[k]);
    if !subject.meta.at_rest || early.is_empty() || !(0..3).any(far) {
        return None;
    }
    let sentence = format!(
        "the object moves by {:.1} mm and {:.2}° within the interval without contact",
        1e3 * moved(0).hypot(moved(1)),
        moved(2).to_degrees()
    );
    Some(Finding::new("tare", Severity::Warning, sentence, REMEDY).of(look.name()))
}

/// Tares that differ from those of the other episodes: the sensor's offset stays from one episode to the next,
/// so one of them was taken in contact.
pub(crate) fn alike(subject: &Subject) -> Vec<Finding> {
    let means = |look: &Look| [0, 1].map(|axis| mean(&quiet(subject, look, axis)));
    let tares: Vec<[f64; 2]> = subject.episodes.iter().map(means).collect();
    let Some(usual) = usual(&tares).filter(|_| subject.meta.wrench.raw && tares.len() >= FEWEST) else {
        return vec![];
    };
    let away = |t: &[f64; 2]| (t[0] - usual[0]).hypot(t[1] - usual[1]);
    let spread = 1.5 * median(tares.iter().map(away)).unwrap_or(0.0);
    let limit = (UNLIKE.0 * spread).max(UNLIKE.1 * subject.peak_force());
    let unlike = subject.episodes.iter().zip(&tares).filter(|(_, tare)| away(tare) > limit);
    unlike.map(|(look, tare)| different(away(tare)).of(look.name())).collect()
}

fn usual(tares: &[[f64; 2]]) -> Option<[f64; 2]> {
    Some([median(tares.iter().map(|t| t[0]))?, median(tares.iter().map(|t| t[1]))?])
}

fn different(away: f64) -> Finding {
    let sentence = format!(
        "the reading before contact is {away:.2} N away from that of the other episodes: it may be taken in contact"
    );
    Finding::new("tare", Severity::Warning, sentence, REMEDY)
}
