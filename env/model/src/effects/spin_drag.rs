//! More viscous wheels than one.
//!
//! Any number of viscous wheels is one symmetric positive semidefinite damping matrix, and any such matrix is
//! that of one wheel and a pure damping of the spin: where each of several wheels stands is not in the motion.

use super::positive;
use crate::Real;
use crate::law::{Act, Acting, Action, Site, Situation, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "spin_drag",
    effect: "second_wheel",
    summary: "what further viscous wheels add to the first: a turn on the spot is braked too",
    source: "the damping matrix of viscous wheels is 3×3 and symmetric; one wheel has rank two",
    acting: Acting::Object,
    dissipative: true,
    loads: false,
    inner: &[],
    params: &[positive("spin", "N·m·s", 1e6, (5.0, 2.0), "damping of the spin").planar()],
    neutral: &[("spin", 0.0)],
    sentence: "More than one wheel resists: beside the one wheel that stands for them all, turning is braked by {spin}. Where each wheel stands is not in these data.",
    probe: "turn the object on the spot about the wheel that was found: one wheel does not resist that, two do",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct SpinDrag<T> {
    spin: T,
}

impl<T: Real> Act<T> for SpinDrag<T> {
    const SAME_EVERYWHERE: bool = true;

    fn new(values: &[T], _site: &Site<'_, T>) -> Self {
        let [spin] = take(values);
        Self { spin }
    }

    #[inline]
    fn act(&self, _at: &Situation<'_, T>, sum: &mut Action<T>) {
        sum.drag[5] += self.spin;
    }
}
