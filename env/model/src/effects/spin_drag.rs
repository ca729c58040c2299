//! More viscous wheels than one.
//!
//! Any number of viscous wheels is one symmetric positive semidefinite damping matrix, and any such matrix is
//! that of one wheel and a pure damping of the spin: where each of several wheels stands is not in the motion.

use super::positive;
use crate::Real;
use crate::law::{EffectLaw, EffectTarget, GeneralisedForce, LawContext, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "spin_drag",
    effect: "second_wheel",
    summary: "what further viscous wheels add to the first: a turn on the spot is braked too",
    source: "the damping matrix of viscous wheels is 3×3 and symmetric; one wheel has rank two",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[positive("spin", "N·m·s", 1e6, (5.0, 2.0), "damping of the spin").planar()],
    neutral: &[("spin", 0.0)],
    sentence: "More than one wheel resists: beside the one wheel that stands for them all, turning is braked by {spin}. Where each wheel stands is not in these data.",
    suggested_push: "turn the object on the spot about the wheel that was found: one wheel does not resist that, two do",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct SpinDrag<T> {
    spin: T,
}

impl<T: Real> EffectLaw<T> for SpinDrag<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [spin] = take(values);
        Self { spin }
    }

    #[inline]
    fn add_force(&self, _at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        sum.damping[5] += self.spin;
    }
}
