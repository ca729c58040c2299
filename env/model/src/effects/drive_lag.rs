//! A drive that follows its command with a first-order lag: a current loop, a valve, a belt.
//!
//! ```text
//! τ ẇ + w = c,   c: recorded command, w: acting force
//! ```
//! It applies to recordings whose wrench was commanded instead of measured.

use super::positive;
use crate::Real;
use crate::law::{EffectLaw, EffectTarget, Lags, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "drive_lag",
    effect: "drive_lag",
    summary: "the force follows its command with a first-order lag",
    source: "first-order actuator model: Spong, Hutchinson, Vidyasagar 2006, ch. 6",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[positive("time_constant", "s", 1.0, (0.03, 1.0), "time constant of the drive")],
    neutral: &[("time_constant", 0.0)],
    sentence: "The force follows its command with a first-order lag with time constant {time_constant}.",
    suggested_push: "command steps: a lag smooths them, a delay only shifts them",
};

/// Law with its parameters.
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
