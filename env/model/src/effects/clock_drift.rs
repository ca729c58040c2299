//! Clock drift between wrench and poses: the clocks of two computers run at different rates.
//!
//! ```text
//! reading(t_c + (1 + d) s) = truth(t_c + s),   t_c: contact, at which both clocks agree
//! ```

use super::signed;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "clock_drift",
    effect: "clock_drift",
    summary: "the clocks of wrench and poses run at different rates",
    source: "clock skew: Mills 1991; Moon, Skelly, Towsley 1999",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[signed(
        "drift",
        "1",
        0.3,
        0.03,
        "seconds of the wrench clock per second of the pose clock, minus one",
    )],
    neutral: &[("drift", 0.0)],
    sentence: "The clock of the force reading drifts against the clock of the poses by {drift} s/s from contact on \
        (positive: fast).",
    suggested_push: "record a long push with an abrupt start and end: a delay shifts both, a drift only the end",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct ClockDrift<T> {
    drift: T,
}

impl<T: Real> EffectLaw<T> for ClockDrift<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [drift] = take(values);
        Self { drift }
    }

    #[inline]
    fn delay(&self, clock: Clock) -> Option<T> {
        Some(self.drift * clock.since_contact.max(0.0))
    }
}
