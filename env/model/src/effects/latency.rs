//! A wrench whose clock runs late: buffers, filters, two computers that never agreed on the time.
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
    summary: "the wrench's clock runs late",
    source: "reading at t is the truth at t less the delay",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[signed("delay", "s", 0.3, 0.1, "reading late: positive")],
    neutral: &[("delay", 0.0)],
    sentence: "The force reading comes late by {delay} (early where negative).",
    suggested_push: "push to and fro at two frequencies: a delay grows with the frequency as no friction does",
};

/// The law in place.
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
