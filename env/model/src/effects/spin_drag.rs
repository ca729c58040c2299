//! Additional viscous wheels.
//!
//! ```text
//! τ = −spin · ω
//! ```
//! Any number of viscous wheels is equivalent to one symmetric positive semidefinite damping matrix. Any such matrix is
//! that of one wheel and a pure spin damping. The positions of several wheels are therefore not identifiable.

use super::positive;
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "spin_drag",
    effect: "second_wheel",
    summary: "additional viscous wheels, represented by a damping of the spin",
    source: "the damping matrix of viscous wheels is symmetric 3×3; that of one wheel has rank two",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[positive("spin", "N·m·s", 1e6, (5.0, 2.0), "damping of the spin").planar()],
    neutral: &[("spin", 0.0)],
    sentence: "More than one wheel resists: in addition to one equivalent wheel, the spin is damped by {spin}. The \
        data do not identify the position of each wheel.",
    suggested_push: "rotate the object about the equivalent wheel: one wheel does not resist this rotation, two do",
};

/// Law with its parameters: a constant damping matrix of the body.
#[derive(Clone, Debug)]
pub struct SpinDrag<T> {
    damping: GeneralisedForce<T>,
}

impl<T: Real> EffectLaw<T> for SpinDrag<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [spin] = take(values);
        let mut damping = GeneralisedForce::zero();
        damping.damping[5] = spin;
        Self { damping }
    }

    #[inline]
    fn constant_force(&self) -> Option<&GeneralisedForce<T>> {
        Some(&self.damping)
    }
}
