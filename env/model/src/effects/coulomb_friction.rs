//! Dry friction at one point of the body: a dragging foot, a jammed caster.
//!
//! ```text
//! F = −f(|v|) v / √(|v|² + ε²),   v: velocity of the point
//! ```

use super::dry_friction::{DryFriction, creep, static_force, stribeck_velocity};
use super::{on_body, positive};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "coulomb_friction",
    effect: "coulomb_friction",
    summary: "dry friction at a point: stiction, sliding, Stribeck effect",
    source: "Armstrong-Hélouvry, Dupont, Canudas de Wit 1994",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[
        on_body("x", 0, "contact point, object frame"),
        on_body("y", 1, "contact point, object frame"),
        positive("force", "N", 1e5, (10.0, 1.5), "sliding friction"),
        static_force(),
        stribeck_velocity(),
        creep(),
    ],
    neutral: &[("force", 0.0)],
    sentence: "Dry friction of {force} acts at ({x}, {y}).",
    suggested_push: "repeat a push slowly and fast: dry friction is constant, viscous friction grows with speed; \
        rotate the object both ways to locate the point",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct CoulombFriction<T> {
    point: [T; 2],
    dry: DryFriction<T>,
}

impl<T: Real> EffectLaw<T> for CoulombFriction<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [x, y, force, static_force, stribeck, creep] = take(values);
        Self { point: [x, y], dry: DryFriction { force, static_force, stribeck, creep } }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        let c = self.dry.coefficient(at.point_velocity(self.point));
        sum.add_isotropic_damping_at(self.point, c);
    }
}
