//! One anisotropic viscous wheel: the paper's `J_w = ⟨w_x, w_y, w_θ, μ_x, μ_y⟩`.
//!
//! ```text
//! F = −R(w_θ) diag(μ_x, μ_y) R(w_θ)ᵀ v(w)            (eq. 1–2)
//! ```
//! Equation 2 of the paper omits the sign and the rotation by `w_θ`; both are intended.

use super::{angle, on_body, positive};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "viscous_wheel",
    effect: "viscous_wheel",
    summary: "a wheel, track or slide with viscous friction along and across its rolling direction",
    source: "Scholz et al., eq. 1-2",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[
        on_body("x", 0, "wheel position, object frame"),
        on_body("y", 1, "wheel position, object frame"),
        angle("angle", std::f64::consts::PI, "rolling direction, object frame").planar(),
        positive("mu_x", "N·s/m", 1e6, (30.0, 2.0), "viscous friction along the rolling direction"),
        positive("mu_y", "N·s/m", 1e6, (30.0, 2.0), "viscous friction across the rolling direction").planar(),
    ],
    neutral: &[("mu_x", 0.0), ("mu_y", 0.0)],
    sentence: "A viscous wheel at ({x}, {y}) resists with {mu_x} along and {mu_y} across its rolling direction.",
    suggested_push: "push along and across the wheel's rolling direction at two speeds",
};

/// Damping of the body by a wheel `[x, y, angle, mu_x, mu_y]`.
pub(crate) fn wheel_damping<T: Real>([x, y, angle, mu_x, mu_y]: [T; 5]) -> GeneralisedForce<T> {
    let (sin, cos) = angle.sin_cos();
    let (along, across, mixed) = (cos.squared(), sin.squared(), sin * cos);
    let matrix = [mu_x * along + mu_y * across, (mu_x - mu_y) * mixed, mu_x * across + mu_y * along];
    let mut damping = GeneralisedForce::zero();
    damping.add_damping_at([x, y], matrix);
    damping
}

/// Law with its parameters: a constant damping matrix of the body.
#[derive(Clone, Debug)]
pub struct ViscousWheel<T> {
    damping: GeneralisedForce<T>,
}

impl<T: Real> EffectLaw<T> for ViscousWheel<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        Self { damping: wheel_damping(take(values)) }
    }

    #[inline]
    fn constant_force(&self) -> Option<&GeneralisedForce<T>> {
        Some(&self.damping)
    }
}
