//! Saturation of a sensor at the limits of its range.
//!
//! ```text
//! reading = min(|truth|, limit) sgn(truth),   each axis
//! truth  ≈ reading (1 + e s(|reading|/limit)),   s(q) = q³²/(1 + q³²)
//! ```
//! The recording does not contain the truncated part. The law replaces it by its mean, the fraction `e` of the limit,
//! while the reading is at the limit. Variations of the truth beyond the limit remain as a misfit. Noise blurs the
//! limit, so that the data may identify the correction but not excess and limit separately.

use super::positive;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Param, Spec, take};

/// Largest reading of an axis.
const fn limit(name: &'static str, unit: &'static str, median: f64, help: &'static str) -> Param {
    positive(name, unit, 1e5, (median, 1.0), help).at_least(1e-6).alternative()
}

pub(crate) static SPEC: Spec = Spec {
    kind: "saturation",
    effect: "saturation",
    summary: "the sensor saturates at the limits of its range",
    source: "mean of a censored variable: Tobin 1958",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        limit("limit_x", "N", 30.0, "largest reading of force_x"),
        limit("limit_y", "N", 30.0, "largest reading of force_y").planar(),
        limit("limit_torque", "N·m", 5.0, "largest reading of torque_z").planar(),
        positive("excess", "1", 10.0, (0.4, 0.8), "mean ratio of truth and limit at saturation, minus one")
            .alternative(),
    ],
    neutral: &[("excess", 0.0)],
    sentence: "The force sensor saturates at {limit_x} (force_x), {limit_y} (force_y) and {limit_torque} (torque_z). \
        At saturation the truth exceeds the limit on average by the fraction {excess}.",
    suggested_push: "repeat the push with half the force: the error vanishes at small forces",
};

/// Squared ratio of reading and limit above which `s` is one to within `2⁻³²`.
const FULL_EXCESS_RATIO_SQUARED: f64 = 4.0;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct Saturation<T> {
    /// Inverse limits.
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
