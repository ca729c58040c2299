//! A force that is periodic in position: cogging of a linear drive, grooves in a floor, cleats of a track.
//!
//! ```text
//! F = A sin(2π s / p + φ) n,   s = n · position,   n = (cos angle, sin angle) in the world
//! ```
//! The force is conservative. On a rail, `n` is the direction of the rail. Cogging of a wheel depends on the rolled
//! distance instead of the position and is not covered.

use super::{angle, positive};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Param, Role, Spec, take};
use std::f64::consts::{PI, TAU};

pub(crate) static SPEC: Spec = Spec {
    kind: "cogging",
    effect: "cogging",
    summary: "a force that is periodic in position, along a rail or a direction of the floor",
    source: "the first harmonic of a linear motor's cogging force (Gieras, Piech, Tomczuk 2012, section 3.4)",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        positive("amplitude", "N", 1e5, (5.0, 1.5), "amplitude of the force"),
        Param {
            lower: 1e-3,
            ..positive("period", "m", 10.0, (0.06, 1.0), "spatial period").role(Role::Period)
        },
        Param { on_rail: true, ..angle("phase", TAU, "phase at the world origin") },
        angle("angle", PI, "direction of the force and of its variation, world").planar(),
    ],
    neutral: &[("amplitude", 0.0)],
    sentence: "A force with amplitude {amplitude} varies periodically with position; its period is {period}.",
    suggested_push: "push slowly back and forth over the same place: this force keeps its sign, whereas friction \
        reverses",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct Cogging<T> {
    amplitude: T,
    /// 2π over the period, 1/m.
    wave: T,
    phase: T,
    direction: [T; 2],
}

impl<T: Real> EffectLaw<T> for Cogging<T> {
    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [amplitude, period, phase, angle] = take(values);
        let (sin, cos) = angle.sin_cos();
        Self { amplitude, wave: period.recip() * TAU, phase, direction: [cos, sin] }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        let ([nx, ny], [x, y]) = (self.direction, at.position);
        let (force, _) = ((nx * x + ny * y) * self.wave + self.phase).sin_cos();
        let (fx, fy) = (self.amplitude * force * nx, self.amplitude * force * ny);
        let (sin, cos) = at.heading;
        sum.add_force_at([T::zero(); 2], [cos * fx + sin * fy, cos * fy - sin * fx]);
    }
}
