//! Check of the gain of an effort against a known inertia or gravity torque.

use super::dynamics::{GRAVITY_SIN, OWN_INERTIA};
use super::effort_sign::rows;
use super::input::Input;
use crate::check::{Finding, Severity};
use crate::joints::per_joint::FreeOr;

/// Smallest factor by which an effort is too large or too small. Geared drives have a rotor inertia of that order.
const MIN_FACTOR: f64 = 1.5;
/// Smallest accuracy of the estimate: coefficient over standard deviation.
const MIN_Z: f64 = 5.0;
/// Largest unexplained share of the regression.
const MAX_UNEXPLAINED: f64 = 0.3;

/// Checks whether the effort fits the stated inertia and gravity torque of an axis.
pub(super) fn gain(input: &Input) -> Vec<Finding> {
    let mechanism = &input.metadata.mechanism;
    let known = [
        (OWN_INERTIA, mechanism.inertia, "the stated inertia"),
        (GRAVITY_SIN, mechanism.gravity_torque, "the stated gravity torque"),
    ];
    let joint = &input.joints[0];
    let is_free =
        |episode: &crate::Episode| input.metadata.effort_of(&episode.name, joint).gain == FreeOr::Free;
    if mechanism.axis.is_none() || input.raw.iter().any(is_free) {
        return vec![];
    }
    let Some((rows, effort)) = rows(input, 0) else { return vec![] };
    let fit = rows.regressors.fit(&effort);
    if fit.unexplained > MAX_UNEXPLAINED {
        return vec![];
    }
    let ratios = known.iter().filter_map(|(index, value, name)| {
        let value = (*value)?;
        let z = fit.coefficients.get(*index).map_or(0.0, |_| fit.z(*index));
        (z.abs() > MIN_Z).then(|| (fit.coefficients[*index] / value, *name))
    });
    let worst = ratios.max_by(|a, b| a.0.abs().ln().abs().total_cmp(&b.0.abs().ln().abs()));
    // A negative inertia is reported as a reversed sign.
    let Some((ratio, name)) = worst.filter(|(ratio, _)| *ratio > 0.0 && ratio.ln().abs() > MIN_FACTOR.ln())
    else {
        return vec![];
    };
    let sentence = format!("the effort of {joint} is {ratio:.3} times what {name} and the motion need");
    let remedy =
        format!("divide [effort] gain by {ratio:.3} (is it in the unit of the column?), or correct {name}");
    vec![Finding::new("units", Severity::Warning, sentence, &remedy)]
}
