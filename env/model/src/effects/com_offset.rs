//! A mass centre that is not where a uniform body would have it: a drawer full of books, a motor at one end.
//!
//! The mass centre lies at `(com_x, com_y)` in the object frame; the inertia about it is that of the uniform body
//! about its own. Under a place the prior is even over the footprint, which every mass centre lies within but for
//! what hangs over. Feet keep the shares of the weight that they have under the body's own mass centre.

use super::on_body;
use crate::Real;
use crate::law::{BODY_VALUE, Clock, EffectLaw, EffectTarget, LawSetup, Rigid, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "com_offset",
    effect: "com_offset",
    summary: "the mass centre is elsewhere; inertia about it as for the uniform body",
    source: "Newton-Euler equations about the mass centre (Featherstone 2008, section 2.15)",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: true,
    inner_states: &[],
    params: &[
        on_body("com_x", 0, "the mass centre, object frame; neutral at the body's own"),
        on_body("com_y", 1, "the mass centre, object frame; neutral at the body's own"),
    ],
    neutral: &[("com_x", BODY_VALUE), ("com_y", BODY_VALUE)],
    sentence: "The mass centre is at ({com_x}, {com_y}) of the object, not where a uniform body has it.",
    suggested_push: "push fast and stop fast across the line from the grasp to the middle, from two sides: a mass centre \
            elsewhere turns the object when it speeds up and turns it back when it slows down",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct ComOffset<T> {
    com: [T; 2],
}

impl<T: Real> EffectLaw<T> for ComOffset<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        Self { com: take(values) }
    }

    #[inline]
    fn change_mass(&self, _clock: Clock, _grasp: [f64; 2], rigid: &mut Rigid<T>) {
        rigid.com = self.com;
    }
}
