//! A moment of inertia that differs from that of a uniform body: a table whose mass is in its legs, a load in the middle.
//!
//! ```text
//! I = inertia_factor · I of the uniform body,   both about the mass centre
//! ```
//! The mass and the mass centre do not change. A rectangle with its mass at the corners has a factor of 3, a disc with its
//! mass at the rim 2, and a bar with its mass in the inner half of its length 0.25. The prior allows a factor of about 1.5
//! in either direction.

use super::positive;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Rigid, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "mass_spread",
    effect: "mass_spread",
    summary: "the moment of inertia differs from that of a uniform body",
    source: "Newton-Euler equations about the mass centre (Featherstone 2008, section 2.15)",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: true,
    inner_states: &[],
    params: &[positive(
        "inertia_factor",
        "1",
        5.0,
        (1.0, 0.4),
        "ratio of the inertia about the mass centre to that of the uniform body",
    )
    .at_least(0.05)
    .planar()],
    neutral: &[("inertia_factor", 1.0)],
    sentence: "The moment of inertia about the mass centre is {inertia_factor} times the value that follows from the \
        shape and the mass.",
    suggested_push: "turn the object quickly to and fro, and push it straight: a different inertia affects only the \
        acceleration of the rotation",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct MassSpread<T> {
    inertia_factor: T,
}

impl<T: Real> EffectLaw<T> for MassSpread<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [inertia_factor] = take(values);
        Self { inertia_factor }
    }

    #[inline]
    fn change_mass(&self, _clock: Clock, _grasp: [f64; 2], rigid: &mut Rigid<T>) {
        rigid.inertia = rigid.inertia * self.inertia_factor;
    }
}
