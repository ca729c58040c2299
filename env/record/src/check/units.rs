//! Whether everything is in SI units and radians.

use crate::episode::Gripper;
use crate::prepare::{latest, median, quantile, relative_pose};

use super::subject::{Look, Subject};
use super::{Finding, Severity};

/// Nothing that is pushed on a floor is larger than this, m.
const LARGEST: f64 = 20.0;
/// Nor faster, m/s.
const FASTEST: f64 = 20.0;
/// An object that turns further than this, rad, is rather given in degrees.
const TURNS: f64 = 13.0;
/// How much tighter the grasp must be in degrees than in radians.
const TIGHTER: f64 = 3.0;
/// Torques this many times force times size are rather in N mm.
const LONGEST_ARM: f64 = 20.0;
/// Stated over seen noise beyond which the unit may be wrong.
const NOISE_RATIO: f64 = 20.0;
/// Poses with less noise than this, m or rad, are simulated: the noise stated is none of theirs.
const NOISELESS: f64 = 1e-5;
/// Metres stated in millimetres are a thousand times as much.
const UNUSED: f64 = 300.0;
/// Poses that show their noise.
const ENOUGH: usize = 50;
/// Noise that a jerky motion seen at a low rate may feign, m or rad.
const LEAST_NOISE: f64 = 5e-4;

/// Millimetres instead of metres.
pub(crate) fn lengths(subject: &Subject) -> Vec<Finding> {
    let speed = subject
        .episodes
        .iter()
        .flat_map(|look| &look.motion)
        .map(|m| m.twist[0].hypot(m.twist[1]))
        .fold(0.0, f64::max);
    let wrong = if subject.size > LARGEST {
        format!("the object measures {:.1} m", subject.size)
    } else if speed > FASTEST {
        format!("the object reaches {speed:.0} m/s")
    } else {
        return vec![];
    };
    let sentence = format!("{wrong}: lengths seem to be in millimetres");
    vec![Finding::new(
        "units",
        Severity::Error,
        sentence,
        "divide lengths and positions by 1000: the format is in metres",
    )]
}

/// Degrees instead of radians: seen by the gripper's place on the object where it is known, otherwise by turns.
pub(crate) fn angles(subject: &Subject) -> Vec<Finding> {
    let reason = |look: &Look| match tightness(look) {
        Some(ratio) if ratio > TIGHTER => Some("only so does the gripper stay where it holds the object"),
        None if turns(look) > TURNS => Some("the object would turn round and round"),
        _ => None,
    };
    let finding = |look: &Look| {
        let sentence = format!("object_theta seems to be in degrees: {}", reason(look)?);
        let remedy = "multiply angles by π/180: the format is in radians";
        Some(Finding::new("units", Severity::Error, sentence, remedy).of(look.name()))
    };
    subject.episodes.iter().filter_map(finding).take(1).collect()
}

/// Range of the heading, or its distance from zero where that is larger, rad.
fn turns(look: &Look) -> f64 {
    let theta = || look.prepared.pose.iter().map(|p| p.pose[2]);
    width(theta).max(median(theta()).unwrap_or(0.0).abs())
}

/// How many times further the gripper wanders on the object if its heading is read as radians than as degrees;
/// `None` where there is no gripper, or the object does not turn enough to tell.
fn tightness(look: &Look) -> Option<f64> {
    let (Some(object), Some(Gripper::Level(gripper))) = (look.episode.object(), look.episode.gripper())
    else {
        return None;
    };
    let wander = |scale: f64| {
        let held = gripper.t.iter().zip(&gripper.value).filter(|(t, _)| **t >= look.prepared.contact);
        let places: Vec<[f64; 3]> = held
            .filter_map(|(t, pose)| {
                let [x, y, theta] = object.value[latest(&object.t, *t)?];
                Some(relative_pose(&[x, y, scale * theta], pose))
            })
            .collect();
        width(|| places.iter().map(|p| p[0])).hypot(width(|| places.iter().map(|p| p[1])))
    };
    let (radians, degrees) = (wander(1.0), wander(1f64.to_radians()));
    let turned = width(|| object.value.iter().map(|p| p[2]));
    (turned > 1.0 && degrees > 0.0).then(|| radians / degrees)
}

/// Range of `values` without the outermost two hundredths on either side.
fn width<I: Iterator<Item = f64>>(values: impl Fn() -> I) -> f64 {
    quantile(values(), 0.98).unwrap_or(0.0) - quantile(values(), 0.02).unwrap_or(0.0)
}

/// Newton millimetres instead of newton metres.
pub(crate) fn torques(subject: &Subject) -> Vec<Finding> {
    let loads = subject.episodes.iter().flat_map(|look| {
        look.prepared.wrench.iter().filter(|w| w.t >= look.prepared.contact).map(|w| w.reading)
    });
    let loads: Vec<[f64; 3]> = loads.collect();
    let force = median(loads.iter().map(|r| r[0].hypot(r[1]))).unwrap_or(0.0);
    let torque = median(loads.iter().map(|r| r[2].abs())).unwrap_or(0.0);
    if subject.size <= 0.0
        || force <= 3.0 * subject.dataset.noise.force
        || torque <= LONGEST_ARM * force * subject.size
    {
        return vec![];
    }
    let sentence = format!(
        "torques of {torque:.2} beside forces of {force:.2} N need an arm of {:.1} m: they seem to be in N mm",
        torque / force
    );
    vec![Finding::new("units", Severity::Error, sentence, "divide torques by 1000: the format is in N m")]
}

/// Stated noise in another unit than the data.
pub(crate) fn noise(subject: &Subject) -> Vec<Finding> {
    let (Some(stated), seen) = (&subject.meta.noise, subject.seen_noise.pose) else { return vec![] };
    let poses = subject.episodes.iter().map(|look| look.prepared.pose.len().saturating_sub(4));
    if poses.sum::<usize>() < ENOUGH {
        return vec![]; // too few to show a noise
    }
    let names = ["x", "y", "theta"];
    let axes = (0..3).filter(|&k| subject.dataset.dof[k]);
    let off = axes.filter(|&k| {
        seen[k] > LEAST_NOISE.max(NOISE_RATIO * stated.pose[k])
            || (seen[k] > NOISELESS && stated.pose[k] > UNUSED * seen[k])
    });
    let finding = |k: usize| {
        let sentence = format!(
            "noise.pose states {:.2e} for {}, the poses show {:.2e}",
            stated.pose[k], names[k], seen[k]
        );
        Finding::new(
            "noise",
            Severity::Warning,
            sentence,
            "state one standard deviation in metres and radians, or leave [noise] out",
        )
    };
    off.take(1).map(finding).collect()
}
