//! Dry friction along axes fixed in the body: a slide on the object, joints that rotate with it.
//!
//! ```text
//! F_k = −f_k (v·n_k)/√((v·n_k)² + ε²),   n_1 = (cos angle, sin angle) in the body, n_2 across it
//! τ   = −T ω/√(ω² + ε²/ρ²),              v: velocity of the object origin, ρ: radius of gyration
//! ```

use super::axis_pair::{AxisPair, direction, force_x, force_y, torque};
use super::dry_friction::creep;
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "body_axis_friction",
    effect: "axis_friction",
    summary: "dry friction along two axes fixed in the body, each with its own force",
    source: "Armstrong-Hélouvry, Dupont, Canudas de Wit 1994, Coulomb friction of each axis",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[direction("the first axis, object frame"), force_x(), force_y(), torque(), creep()],
    neutral: &[("force_x", 0.0), ("force_y", 0.0), ("torque", 0.0)],
    sentence: "Dry friction acts along axes fixed in the body: {force_x} along the direction {angle}, {force_y} across \
        it and {torque} against rotation.",
    suggested_push: "rotate the object by 45° and repeat a push along one axis: axes of the body rotate with it, axes \
        of the world do not",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct BodyAxisFriction<T> {
    /// Direction of the first axis, object frame.
    normal: [T; 2],
    axes: AxisPair<T>,
}

impl<T: Real> EffectLaw<T> for BodyAxisFriction<T> {
    const IS_POSE_INVARIANT: bool = true;

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
        self.axes.add_friction(self.normal, at.twist, sum);
    }
}
