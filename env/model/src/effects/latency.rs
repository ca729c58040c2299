//! A wrench whose clock runs late: buffers, filters, two computers that never agreed on the time.
//!
//! ```text
//! reading(t) = truth(t − delay)
//! ```

use super::signed;
use crate::Real;
use crate::law::{Act, Acting, Clock, Site, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "latency",
    effect: "latency",
    summary: "the wrench's clock runs late",
    source: "reading at t is the truth at t less the delay",
    acting: Acting::Instrument,
    dissipative: false,
    loads: false,
    inner: &[],
    params: &[signed("delay", "s", 0.3, 0.1, "reading late: positive")],
    neutral: &[("delay", 0.0)],
    sentence: "The force reading comes late by {delay} (early where negative).",
    probe: "push to and fro at two frequencies: a delay grows with the frequency as no friction does",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct Latency<T> {
    delay: T,
}

impl<T: Real> Act<T> for Latency<T> {
    const SAME_EVERYWHERE: bool = true;

    fn new(values: &[T], _site: &Site<'_, T>) -> Self {
        let [delay] = take(values);
        Self { delay }
    }

    #[inline]
    fn delay(&self, _clock: Clock) -> Option<T> {
        Some(self.delay)
    }
}
