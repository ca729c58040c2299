//! First-order lag of a sensor: a low-pass filter in its electronics.
//!
//! ```text
//! τ ṙ + r = w,   r: reading, w: truth
//! ```
//! Over a step from `a` to `b` the mean truth is `mean(r) + τ (r(b) − r(a))/(b − a)`, without a derivative of noisy
//! samples. The differences of successive steps cancel, so that noise does not accumulate in the impulse.

use super::positive;
use crate::Real;
use crate::law::{EffectLaw, EffectTarget, Lags, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "sensor_lag",
    effect: "sensor_lag",
    summary: "the force reading follows the wrench with a first-order lag",
    source: "first-order low-pass filter: Oppenheim, Willsky 1997, ch. 6",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[positive("time_constant", "s", 1.0, (0.05, 1.0), "time constant of the sensor")],
    neutral: &[("time_constant", 0.0)],
    sentence: "The force reading follows the wrench with a first-order lag with time constant {time_constant}.",
    suggested_push: "push with short jerks and slow oscillations: a lag attenuates the jerks, a delay only shifts them",
};

/// Law with its parameters.
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
