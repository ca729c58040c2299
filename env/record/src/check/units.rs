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

/// Degrees instead of radians.
pub(crate) fn angles(subject: &Subject) -> Vec<Finding> {
    let wrong = |look: &&Look| too_many_turns(look) || tighter_in_degrees(look);
    let name = |look: &Look| {
        let sentence = "object_theta seems to be in degrees: ".to_owned()
            + if too_many_turns(look) {
                "the object would turn round and round"
            } else {
                "only so does the gripper stay where it holds the object"
            };
        Finding::new("units", Severity::Error, sentence, "multiply angles by π/180: the format is in radians")
    };
    subject.episodes.iter().filter(wrong).take(1).map(|look| name(look).of(look.name())).collect()
}

fn too_many_turns(look: &Look) -> bool {
    let Some(object) = look.episode.object() else { return false };
    let theta = || object.value.iter().map(|p| p[2]);
    let (low, high) = (quantile(theta(), 0.02), quantile(theta(), 0.98));
    high.unwrap_or(0.0) - low.unwrap_or(0.0) > TURNS || median(theta()).is_some_and(|m| m.abs() > TURNS)
}

/// Whether the gripper keeps its place on the object much better if the heading is read as degrees.
fn tighter_in_degrees(look: &Look) -> bool {
    let (Some(object), Some(Gripper::Level(gripper))) = (look.episode.object(), look.episode.gripper())
    else {
        return false;
    };
    let spread = |scale: f64| {
        let held = gripper.t.iter().zip(&gripper.value).filter(|(t, _)| **t >= look.prepared.contact);
        let places: Vec<[f64; 3]> = held
            .filter_map(|(t, pose)| {
                let [x, y, theta] = object.value[latest(&object.t, *t)?];
                Some(relative_pose(&[x, y, scale * theta], pose))
            })
            .collect();
        let width = |k: usize| {
            let values = || places.iter().map(|p| p[k]);
            Some(quantile(values(), 0.95)? - quantile(values(), 0.05)?)
        };
        Some(width(0)?.hypot(width(1)?))
    };
    let (Some(radians), Some(degrees)) = (spread(1.0), spread(1f64.to_radians())) else { return false };
    let theta = || object.value.iter().map(|p| p[2]);
    let turned = quantile(theta(), 0.98).unwrap_or(0.0) - quantile(theta(), 0.02).unwrap_or(0.0);
    turned > 1.0 && radians > TIGHTER * degrees
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
    let (Some(stated), seen) = (&subject.meta.noise, subject.seen_noise) else { return vec![] };
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
