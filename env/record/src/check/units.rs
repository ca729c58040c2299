//! Whether everything is in SI units and radians.

use crate::episode::Gripper;
use crate::metadata::{Contact, Reference};
use crate::prepare::{latest, median, quantile, relative_pose};

use super::gains::{self, INCH};
use super::subject::{Look, Subject};
use super::{Finding, Severity};

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

/// Unit of length, then gains of torque and force: a wrong one of the first shows in the others.
pub(crate) fn scales(subject: &Subject) -> Vec<Finding> {
    let lengths = lengths(subject);
    if lengths.is_empty() { gains::gains(subject) } else { lengths }
}

/// Another unit of length than metres: that in which size, speed, mass of the area and reach are most plausible.
fn lengths(subject: &Subject) -> Vec<Finding> {
    let seen = Seen::new(subject);
    let stated = seen.score(1.0, 1.0);
    let units = UNITS.iter().flat_map(|unit| [(unit, unit.0), (unit, 1.0)]);
    let scored = units.map(|(unit, outline)| (seen.score(unit.0, outline), unit, outline));
    let Some((score, unit, outline)) = scored.max_by(|a, b| a.0.total_cmp(&b.0)) else { return vec![] };
    if score < stated + PLAUSIBLE {
        return vec![];
    }
    let what = if outline == 1.0 { "positions" } else { "lengths and positions" };
    let sentence = format!("{}: {what} seem to be in {}", seen.words(), unit.1);
    let remedy = format!("{} {what}: the format is in metres", unit.2);
    vec![Finding::new("units", Severity::Error, sentence, &remedy)]
}

/// Metres in a unit of length, its name, and what to do.
const UNITS: [(f64, &str, &str); 3] = [
    (0.001, "millimetres", "divide by 1000 all"),
    (0.01, "centimetres", "divide by 100 all"),
    (INCH, "inches", "multiply by 0.0254 all"),
];
/// Logarithm of the odds by which another unit must be more plausible than metres.
const PLAUSIBLE: f64 = 8.0;
/// What is pushed: median and spread (of the logarithm) of its size m, speed m/s, mass over area kg/m², and of the
/// gripper's distance over half its size.
const SIZE: (f64, f64) = (0.6, 0.9);
const SPEED: (f64, f64) = (0.3, 1.2);
const MASS: (f64, f64) = (25.0, 1.3);
const REACH: (f64, f64) = (0.8, 0.8);
/// Spread of the logarithm of a gain that the wrench shows, and the most that any one thing may tell.
const GAIN: f64 = 0.2;
const MOST: f64 = 50.0;

/// What a recording shows of its unit of length.
struct Seen {
    size: f64,
    speed: f64,
    reach: f64,
    /// Mass that the motion shows, kg, and the weighed one.
    mass: Option<f64>,
    weighed: Option<f64>,
    area: f64,
    /// Gain that torques lack beside forces and arms.
    gain: Option<f64>,
}

impl Seen {
    fn new(subject: &Subject) -> Self {
        let moving = subject.episodes.iter().flat_map(|look| &look.motion);
        let speed = quantile(moving.map(|m| m.twist[0].hypot(m.twist[1])), 0.95).unwrap_or(0.0);
        let away = |look: &Look| {
            let held = look.prepared.wrench.iter().filter(|w| w.t >= look.prepared.contact);
            median(held.map(|w| w.frame[0].hypot(w.frame[1])))
        };
        let sensor = subject.reference() == Reference::Sensor && !subject.meta.on_rail();
        let place = median(subject.episodes.iter().filter_map(away)).filter(|_| sensor).unwrap_or(0.0);
        let [low, high] = subject.dataset.body.bounds();
        let explained = subject.explained.as_ref();
        Self {
            size: subject.size,
            speed,
            reach: if subject.size > 0.0 { place / (subject.size / 2.0) } else { 0.0 },
            mass: explained.and_then(gains::mass).map(|(mass, _)| mass),
            weighed: subject.meta.object.mass,
            area: (high[0] - low[0]) * (high[1] - low[1]),
            gain: explained.and_then(gains::torque_gain),
        }
    }

    /// Logarithm of the plausibility if a recorded unit of position is `unit` metres, and one of the outline `outline`.
    fn score(&self, unit: f64, outline: f64) -> f64 {
        let cost = |value: f64, (median, spread): (f64, f64)| {
            let off = (value / median).ln() / spread;
            if value > 0.0 && value.is_finite() { -(0.5 * off * off).min(MOST) } else { 0.0 }
        };
        // The mass that acceleration shows is as many times too small as positions are too large.
        let mass = self.mass.map_or(0.0, |mass| mass / unit);
        let area = self.area * outline * outline;
        let weighed = self.weighed.map_or(0.0, |weighed| {
            let at = |force: f64| cost(mass / weighed * force, (1.0, GAIN));
            // Another unit of force is as likely as one of length.
            if unit == 1.0 { gains::FORCES.map(at).into_iter().fold(at(1.0), f64::max) } else { at(1.0) }
        });
        let gain = self.gain.map_or(0.0, |gain| gain * unit);
        cost(self.size * outline, SIZE)
            + cost(self.speed * unit, SPEED)
            + cost(if area > 0.0 { mass / area } else { 0.0 }, MASS)
            + cost(self.reach * unit / outline, REACH)
            + weighed
            + cost(gain, (1.0, GAIN))
    }

    fn words(&self) -> String {
        let mass = self.mass.map_or(String::new(), |mass| format!(", behaves as if it weighed {mass:.3} kg"));
        format!("in metres the object measures {:.1} m, moves at {:.2} m/s{mass}", self.size, self.speed)
    }
}

/// Degrees instead of radians: seen by the gripper's place on the object where it is known, otherwise by turns.
pub(crate) fn angles(subject: &Subject) -> Vec<Finding> {
    let grasps = subject.meta.wrench.contact == Contact::Grasp;
    let reason = |look: &Look| match tightness(look).filter(|_| grasps) {
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
    if subject.explained.is_some() {
        return vec![]; // `gains` tells more
    }
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
