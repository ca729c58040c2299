//! Viscous friction under the whole body: a felt, a film, a carpet; alike in every direction.

use super::positive;
use crate::law::{Act, Acting, Action, Situation, Spec, take};
use crate::{Body, Real, Support};

pub(crate) static SPEC: Spec = Spec {
    kind: "support_drag",
    effect: "support_drag",
    summary: "viscous friction under the whole body, shared by its support points",
    source: "the viscous limit of Goyal, Ruina, Papadopoulos 1991",
    acting: Acting::Object,
    dissipative: true,
    params: &[positive("mu", "N·s/m", 1e6, (30.0, 2.0), "viscous friction of the whole body")],
    neutral: &[("mu", 0.0)],
    sentence: "Viscous friction of {mu} acts under the whole body.",
    probe: "repeat one push slowly and fast, and once turning on the spot",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct SupportDrag<T> {
    support: Vec<Support>,
    mu: T,
}

impl<T: Real> Act<T> for SupportDrag<T> {
    fn new(values: &[T], body: &Body) -> Self {
        let [mu] = take(values);
        Self { support: body.support.clone(), mu }
    }

    #[inline]
    fn act(&self, _at: &Situation<T>, sum: &mut Action<T>) {
        for support in &self.support {
            let c = self.mu * support.share;
            sum.drag_at(support.point.map(T::lift), [c, T::zero(), c]);
        }
    }
}
