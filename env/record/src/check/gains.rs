//! Units and gains of force, torque and length that the motion shows.

use super::axes::{EXPLAINS, evidence};
use super::clocks::inertial_share;
use super::dynamics::fit;
use super::explain::{Explained, Mistake};
use super::subject::Subject;
use super::{Finding, Severity};

/// The least gain of the torque that is a mistake of units.
const TORQUE: f64 = 2.0;
/// A factor within this share of a unit's is that unit's.
const NEAR: f64 = 0.2;
/// Standard deviations, and logarithm, by which the mass must differ from the weighed one, and the share of the force
/// that acceleration must explain.
const MASS: (f64, f64, f64) = (8.0, 0.22, 0.05);
/// Relative standard deviation of a mass that is known.
const KNOWN: f64 = 0.1;
/// Newtons in a kilogram-force and a pound-force, metres in an inch, kilograms in a pound.
const KGF: f64 = 9.80665;
const LBF: f64 = 4.448_222;
/// Newtons in other units of force.
pub(crate) const FORCES: [f64; 2] = [KGF, LBF];
pub(crate) const INCH: f64 = 0.0254;
const POUND: f64 = 0.453_592_37;

/// How many times too large torques are beside forces, and what that tells.
const TORQUES: [(f64, &str, &str); 8] = [
    (1000.0, "torques seem to be in N mm", "divide torques by 1000: the format is in N m"),
    (100.0, "torques seem to be in N cm", "divide torques by 100: the format is in N m"),
    (
        KGF,
        "forces seem to be in kgf while torques are in N m",
        "multiply forces by 9.80665: the format is in N",
    ),
    (
        LBF,
        "forces seem to be in lbf while torques are in N m",
        "multiply forces by 4.44822: the format is in N",
    ),
    (
        1.0 / INCH,
        "forces seem to be in lbf and torques in lbf in",
        "multiply forces by 4.44822 and torques by 0.112985",
    ),
    (
        0.01,
        "lengths seem to be in centimetres",
        "divide lengths and positions by 100: the format is in metres",
    ),
    (
        0.001,
        "lengths seem to be in millimetres",
        "divide lengths and positions by 1000: the format is in metres",
    ),
    (
        INCH,
        "lengths seem to be in inches",
        "multiply lengths and positions by 0.0254: the format is in metres",
    ),
];

/// Mass that the motion shows over the weighed one, and what that tells.
const MASSES: [(f64, &str, &str); 5] = [
    (
        1.0 / KGF,
        "the wrench seems to be in kgf",
        "multiply forces and torques by 9.80665: the format is in N and N m",
    ),
    (1.0 / LBF, "the wrench seems to be in lbf", "multiply forces by 4.44822: the format is in N"),
    (1000.0, "the wrench seems to be in mN, or the mass in tonnes", "divide forces and torques by 1000"),
    (0.001, "the wrench seems to be in kN, or the mass in grams", "give forces in N and object.mass in kg"),
    (POUND, "object.mass seems to be in pounds", "multiply object.mass by 0.4536: the format is in kg"),
];

/// Gain by which torques are to be multiplied, where it is believed.
pub(crate) fn torque_gain(explained: &Explained) -> Option<f64> {
    let Mistake::Gain { gain } = explained.best.mistake else { return None };
    let material = gain.ln().abs() > TORQUE.ln();
    (material && explained.best.fit.share < EXPLAINS).then_some(gain)
}

/// Mass that the motion shows, kg, and its standard deviation, where it is known well.
pub(crate) fn mass(explained: &Explained) -> Option<(f64, f64)> {
    if explained.best.fit.share > EXPLAINS {
        return None;
    }
    let change = explained.best.mistake.change();
    let (mass, sd) = explained.jackknife(|moments| fit(moments, &change, &explained.best.fit.terms).mass());
    (mass > 0.0 && sd < KNOWN * mass).then_some((mass, sd))
}

/// Torques against forces, and the mass against the weighed one.
pub(crate) fn gains(subject: &Subject) -> Vec<Finding> {
    let Some(explained) = &subject.explained else { return vec![] };
    if let Some(gain) = torque_gain(explained) {
        return vec![torque(explained, 1.0 / gain)];
    }
    let (Some(weighed), Some((mass, sd))) = (subject.meta.object.mass, mass(explained)) else {
        return vec![];
    };
    let off = (mass / weighed).ln().abs();
    let inertial = inertial_share(subject).unwrap_or(0.0);
    if off < MASS.1 || off < MASS.0 * sd / mass || inertial < MASS.2 {
        return vec![];
    }
    vec![weight(weighed, mass, sd)]
}

fn near(value: f64, unit: f64) -> bool {
    (value / unit).ln().abs() < NEAR
}

fn torque(explained: &Explained, times: f64) -> Finding {
    let sentence = |words: &str| {
        format!("{words}: beside the forces torques are {times:.3} times too large; {}", evidence(explained))
    };
    match TORQUES.iter().find(|(factor, ..)| near(times, *factor)) {
        Some((_, words, remedy)) => Finding::new("units", Severity::Error, sentence(words), remedy),
        None => Finding::new(
            "units",
            Severity::Warning,
            sentence("torques and forces differ in their gain"),
            "check the units and calibration of torques, forces and lengths",
        ),
    }
}

fn weight(weighed: f64, mass: f64, sd: f64) -> Finding {
    let ratio = mass / weighed;
    let seen = format!(
        "the motion shows a mass of {mass:.3} ± {sd:.3} kg, {ratio:.3} times the weighed {weighed:.3} kg"
    );
    match MASSES.iter().find(|(factor, ..)| near(ratio, *factor)) {
        Some((_, words, remedy)) => {
            Finding::new("units", Severity::Error, format!("{words}: {seen}"), remedy)
        }
        None => Finding::new(
            "mass",
            Severity::Warning,
            format!("{seen}: a gain of {ratio:.3} in the force would do that"),
            "check the force's gain and unit, and that the object was weighed as it was pushed",
        ),
    }
}
