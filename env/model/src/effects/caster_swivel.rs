//! A caster: a wheel that trails behind a pivot and aligns with the direction of motion.
//!
//! ```text
//! F = −μ (v·n) n at the pivot,   φ̇ = (v·n)/trail in the world;   n = (−sin φ, cos φ)
//! ```
//! `v` is the velocity of the pivot and `φ` the direction from the wheel to the pivot. The wheel does not slip
//! sideways, so lateral motion of the pivot rotates it. A scrubbing torque `D φ̇` resists this rotation and causes the
//! side force, with `μ = D/trail²`. The initial direction is unknown: it is an inner state, in the object frame.

use super::{on_body, positive};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, InnerState, LawContext, LawSetup, Role, Spec, take};
use std::f64::consts::FRAC_PI_4;

pub(crate) static SPEC: Spec = Spec {
    kind: "caster_swivel",
    effect: "caster_swivel",
    summary: "a caster: a wheel that trails behind a pivot and aligns with the motion",
    source: "the kinematics of a trailing wheel: Campion, Bastin, D'Andréa-Novel 1996, off-centred orientable wheel",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[InnerState { name: "angle", unit: "rad", sd: 0.4, starts: &START_ANGLES_RAD }],
    params: &[
        on_body("x", 0, "the pivot, object frame"),
        on_body("y", 1, "the pivot, object frame"),
        positive("trail", "m", 1.0, (0.04, 0.7), "distance of the wheel behind the pivot")
            .role(Role::Shape)
            .at_least(5e-3)
            .planar(),
        positive("mu_side", "N·s/m", 1e6, (50.0, 1.5), "viscous friction across the direction of the caster"),
    ],
    neutral: &[("mu_side", 0.0)],
    sentence: "A caster with its pivot at ({x}, {y}) and a trail of {trail} resists with {mu_side} until it is aligned \
        with the motion.",
    suggested_push: "push back and forth: a caster swivels at each reversal, a fixed wheel does not",
};

/// Candidate initial directions, rad.
static START_ANGLES_RAD: [f64; 8] = [
    0.0,
    FRAC_PI_4,
    2.0 * FRAC_PI_4,
    3.0 * FRAC_PI_4,
    4.0 * FRAC_PI_4,
    -3.0 * FRAC_PI_4,
    -2.0 * FRAC_PI_4,
    -FRAC_PI_4,
];

/// Largest swivel per substep, `|v| dt / trail`, and largest number of substeps.
const MAX_SWIVEL_PER_SUBSTEP: f64 = 1.0;
const MAX_SUBSTEPS: f64 = 16.0;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct CasterSwivel<T> {
    pivot: [T; 2],
    trail: T,
    side: T,
}

impl<T: Real> EffectLaw<T> for CasterSwivel<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [x, y, trail, side] = take(values);
        Self { pivot: [x, y], trail, side }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        let Some(&angle) = at.inner.first() else { return };
        let (sin, cos) = angle.sin_cos();
        let [xx, xy, yy] = [sin * sin, -(sin * cos), cos * cos];
        sum.add_damping_at(self.pivot, [self.side * xx, self.side * xy, self.side * yy]);
    }

    /// Fourth-order Runge–Kutta method at constant velocity of the pivot, object axes.
    fn advance(&self, at: &LawContext<'_, T>, dt: f64, inner: &mut [T]) {
        let Some(angle) = inner.first_mut() else { return };
        let [vx, vy] = at.point_velocity(self.pivot).map(|v| v / self.trail);
        let spin = at.twist[2];
        let rate = |angle: T| {
            let (sin, cos) = angle.sin_cos();
            vy * cos - vx * sin - spin
        };
        let substeps = (vx.re().hypot(vy.re()) * dt / MAX_SWIVEL_PER_SUBSTEP).ceil().clamp(1.0, MAX_SUBSTEPS);
        let h = dt / substeps;
        for _ in 0..substeps as usize {
            let a = rate(*angle);
            let b = rate(*angle + a * (h / 2.0));
            let c = rate(*angle + b * (h / 2.0));
            let d = rate(*angle + c * h);
            *angle += (a + (b + c) * 2.0 + d) * (h / 6.0);
        }
    }
}
