//! Checks of the sign of efforts: magnitudes that are declared signed, and reversed signs.

use super::dynamics::{DRY, GRAVITY_SIN, OWN_INERTIA, Rows, Terms, VISCOUS};
use super::input::Input;
use super::merge::{Found, merged};
use crate::check::{Finding, Severity};

/// Below this share of the largest magnitude an effort is near zero.
const NEAR_ZERO: f64 = 0.05;
/// Above this share it has left zero again.
const AWAY_FROM_ZERO: f64 = 0.2;
/// Smallest number of returns to zero: a magnitude returns at each change of the sign.
const MIN_RETURNS: usize = 3;
/// Largest misfit with signs relative to that without. Noise alone gives about 1.
const MAX_MISFIT_RATIO: f64 = 0.5;
/// Iterations of the alternation of signs and regression; it settles within a few.
const ITERATIONS: usize = 10;
/// Largest unexplained share of a regression that decides about a sign.
const MAX_UNEXPLAINED: f64 = 0.5;
/// Standard deviations at which a coefficient has the wrong sign.
const WRONG_SD: f64 = 5.0;
/// Standard deviations up to which another coefficient does not contradict.
const CONTRADICTION_SD: f64 = 2.0;

/// Checks for efforts without a sign.
pub(super) fn unsigned(input: &Input) -> Vec<Finding> {
    let mut found = Vec::new();
    let mut unusable = Vec::new();
    for (index, joint) in input.joints.iter().enumerate() {
        if !input.has("effort", joint) {
            continue;
        }
        if !input.has_signed_effort(joint) {
            if !input.has("target", joint) {
                let sentence =
                    format!("the effort of {joint} is declared as a magnitude, and {joint} has no target");
                let remedy = "record a signed effort or the target: nothing drives the joint in a simulation";
                let finding = Finding::new("effort", Severity::Error, sentence, remedy);
                unusable.push(Found { size: 0.0, joint: joint.clone(), finding });
            }
            continue;
        }
        if let Some(ratio) = lost_sign(input, index) {
            let sentence = format!(
                "the effort of {joint} never changes its sign, though the motion needs both: with signs the motion \
                 explains it {:.1} times better",
                1.0 / ratio.max(1e-3)
            );
            let remedy =
                "export the signed effort, or set [effort] signed = false; then targets drive the joints";
            let finding = Finding::new("sign", Severity::Error, sentence, remedy);
            found.push(Found { size: 1.0 / ratio.max(1e-3), joint: joint.clone(), finding });
        }
    }
    [merged(found), merged(unusable)].concat()
}

/// Misfit with signs relative to that without, if the effort of a joint is a magnitude.
fn lost_sign(input: &Input, index: usize) -> Option<f64> {
    let joint = &input.joints[index];
    let series: Vec<Vec<f64>> =
        input.raw.iter().filter_map(|episode| Some(episode.joint_stream("effort", joint)?.1)).collect();
    let all = || series.iter().flatten().copied();
    let (low, high) =
        all().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    if low < 0.0 && high > 0.0 || high == low {
        return None;
    }
    let largest = high.abs().max(low.abs());
    if series.iter().map(|values| returns(values, largest)).sum::<usize>() < MIN_RETURNS {
        return None;
    }
    let (rows, effort) = rows(input, index)?;
    let mean = effort.iter().sum::<f64>();
    let effort: Vec<f64> = effort.iter().map(|x| x * mean.signum()).collect();
    let plain = misfit(&rows.regressors.predict(&effort), &effort);
    // The signs that inertia, friction or gravity alone would give are starts of the alternation.
    let starts =
        [OWN_INERTIA, VISCOUS, GRAVITY_SIN].into_iter().filter_map(|column| rows.columns.get(column));
    let ratios = starts.map(|start| with_signs(&rows, &effort, start) / plain);
    ratios.min_by(f64::total_cmp).filter(|ratio| *ratio < MAX_MISFIT_RATIO)
}

/// Number of returns to zero.
fn returns(values: &[f64], largest: f64) -> usize {
    let (mut count, mut is_away) = (0, false);
    for value in values.iter().map(|value| value.abs()) {
        if value > AWAY_FROM_ZERO * largest {
            is_away = true;
        } else if value < NEAR_ZERO * largest && is_away {
            (count, is_away) = (count + 1, false);
        }
    }
    count
}

/// Misfit of magnitudes after signs and coefficients have been fitted in turn, from the signs of `start` on.
fn with_signs(rows: &Rows, magnitudes: &[f64], start: &[f64]) -> f64 {
    let mut signed: Vec<f64> = magnitudes.iter().zip(start).map(|(x, s)| x * s.signum()).collect();
    let mut least = f64::INFINITY;
    for _ in 0..ITERATIONS {
        let predicted = rows.regressors.predict(&signed);
        least = least.min(misfit(&predicted, &signed));
        signed = magnitudes.iter().zip(&predicted).map(|(x, p)| x * p.signum()).collect();
    }
    least
}

/// Residual sum of squares.
fn misfit(predicted: &[f64], response: &[f64]) -> f64 {
    response.iter().zip(predicted).map(|(y, p)| (y - p) * (y - p)).sum()
}

/// Checks for efforts that oppose the motion: negative inertia and friction that gives energy.
pub(super) fn reversed(input: &Input) -> Vec<Finding> {
    let mut found = Vec::new();
    for (index, joint) in input.joints.iter().enumerate() {
        let Some((rows, effort)) = rows(input, index) else { continue };
        let fit = rows.regressors.fit(&effort);
        let inertia = fit.z(OWN_INERTIA);
        let friction = if fit.z(VISCOUS).abs() > fit.z(DRY).abs() { fit.z(VISCOUS) } else { fit.z(DRY) };
        let is_reversed = (inertia < -WRONG_SD && friction < CONTRADICTION_SD)
            || (friction < -WRONG_SD && inertia < -CONTRADICTION_SD);
        if is_reversed && fit.unexplained < MAX_UNEXPLAINED {
            let sentence = format!(
                "the effort of {joint} opposes its motion: the inertia that fits is {:.3} ({:.0} standard deviations \
                 below zero)",
                fit.coefficients[OWN_INERTIA], -inertia
            );
            let remedy = format!("reverse the sign of effort_{joint}: set a negative [effort] gain");
            let finding = Finding::new("sign", Severity::Error, sentence, &remedy);
            found.push(Found { size: -inertia, joint: joint.clone(), finding });
        }
    }
    merged(found)
}

/// Regression of the effort of a joint, if it has one and moves.
pub(super) fn rows(input: &Input, index: usize) -> Option<(Rows, Vec<f64>)> {
    let joint = &input.joints[index];
    let (v_noise, v_rms) = input.speeds(index);
    let efforts: Vec<Option<Vec<f64>>> =
        input.episodes.iter().map(|episode| episode.effort(input.metadata, index, joint)).collect();
    if v_rms <= 5.0 * v_noise {
        return None;
    }
    let rows = Rows::new(input, index, &|episode| efforts[episode].is_some(), 0, Terms::Constant)?;
    let effort = rows.pick(&efforts, 0);
    Some((rows, effort))
}
