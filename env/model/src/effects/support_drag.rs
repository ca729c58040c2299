//! Isotropic viscous friction under the whole body: felt, a lubricant film, a carpet.
//!
//! ```text
//! F = −Σ_i s_i μ v_i,   v_i: velocity of a support point, s_i: its share of the weight
//! ```

use super::{positive, spread, spread_out};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "support_drag",
    effect: "support_drag",
    summary: "viscous friction under the whole body, distributed over its support points",
    source: "viscous limit of Goyal, Ruina, Papadopoulos 1991",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[positive("mu", "N·s/m", 1e6, (30.0, 2.0), "viscous friction of the whole body"), spread()],
    neutral: &[("mu", 0.0)],
    sentence: "Viscous friction of {mu} acts under the whole body.",
    suggested_push: "repeat a push slowly and fast, and rotate the object on the spot once",
};

/// Law with its parameters: a constant damping matrix of the body.
#[derive(Clone, Debug)]
pub struct SupportDrag<T> {
    damping: GeneralisedForce<T>,
}

impl<T: Real> EffectLaw<T> for SupportDrag<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], site: &LawSetup<'_, T>) -> Self {
        let [mu, spread] = take(values);
        let mut damping = GeneralisedForce::zero();
        for (point, share) in spread_out(site.body, spread) {
            damping.add_isotropic_damping_at(point, mu * share);
        }
        Self { damping }
    }

    #[inline]
    fn constant_force(&self) -> Option<&GeneralisedForce<T>> {
        Some(&self.damping)
    }
}
