//! Dry friction under the whole body: the sum over its support points, each loaded by its share of the weight (Zhou et
//! al. 2016, eq. 2, for known support points). Under a flat face the pressure is unknown; its radial spread is a
//! parameter.
//!
//! ```text
//! F = −Σ_i s_i f(|v_i|) v_i/√(|v_i|² + ε²),   v_i: velocity of a support point, s_i: its share of the weight
//! ```

use super::dry_friction::{DryFriction, creep, static_force, stribeck_velocity};
use super::{positive, spread, spread_out};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "support_friction",
    effect: "coulomb_friction",
    summary: "dry friction under the whole body, distributed over its support points",
    source: "Zhou, Paolini, Bagnell, Mason 2016; Goyal, Ruina, Papadopoulos 1991",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[
        positive("force", "N", 1e5, (10.0, 1.5), "sliding friction of the whole body"),
        spread(),
        static_force(),
        stribeck_velocity(),
        creep(),
    ],
    neutral: &[("force", 0.0)],
    sentence: "Dry friction of {force} acts under the whole body.",
    suggested_push: "repeat a push slowly and fast: dry friction is constant, viscous friction grows with speed",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct SupportFriction<T> {
    /// Points, object frame, m, and their shares of the weight.
    support: Vec<([T; 2], f64)>,
    dry: DryFriction<T>,
}

impl<T: Real> EffectLaw<T> for SupportFriction<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], site: &LawSetup<'_, T>) -> Self {
        let [force, spread, static_force, stribeck, creep] = take(values);
        Self {
            support: spread_out(site.body, spread),
            dry: DryFriction { force, static_force, stribeck, creep },
        }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        for &(point, share) in &self.support {
            let c = self.dry.coefficient(at.point_velocity(point)) * share;
            sum.add_isotropic_damping_at(point, c);
        }
    }

    fn sliding_points(&self) -> Option<Vec<([T; 2], T)>> {
        let points = || self.support.iter().map(|&(point, share)| (point, self.dry.force * share)).collect();
        self.dry.is_constant().then(points)
    }
}
