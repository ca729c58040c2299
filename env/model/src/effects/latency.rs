//! A delay of the wrench relative to the poses: buffers, filters, unsynchronised clocks.
//!
//! ```text
//! reading(t) = truth(t − delay)
//! ```

use super::signed;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "latency",
    effect: "latency",
    summary: "delay of the force reading relative to the poses",
    source: "reading(t) = truth(t − delay)",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[signed("delay", "s", 0.3, 0.1, "delay of the reading; negative if it is early")],
    neutral: &[("delay", 0.0)],
    sentence: "The force reading is delayed by {delay} (negative: early).",
    suggested_push: "push back and forth at two frequencies: the phase lag of a delay grows with the frequency, that \
        of friction does not",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct Latency<T> {
    delay: T,
}

impl<T: Real> EffectLaw<T> for Latency<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [delay] = take(values);
        Self { delay }
    }

    #[inline]
    fn delay(&self, _clock: Clock) -> Option<T> {
        Some(self.delay)
    }
}
