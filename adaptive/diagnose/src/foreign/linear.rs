//! A foreign simulator along the motion that was seen: to first order in the state, the wrench and its parameters.

use super::path::{Interval, Path};
use super::simulator::{Foreign, go_on};
use nalgebra::{Matrix6, Matrix6x3, Vector6};
use trundle_infer::{InferError, StateVector, Watch};
use trundle_model::{Prior, Slot};

/// Steps of the central differences by the state: about what a tracker leaves open, so that a kink in a simulator's
/// friction is seen as wide as it matters.
const STATE: StateVector = [1e-3, 1e-3, 2e-3, 5e-3, 5e-3, 1e-2];

/// By the wrench, N, N, N·m.
const WRENCH: [f64; 3] = [0.5, 0.5, 0.2];

/// By a parameter, in what its prior takes for its scale.
const RELATIVE: f64 = 1e-3;

/// One interval: `δ' = a δ + b w + gap + Σ slopes δφ` for deviations δ from the smoothed states.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    pub a: Matrix6<f64>,
    pub b: Matrix6x3<f64>,
    pub gap: Vector6<f64>,
    pub slopes: Vec<Vector6<f64>>,
}

/// All intervals of an episode at parameter values.
pub(crate) fn linearise(
    foreign: &Foreign<'_>,
    values: &[f64],
    free: &[usize],
    path: &Path,
    watch: &dyn Watch,
) -> Result<Vec<Map>, InferError> {
    let one = |interval: &Interval| {
        go_on(watch)?;
        let at = |from: &StateVector, extra: &[f64; 3], values: &[f64]| {
            foreign.walk(&path.name, from, interval, extra, values)
        };
        let mut a = Matrix6::zeros();
        for (k, h) in STATE.into_iter().enumerate() {
            let side = |h: f64| at(&moved(interval.from, k, h), &[0.0; 3], values);
            a.set_column(k, &slope(&side(h)?, &side(-h)?, h));
        }
        let mut b = Matrix6x3::zeros();
        for (k, h) in WRENCH.into_iter().enumerate() {
            let side = |h: f64| at(&interval.from, &moved([0.0; 3], k, h), values);
            b.set_column(k, &slope(&side(h)?, &side(-h)?, h));
        }
        let mut slopes = Vec::with_capacity(free.len());
        for &k in free {
            let slot = &foreign.parameters[k];
            let (low, high) = sides(slot, values[k]);
            let side = |value: f64| {
                let mut other = values.to_vec();
                other[k] = value;
                at(&interval.from, &[0.0; 3], &other)
            };
            slopes.push(slope(&side(high)?, &side(low)?, 0.5 * (high - low)));
        }
        let gap = difference(&at(&interval.from, &[0.0; 3], values)?, &interval.to);
        Ok(Map { a, b, gap, slopes })
    };
    path.intervals.iter().map(one).collect()
}

/// What is left of each interval at parameter values, without slopes.
pub(crate) fn gaps(
    foreign: &Foreign<'_>,
    values: &[f64],
    path: &Path,
    watch: &dyn Watch,
) -> Result<Vec<Vector6<f64>>, InferError> {
    let one = |interval: &Interval| {
        go_on(watch)?;
        let after = foreign.walk(&path.name, &interval.from, interval, &[0.0; 3], values)?;
        Ok(difference(&after, &interval.to))
    };
    path.intervals.iter().map(one).collect()
}

fn moved<const N: usize>(mut from: [f64; N], k: usize, h: f64) -> [f64; N] {
    from[k] += h;
    from
}

/// Values to both sides of a parameter, within its bounds.
fn sides(slot: &Slot, value: f64) -> (f64, f64) {
    let h = RELATIVE * scale(slot, value);
    ((value - h).max(slot.lower), (value + h).min(slot.upper))
}

/// What changes a parameter noticeably.
pub(super) fn scale(slot: &Slot, value: f64) -> f64 {
    let size = match slot.prior {
        Prior::LogNormal { median, .. } => value.abs().max(1e-3 * median),
        Prior::Normal { sd, .. } => sd,
        Prior::Angle(_) => 1.0,
        _ => slot.upper - slot.lower,
    };
    if size.is_finite() && size > 0.0 { size } else { 1.0 }
}

fn slope(high: &StateVector, low: &StateVector, h: f64) -> Vector6<f64> {
    difference(high, low) / (2.0 * h)
}

/// One state less another; a heading may come back wound around differently.
pub(crate) fn difference(a: &StateVector, b: &StateVector) -> Vector6<f64> {
    let mut d = Vector6::from_fn(|k, _| a[k] - b[k]);
    d[2] -= (d[2] / std::f64::consts::TAU).round() * std::f64::consts::TAU;
    d
}
