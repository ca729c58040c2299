//! A drive that follows its command with a first-order lag: the current loop, the valve, the belt.
//!
//! ```text
//! τ ẇ + w = c,   c: commanded force, as recorded, w: the force that acts
//! ```
//! It is asked for where the recorded wrench was commanded, not measured.

use super::positive;
use crate::Real;
use crate::law::{EffectLaw, EffectTarget, Lags, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "drive_lag",
    effect: "drive_lag",
    summary: "a commanded force takes effect with a first-order lag",
    source: "first-order actuator model: Spong, Hutchinson, Vidyasagar 2006, ch. 6",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[positive("time_constant", "s", 1.0, (0.03, 1.0), "of the lag of the drive")],
    neutral: &[("time_constant", 0.0)],
    sentence: "The commanded force takes effect with a lag of first order, time constant {time_constant}.",
    suggested_push: "command steps: a lag rounds them off, a delay only shifts them",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct DriveLag<T> {
    time_constant: T,
}

impl<T: Real> EffectLaw<T> for DriveLag<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [time_constant] = take(values);
        Self { time_constant }
    }

    #[inline]
    fn lags(&self) -> Option<Lags<T>> {
        Some(Lags { sensor: T::zero(), drive: self.time_constant })
    }
}
