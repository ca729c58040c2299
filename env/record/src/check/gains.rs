//! Checks of the units and gains of force, torque and mass by the motion.

use super::axes::{MAX_UNEXPLAINED_SHARE, evidence};
use super::clocks::inertial_share;
use super::dynamics::fit;
use super::finding::{Finding, Severity};
use super::input::CheckInput;
use super::wrench_fit::{Mistake, WrenchFits};

/// Minimum gain of the torque, or inverse gain, that is a mistake of units.
const MIN_TORQUE_GAIN: f64 = 2.0;
/// Tolerance of the logarithm of a factor that identifies a unit.
const UNIT_LOG_TOLERANCE: f64 = 0.2;
/// Minimum difference of the estimated from the stated mass in standard deviations.
const MIN_MASS_DIFFERENCE_SD: f64 = 8.0;
/// Minimum absolute logarithm of the ratio of the estimated to the stated mass.
const MIN_MASS_LOG_RATIO: f64 = 0.22;
/// Minimum inertial share of the force for a comparison of masses.
const MIN_INERTIAL_SHARE: f64 = 0.05;
/// Maximum relative standard deviation of a usable estimate of the mass.
const MAX_MASS_RELATIVE_SD: f64 = 0.1;
/// Newtons per kilogram-force.
const NEWTONS_PER_KGF: f64 = 9.80665;
/// Newtons per pound-force.
const NEWTONS_PER_LBF: f64 = 4.448_222;
/// Newtons per other unit of force.
pub(crate) const FORCE_UNITS_N: [f64; 2] = [NEWTONS_PER_KGF, NEWTONS_PER_LBF];
/// Metres per inch.
pub(crate) const METRES_PER_INCH: f64 = 0.0254;
/// Kilograms per pound.
const KILOGRAMS_PER_POUND: f64 = 0.453_592_37;

/// Unit mistakes by the factor by which torques are too large relative to forces: factor, finding, remedy.
const TORQUE_MISTAKES: [(f64, &str, &str); 8] = [
    (1000.0, "torques appear to be in N mm", "divide torques by 1000: the format uses N m"),
    (100.0, "torques appear to be in N cm", "divide torques by 100: the format uses N m"),
    (
        NEWTONS_PER_KGF,
        "forces appear to be in kgf while torques are in N m",
        "multiply forces by 9.80665: the format uses N",
    ),
    (
        NEWTONS_PER_LBF,
        "forces appear to be in lbf while torques are in N m",
        "multiply forces by 4.44822: the format uses N",
    ),
    (
        1.0 / METRES_PER_INCH,
        "forces appear to be in lbf and torques in lbf in",
        "multiply forces by 4.44822 and torques by 0.112985",
    ),
    (
        0.01,
        "lengths appear to be in centimetres",
        "divide lengths and positions by 100: the format uses metres",
    ),
    (
        0.001,
        "lengths appear to be in millimetres",
        "divide lengths and positions by 1000: the format uses metres",
    ),
    (
        METRES_PER_INCH,
        "lengths appear to be in inches",
        "multiply lengths and positions by 0.0254: the format uses metres",
    ),
];

/// Unit mistakes by the ratio of the estimated to the stated mass: ratio, finding, remedy.
const MASS_MISTAKES: [(f64, &str, &str); 5] = [
    (
        1.0 / NEWTONS_PER_KGF,
        "the wrench appears to be in kgf",
        "multiply forces and torques by 9.80665: the format uses N and N m",
    ),
    (
        1.0 / NEWTONS_PER_LBF,
        "the wrench appears to be in lbf",
        "multiply forces by 4.44822: the format uses N",
    ),
    (1000.0, "the wrench appears to be in mN, or the mass in tonnes", "divide forces and torques by 1000"),
    (0.001, "the wrench appears to be in kN, or the mass in grams", "give forces in N and object.mass in kg"),
    (
        KILOGRAMS_PER_POUND,
        "object.mass appears to be in pounds",
        "multiply object.mass by 0.4536: the format uses kg",
    ),
];

/// Gain by which torques must be multiplied; `None` if there is no significant one.
pub(crate) fn torque_gain(fits: &WrenchFits) -> Option<f64> {
    let Mistake::Gain { gain } = fits.best.mistake else { return None };
    let is_significant = gain.ln().abs() > MIN_TORQUE_GAIN.ln();
    (is_significant && fits.best.fit.unexplained < MAX_UNEXPLAINED_SHARE).then_some(gain)
}

/// Mass estimated from the motion, kg, and its standard deviation; `None` if it is not determined well.
pub(crate) fn mass(fits: &WrenchFits) -> Option<(f64, f64)> {
    if fits.best.fit.unexplained > MAX_UNEXPLAINED_SHARE {
        return None;
    }
    let correction = fits.best.mistake.correction();
    let (mass, sd) = fits.jackknife(|equations| fit(equations, &correction, &fits.best.fit.terms).mass());
    (mass > 0.0 && sd < MAX_MASS_RELATIVE_SD * mass).then_some((mass, sd))
}

/// Checks the gain of torques relative to forces, and the estimated mass against the stated one.
pub(crate) fn gains(input: &CheckInput) -> Vec<Finding> {
    let Some(fits) = &input.wrench_fits else { return vec![] };
    if let Some(gain) = torque_gain(fits) {
        return vec![torque_finding(fits, 1.0 / gain)];
    }
    let (Some(stated), Some((mass, sd))) = (input.data.meta.object.mass, mass(fits)) else {
        return vec![];
    };
    let log_ratio = (mass / stated).ln().abs();
    let inertial = inertial_share(input).unwrap_or(0.0);
    if log_ratio < MIN_MASS_LOG_RATIO
        || log_ratio < MIN_MASS_DIFFERENCE_SD * sd / mass
        || inertial < MIN_INERTIAL_SHARE
    {
        return vec![];
    }
    vec![mass_finding(stated, mass, sd)]
}

fn near(value: f64, unit: f64) -> bool {
    (value / unit).ln().abs() < UNIT_LOG_TOLERANCE
}

fn torque_finding(fits: &WrenchFits, factor: f64) -> Finding {
    let sentence = |words: &str| {
        format!(
            "{words}: relative to the forces, torques are {factor:.3} times too large; {}",
            evidence(fits)
        )
    };
    match TORQUE_MISTAKES.iter().find(|(unit, ..)| near(factor, *unit)) {
        Some((_, words, remedy)) => Finding::new("units", Severity::Error, sentence(words), remedy),
        None => Finding::new(
            "units",
            Severity::Warning,
            sentence("the gains of torques and forces are inconsistent"),
            "check the units and calibration of torques, forces and lengths",
        ),
    }
}

fn mass_finding(stated: f64, mass: f64, sd: f64) -> Finding {
    let ratio = mass / stated;
    let evidence = format!(
        "the motion implies a mass of {mass:.3} ± {sd:.3} kg, {ratio:.3} times the stated {stated:.3} kg"
    );
    match MASS_MISTAKES.iter().find(|(unit, ..)| near(ratio, *unit)) {
        Some((_, words, remedy)) => {
            Finding::new("units", Severity::Error, format!("{words}: {evidence}"), remedy)
        }
        None => Finding::new(
            "mass",
            Severity::Warning,
            format!("{evidence}: a force gain of {ratio:.3} would explain this"),
            "check the gain and the unit of the force, and that object.mass is the mass of the object as pushed",
        ),
    }
}
