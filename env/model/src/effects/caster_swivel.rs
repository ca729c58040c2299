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
use crate::law::{Act, Acting, Action, Inner, Role, Site, Situation, Spec, take};
use std::f64::consts::FRAC_PI_4;

pub(crate) static SPEC: Spec = Spec {
    kind: "caster_swivel",
    effect: "caster_swivel",
    summary: "a caster that trails behind a pivot and swivels",
    source: "the kinematics of a trailing wheel: Campion, Bastin, D'Andréa-Novel 1996, off-centred orientable wheel",
    acting: Acting::Object,
    dissipative: true,
    loads: false,
    inner: &[Inner { name: "angle", unit: "rad", sd: 0.4, starts: &EIGHT }],
    params: &[
        on_body("x", 0, "the pivot, object frame"),
        on_body("y", 1, "the pivot, object frame"),
        positive("trail", "m", 1.0, (0.04, 0.7), "how far the wheel trails behind the pivot")
            .role(Role::Form)
            .above(5e-3)
            .planar(),
        positive("mu_side", "N·s/m", 1e6, (50.0, 1.5), "viscous friction across the caster's direction"),
    ],
    neutral: &[("mu_side", 0.0)],
    sentence: "A caster at ({x}, {y}) trails {trail} behind its pivot and resists with {mu_side} until it has swivelled.",
    probe: "push to and fro: at each reversal a caster must swing around, a fixed wheel does not",
};

/// Directions around the circle, rad.
static EIGHT: [f64; 8] = [
    0.0,
    FRAC_PI_4,
    2.0 * FRAC_PI_4,
    3.0 * FRAC_PI_4,
    4.0 * FRAC_PI_4,
    -3.0 * FRAC_PI_4,
    -2.0 * FRAC_PI_4,
    -FRAC_PI_4,
];

/// It may swivel so far in one part of a step, as `|v| dt / trail`, and a step has at most so many parts.
const PART: f64 = 1.0;
const PARTS: f64 = 16.0;

/// The law in place.
#[derive(Clone, Debug)]
pub struct CasterSwivel<T> {
    pivot: [T; 2],
    trail: T,
    side: T,
}

impl<T: Real> Act<T> for CasterSwivel<T> {
    const SAME_EVERYWHERE: bool = true;

    fn new(values: &[T], _site: &Site<'_, T>) -> Self {
        let [x, y, trail, side] = take(values);
        Self { pivot: [x, y], trail, side }
    }

    #[inline]
    fn act(&self, at: &Situation<'_, T>, sum: &mut Action<T>) {
        let Some(&angle) = at.inner.first() else { return };
        let (sin, cos) = angle.sin_cos();
        let [xx, xy, yy] = [sin * sin, -(sin * cos), cos * cos];
        sum.drag_at(self.pivot, [self.side * xx, self.side * xy, self.side * yy]);
    }

    /// Runge and Kutta's fourth order with the pivot's velocity held, object axes.
    fn advance(&self, at: &Situation<'_, T>, dt: f64, inner: &mut [T]) {
        let Some(angle) = inner.first_mut() else { return };
        let [vx, vy] = at.velocity(self.pivot).map(|v| v / self.trail);
        let spin = at.twist[2];
        let rate = |angle: T| {
            let (sin, cos) = angle.sin_cos();
            vy * cos - vx * sin - spin
        };
        let parts = (vx.re().hypot(vy.re()) * dt / PART).ceil().clamp(1.0, PARTS);
        let h = dt / parts;
        for _ in 0..parts as usize {
            let a = rate(*angle);
            let b = rate(*angle + a * (h / 2.0));
            let c = rate(*angle + b * (h / 2.0));
            let d = rate(*angle + c * h);
            *angle += (a + (b + c) * 2.0 + d) * (h / 6.0);
        }
    }
}
