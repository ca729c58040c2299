//! A sensor that reads no more than its range.
//!
//! ```text
//! reading = min(|truth|, limit) sgn(truth),   each axis
//! truth  ≈ reading (1 + e s(|reading|/limit)),   s(q) = q³²/(1 + q³²)
//! ```
//! What was cut off is not in the recording. The law gives it its mean, `e` of the limit, wherever the reading stands at
//! the limit; how the truth varied there stays unknown, so that some of the misfit remains. Noise rounds the limit off: the
//! data may hold the correction there but not what of it is excess and what is limit.

use super::positive;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Param, Spec, take};

/// The largest load of an axis that is read.
const fn limit(name: &'static str, unit: &'static str, median: f64, help: &'static str) -> Param {
    positive(name, unit, 1e5, (median, 1.0), help).at_least(1e-6).alternative()
}

pub(crate) static SPEC: Spec = Spec {
    kind: "saturation",
    effect: "saturation",
    summary: "the sensor reads no more than its range",
    source: "the mean of a censored variable: Tobin 1958",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        limit("limit_x", "N", 30.0, "largest force_x that is read"),
        limit("limit_y", "N", 30.0, "largest force_y that is read").planar(),
        limit("limit_torque", "N·m", 5.0, "largest torque_z that is read").planar(),
        positive(
            "excess",
            "1",
            10.0,
            (0.4, 0.8),
            "mean of truth over limit less one, while the limit is read",
        )
        .alternative(),
    ],
    neutral: &[("excess", 0.0)],
    sentence: "The force sensor saturates at {limit_x} (force_x), {limit_y} (force_y) and {limit_torque} (torque_z); while \
               it does, the truth is larger by {excess} of the limit on average.",
    suggested_push: "repeat the push with half the force: what is wrong only at large forces is gone",
};

/// Where the share of the excess is one to the last digit: `2³² ≈ 4·10⁹`.
const FULL_EXCESS_RATIO_SQUARED: f64 = 4.0;

/// The law in place.
#[derive(Clone, Debug)]
pub struct Saturation<T> {
    /// One over the limits.
    over: [T; 3],
    excess: T,
}

impl<T: Real> EffectLaw<T> for Saturation<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [x, y, torque, excess] = take(values);
        Self { over: [x, y, torque].map(T::recip), excess }
    }

    #[inline]
    fn correct(&self, reading: [T; 3], _clock: Clock) -> [T; 3] {
        [0, 1, 2].map(|k| {
            let square = (reading[k] * self.over[k]).squared();
            if square.re() > FULL_EXCESS_RATIO_SQUARED {
                return reading[k] * (self.excess + 1.0);
            }
            let high = square.squared().squared().squared().squared();
            reading[k] * (self.excess * (high / (high + 1.0)) + 1.0)
        })
    }
}
