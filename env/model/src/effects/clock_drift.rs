//! A wrench whose clock runs at another rate than that of the poses: two computers without a common time.
//!
//! ```text
//! reading(t_c + (1 + d) s) = truth(t_c + s),   t_c: contact, where both clocks agree
//! ```

use super::signed;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "clock_drift",
    effect: "clock_drift",
    summary: "the wrench's clock runs at another rate than that of the poses",
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
        "seconds of the wrench's clock for each of the poses', less one",
    )],
    neutral: &[("drift", 0.0)],
    sentence: "The clock of the force reading runs at another rate than that of the poses: {drift} s/s fast (slow where \
               negative), counted from contact.",
    suggested_push: "record a long push that ends as abruptly as it begins: a delay shifts both ends alike, a drift only the last",
};

/// The law in place.
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
