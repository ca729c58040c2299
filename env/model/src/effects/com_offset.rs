//! A mass centre that differs from that of a uniform body: a drawer full of books, a motor at one end.
//!
//! ```text
//! com = (com_x, com_y),   inertia about it: unchanged
//! ```
//! The mass centre lies at `(com_x, com_y)` in the object frame. The inertia about it equals that of the uniform body
//! about its own mass centre. The prior is uniform over the footprint. The weight shares of feet stay as for the
//! uniform body.

use super::on_body;
use crate::Real;
use crate::law::{BODY_VALUE, Clock, EffectLaw, EffectTarget, LawSetup, Rigid, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "com_offset",
    effect: "com_offset",
    summary: "the mass centre differs from that of a uniform body; the inertia about it is unchanged",
    source: "Newton-Euler equations about the mass centre (Featherstone 2008, section 2.15)",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: true,
    inner_states: &[],
    params: &[
        on_body("com_x", 0, "mass centre, object frame; neutral at the mass centre of the uniform body"),
        on_body("com_y", 1, "mass centre, object frame; neutral at the mass centre of the uniform body"),
    ],
    neutral: &[("com_x", BODY_VALUE), ("com_y", BODY_VALUE)],
    sentence: "The mass centre lies at ({com_x}, {com_y}) in the object frame and not at that of a uniform body.",
    suggested_push: "from two sides, accelerate and stop quickly across the line from the grasp to the middle: an \
        offset mass centre rotates the object when it accelerates and back when it decelerates",
};

/// Law with its parameters.
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
