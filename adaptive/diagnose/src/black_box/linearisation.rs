//! First-order expansion of a black-box simulator along the measured motion, with respect to the state, the
//! wrench and its parameters.

use super::path::{Interval, Path};
use super::simulator::{BlackBox, check_cancelled};
use nalgebra::{Matrix6, Matrix6x3, Vector6};
use trundle_infer::{InferError, StateVector, Watch};
use trundle_model::{Prior, Slot};

/// Steps of the central differences with respect to the state, about the uncertainty of a tracked state. A kink
/// of the simulator's friction is averaged over that width.
const STATE_STEPS: StateVector = [1e-3, 1e-3, 2e-3, 5e-3, 5e-3, 1e-2];

/// Steps with respect to the wrench, N, N, N·m.
const WRENCH_STEPS: [f64; 3] = [0.5, 0.5, 0.2];

/// Step with respect to a parameter, as a share of the scale of its prior.
const RELATIVE_STEP: f64 = 1e-3;

/// Map of one interval: `δ' = a δ + b w + defect + Σ slopes δφ` for deviations δ from the smoothed states.
#[derive(Clone, Debug)]
pub(crate) struct IntervalMap {
    pub a: Matrix6<f64>,
    pub b: Matrix6x3<f64>,
    pub defect: Vector6<f64>,
    pub slopes: Vec<Vector6<f64>>,
}

/// Maps of all intervals of an episode at values of the parameters.
pub(crate) fn linearise(
    simulator: &BlackBox<'_>,
    values: &[f64],
    free: &[usize],
    path: &Path,
    watch: &dyn Watch,
) -> Result<Vec<IntervalMap>, InferError> {
    let one = |interval: &Interval| {
        check_cancelled(watch)?;
        let at = |from: &StateVector, extra: &[f64; 3], values: &[f64]| {
            simulator.step_interval(&path.name, from, interval, extra, values)
        };
        let mut a = Matrix6::zeros();
        for (k, h) in STATE_STEPS.into_iter().enumerate() {
            let side = |h: f64| at(&perturbed(interval.from, k, h), &[0.0; 3], values);
            a.set_column(k, &central_difference(&side(h)?, &side(-h)?, h));
        }
        let mut b = Matrix6x3::zeros();
        for (k, h) in WRENCH_STEPS.into_iter().enumerate() {
            let side = |h: f64| at(&interval.from, &perturbed([0.0; 3], k, h), values);
            b.set_column(k, &central_difference(&side(h)?, &side(-h)?, h));
        }
        let mut slopes = Vec::with_capacity(free.len());
        for &k in free {
            let slot = &simulator.parameters[k];
            let (low, high) = bracket(slot, values[k]);
            let side = |value: f64| {
                let mut other = values.to_vec();
                other[k] = value;
                at(&interval.from, &[0.0; 3], &other)
            };
            slopes.push(central_difference(&side(high)?, &side(low)?, 0.5 * (high - low)));
        }
        let defect = state_difference(&at(&interval.from, &[0.0; 3], values)?, &interval.to);
        Ok(IntervalMap { a, b, defect, slopes })
    };
    path.intervals.iter().map(one).collect()
}

/// Defects of all intervals at values of the parameters, without derivatives.
pub(crate) fn defects(
    simulator: &BlackBox<'_>,
    values: &[f64],
    path: &Path,
    watch: &dyn Watch,
) -> Result<Vec<Vector6<f64>>, InferError> {
    let one = |interval: &Interval| {
        check_cancelled(watch)?;
        let after = simulator.step_interval(&path.name, &interval.from, interval, &[0.0; 3], values)?;
        Ok(state_difference(&after, &interval.to))
    };
    path.intervals.iter().map(one).collect()
}

fn perturbed<const N: usize>(mut from: [f64; N], k: usize, h: f64) -> [f64; N] {
    from[k] += h;
    from
}

/// Values on both sides of a parameter, within its bounds.
fn bracket(slot: &Slot, value: f64) -> (f64, f64) {
    let h = RELATIVE_STEP * parameter_scale(slot, value);
    ((value - h).max(slot.lower), (value + h).min(slot.upper))
}

/// Size of a typical change of a parameter.
pub(super) fn parameter_scale(slot: &Slot, value: f64) -> f64 {
    let size = match slot.prior {
        Prior::LogNormal { median, .. } => value.abs().max(1e-3 * median),
        Prior::Normal { sd, .. } => sd,
        Prior::Angle(_) => 1.0,
        _ => slot.upper - slot.lower,
    };
    if size.is_finite() && size > 0.0 { size } else { 1.0 }
}

fn central_difference(high: &StateVector, low: &StateVector, h: f64) -> Vector6<f64> {
    state_difference(high, low) / (2.0 * h)
}

/// Difference of two states. The heading is wrapped, since a simulator may return it modulo 2π.
pub(crate) fn state_difference(a: &StateVector, b: &StateVector) -> Vector6<f64> {
    let mut d = Vector6::from_fn(|k, _| a[k] - b[k]);
    d[2] -= (d[2] / std::f64::consts::TAU).round() * std::f64::consts::TAU;
    d
}
