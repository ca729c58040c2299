//! A sensor whose reading follows the wrench with a first-order lag: a low-pass filter in its electronics.
//!
//! ```text
//! τ ṙ + r = w,   r: reading, w: truth
//! ```
//! Over a step from `a` to `b` the mean truth is `mean(r) + τ (r(b) − r(a))/(b − a)`: no derivative of noisy samples is
//! ever taken. From step to step the differences cancel, so that noise enters the impulse once, not summed up.

use super::positive;
use crate::Real;
use crate::law::{EffectLaw, EffectTarget, Lags, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "sensor_lag",
    effect: "sensor_lag",
    summary: "the reading follows the wrench with a first-order lag",
    source: "first-order low-pass filter: Oppenheim, Willsky 1997, ch. 6",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[positive("time_constant", "s", 1.0, (0.05, 1.0), "of the lag of the reading")],
    neutral: &[("time_constant", 0.0)],
    sentence: "The force reading follows the wrench with a lag of first order, time constant {time_constant}.",
    suggested_push: "push with short jerks and with slow swings: a lag flattens the jerks, a delay only shifts them",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct SensorLag<T> {
    time_constant: T,
}

impl<T: Real> EffectLaw<T> for SensorLag<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [time_constant] = take(values);
        Self { time_constant }
    }

    #[inline]
    fn lags(&self) -> Option<Lags<T>> {
        Some(Lags { sensor: self.time_constant, drive: T::zero() })
    }
}
