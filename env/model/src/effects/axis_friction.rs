//! Dry friction along axes fixed in the world: linear guides, a gantry, slide and hinge joints of a simulator.
//!
//! ```text
//! F_k = −f_k (v·n_k)/√((v·n_k)² + ε²),   n_1 = (cos angle, sin angle) in the world, n_2 across it
//! τ   = −T ω/√(ω² + ε²/ρ²),              v: velocity of the object origin, ρ: radius of gyration
//! ```
//! Unlike friction at a contact, the axes are independent: each keeps its force while the other slides.

use super::axis_pair::{AxisPair, direction, force_x, force_y, torque};
use super::dry_friction::creep;
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "axis_friction",
    effect: "axis_friction",
    summary: "dry friction along two axes fixed in the world, each with its own force (guides, joints in series)",
    source: "Armstrong-Hélouvry, Dupont, Canudas de Wit 1994, Coulomb friction of each axis",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[direction("the first axis, world"), force_x(), force_y(), torque(), creep()],
    neutral: &[("force_x", 0.0), ("force_y", 0.0), ("torque", 0.0)],
    sentence: "Dry friction acts along axes fixed in the world: {force_x} along the direction {angle}, {force_y} \
        across it and {torque} against rotation.",
    suggested_push: "push along each axis and diagonally: friction of two axes is largest diagonally, whereas friction \
        of a contact is equal in every direction",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct AxisFriction<T> {
    /// Direction of the first axis, world.
    normal: [T; 2],
    axes: AxisPair<T>,
}

impl<T: Real> EffectLaw<T> for AxisFriction<T> {
    fn new(values: &[T], site: &LawSetup<'_, T>) -> Self {
        let [angle, force_x, force_y, torque, creep] = take(values);
        let (sin, cos) = angle.sin_cos();
        Self {
            normal: [cos, sin],
            axes: AxisPair::new([force_x, force_y], torque, creep, site.body.gyration),
        }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        self.axes.add_friction(at.object_axes(self.normal), at.twist, sum);
    }
}
