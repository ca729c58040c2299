//! A caster: a wheel that trails behind a pivot and swivels into the direction of motion.
//!
//! ```text
//! F = −μ (v·n) n at the pivot,   φ̇ = (v·n)/trail in the world;   n = (−sin φ, cos φ)
//! ```
//! `v` is the pivot's velocity and `φ` the direction from the wheel to the pivot. The wheel does not slip sideways, so
//! the pivot's sideways motion turns it; what resists that turning (the tyre scrubs on the floor) is the side force: with
//! a torque `D φ̇` it is `μ = D/trail²`. Where the caster points at first nobody knows: it is an inner state, in the object frame.

use super::{on_body, positive};
use crate::Real;
use crate::law::{
    EffectLaw, EffectTarget, GeneralisedForce, InnerState, LawContext, LawSetup, Role, Spec, take,
};
use std::f64::consts::FRAC_PI_4;

pub(crate) static SPEC: Spec = Spec {
    kind: "caster_swivel",
    effect: "caster_swivel",
    summary: "a caster that trails behind a pivot and swivels",
    source: "the kinematics of a trailing wheel: Campion, Bastin, D'Andréa-Novel 1996, off-centred orientable wheel",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[InnerState { name: "angle", unit: "rad", sd: 0.4, starts: &START_ANGLES_RAD }],
    params: &[
        on_body("x", 0, "the pivot, object frame"),
        on_body("y", 1, "the pivot, object frame"),
        positive("trail", "m", 1.0, (0.04, 0.7), "how far the wheel trails behind the pivot")
            .role(Role::Shape)
            .at_least(5e-3)
            .planar(),
        positive("mu_side", "N·s/m", 1e6, (50.0, 1.5), "viscous friction across the caster's direction"),
    ],
    neutral: &[("mu_side", 0.0)],
    sentence: "A caster at ({x}, {y}) trails {trail} behind its pivot and resists with {mu_side} until it has swivelled.",
    suggested_push: "push to and fro: at each reversal a caster must swing around, a fixed wheel does not",
};

/// Directions around the circle, rad.
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

/// It may swivel so far in one part of a step, as `|v| dt / trail`, and a step has at most so many substeps.
const MAX_SWIVEL_PER_SUBSTEP: f64 = 1.0;
const MAX_SUBSTEPS: f64 = 16.0;

/// The law in place.
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

    /// Runge and Kutta's fourth order with the pivot's velocity held, object axes.
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
