//! Whether the interval without contact is one.

use crate::episode::Gripper;
use crate::metadata::Frame;
use crate::prepare::{Noise, median, quantile};

use super::group::grouped;
use super::subject::{Look, Subject};
use super::{Finding, Severity};
use crate::prepare::WrenchSample;

/// Standard deviations by which the halves of a quiet interval do not differ.
const UNSTEADY: f64 = 6.0;
/// Apparent motion of an object at rest, in its sizes and in rad: trackers drift a little.
const DRIFT: (f64, f64) = (0.005, 0.01);
/// How much a tare may differ from those of the other episodes: robust standard deviations, and share of the
/// largest force.
const UNLIKE: (f64, f64) = (8.0, 0.1);
/// Fewer episodes than this show no usual tare.
const FEWEST: usize = 4;

/// Readings before contact without offset and weight, so that a gripper that tilts there changes nothing: values of
/// `axis` (force x, force y, torque).
fn tared(subject: &Subject, look: &Look, axis: usize) -> Vec<f64> {
    let Some([start, end]) = subject.meta.wrench.precontact(look.name()) else { return vec![] };
    let inside = look.prepared.wrench.iter().filter(|w| start <= w.t && w.t <= end);
    inside.map(|w| w.reading[axis]).collect()
}

/// Readings before contact as recorded: values of `axis`.
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
    grouped(subject.episodes.iter().filter_map(|look| Some((0.0, unsteady(look)?))).collect())
}

fn changes(subject: &Subject, look: &Look) -> Option<Finding> {
    let Noise { force, torque, .. } = subject.dataset.noise;
    let least = 0.02 * subject.peak_force();
    let step = |axis: usize| {
        let values = tared(subject, look, axis);
        let (early, late) = values.split_at(values.len() / 2);
        (mean(late) - mean(early), (4.0 / values.len().max(1) as f64).sqrt())
    };
    let (x, y, z) = (step(0), step(1), step(2));
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
    if subject.episodes.iter().any(|look| matches!(look.episode.gripper(), Some(Gripper::Tilting(_)))) {
        return vec![]; // its weight differs with its attitude
    }
    let means = |look: &Look| [0, 1].map(|axis| mean(&quiet(subject, look, axis)));
    let tares: Vec<[f64; 2]> = subject.episodes.iter().map(means).collect();
    let Some(usual) = usual(&tares).filter(|_| subject.meta.wrench.raw && tares.len() >= FEWEST) else {
        return vec![];
    };
    let away = |t: &[f64; 2]| (t[0] - usual[0]).hypot(t[1] - usual[1]);
    let spread = 1.5 * median(tares.iter().map(away)).unwrap_or(0.0);
    let limit = (UNLIKE.0 * spread).max(UNLIKE.1 * subject.peak_force());
    let unlike = subject.episodes.iter().zip(&tares).filter(|(_, tare)| away(tare) > limit);
    grouped(unlike.map(|(look, tare)| (away(tare), different(away(tare)).of(look.name()))).collect())
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

/// Standard deviations, and share of the peak force, by which a reading at rest differs from zero.
const OFFSET: (f64, f64) = (6.0, 0.02);
/// Spread over the episodes of what every one of them reads at rest, as a share of it.
const SAME: f64 = 0.3;
/// Fewest samples at rest.
const AT_REST: usize = 10;

/// A reading that should be tared but is not zero while the object still rests, the same in each episode.
pub(crate) fn missing(subject: &Subject) -> Vec<Finding> {
    let wrench = &subject.meta.wrench;
    if wrench.raw || !subject.meta.at_rest || subject.meta.on_rail() || subject.dataset.commanded {
        return vec![];
    }
    let Some(rests) = subject.episodes.iter().map(at_rest).collect::<Option<Vec<[f64; 2]>>>() else {
        return vec![];
    };
    let Some(usual) = usual(&rests).filter(|_| rests.len() >= 2) else { return vec![] };
    let size = usual[0].hypot(usual[1]);
    let spread = rests.iter().map(|r| (r[0] - usual[0]).hypot(r[1] - usual[1])).fold(0.0, f64::max);
    let noise = subject.seen_noise.force / (AT_REST as f64).sqrt();
    if size < (OFFSET.0 * noise).max(OFFSET.1 * subject.peak_force()) || spread > SAME * size + 3.0 * noise {
        return vec![];
    }
    let sentence = format!(
        "the reading is not tared: in every episode it is [{:.3}, {:.3}] N while the object rests, in sensor axes",
        usual[0], usual[1]
    );
    let remedy = if wrench.frame == Frame::Sensor {
        "set wrench.raw = true and wrench.precontact to an interval without contact, or subtract the offset"
    } else {
        "subtract the sensor's offset, in sensor axes, before the reading is turned to other axes"
    };
    vec![Finding::new("tare", Severity::Error, sentence, remedy)]
}

/// Mean force in sensor axes before the object moves; `None` where it moves too soon to tell, or the force varies.
fn at_rest(look: &Look) -> Option<[f64; 2]> {
    let start = look.moves_from()?;
    let before: Vec<&WrenchSample> = look.prepared.wrench.iter().take_while(|w| w.t < start).collect();
    let early = &before[..before.len() / 2];
    if early.len() < AT_REST {
        return None;
    }
    let turn = look.sensor_angle();
    let force = |w: &&WrenchSample| {
        let (sin, cos) = (w.frame[2] - turn).sin_cos();
        [cos * w.reading[0] - sin * w.reading[1], sin * w.reading[0] + cos * w.reading[1]]
    };
    let values: Vec<[f64; 2]> = early.iter().map(force).collect();
    let axis = |k: usize| values.iter().map(move |v| v[k]);
    let mean = [median(axis(0))?, median(axis(1))?];
    let spread = |k: usize| Some(quantile(axis(k), 0.9)? - quantile(axis(k), 0.1)?);
    let size = mean[0].hypot(mean[1]);
    // A push sets in: its force rises. An offset stays, but for the noise.
    let (head, tail) = values.split_at(values.len() / 2);
    let center =
        |half: &[[f64; 2]], k: usize| half.iter().map(|v| v[k]).sum::<f64>() / half.len().max(1) as f64;
    let rises = (center(tail, 0) - center(head, 0)).hypot(center(tail, 1) - center(head, 1));
    let noise = spread(0)?.hypot(spread(1)?) / (values.len() as f64).sqrt();
    (rises < 0.1 * size + 3.0 * noise).then_some(mean)
}
