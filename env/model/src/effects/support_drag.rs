//! Viscous friction under the whole body: a felt, a film, a carpet; alike in every direction.

use super::{positive, spread, spread_out};
use crate::Real;
use crate::law::{Act, Acting, Action, Site, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "support_drag",
    effect: "support_drag",
    summary: "viscous friction under the whole body, shared by its support points",
    source: "the viscous limit of Goyal, Ruina, Papadopoulos 1991",
    acting: Acting::Object,
    dissipative: true,
    loads: false,
    inner: &[],
    params: &[positive("mu", "N·s/m", 1e6, (30.0, 2.0), "viscous friction of the whole body"), spread()],
    neutral: &[("mu", 0.0)],
    sentence: "Viscous friction of {mu} acts under the whole body.",
    probe: "repeat one push slowly and fast, and once turning on the spot",
};

/// The law in place: its drag on the body, which no state changes.
#[derive(Clone, Debug)]
pub struct SupportDrag<T> {
    drag: Action<T>,
}

impl<T: Real> Act<T> for SupportDrag<T> {
    const SAME_EVERYWHERE: bool = true;

    fn new(values: &[T], site: &Site<'_, T>) -> Self {
        let [mu, spread] = take(values);
        let mut drag = Action::none();
        for (point, share) in spread_out(site.body, spread) {
            drag.brake_at(point, mu * share);
        }
        Self { drag }
    }

    #[inline]
    fn steady(&self) -> Option<&Action<T>> {
        Some(&self.drag)
    }
}
