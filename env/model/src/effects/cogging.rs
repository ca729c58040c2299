//! A force that comes and goes with the place: the cogging of a linear drive, grooves in a floor, the cleats of a
//! track.
//!
//! ```text
//! F = A sin(2π s / p + φ) n,   s = n · position,   n = (cos angle, sin angle) in the world
//! ```
//! It has a potential, so what it takes on the way up it gives back on the way down. On a rail `n` is the rail.
//! A wheel's own cogging goes with the way that it has rolled, which is no place; that is another law.

use super::{angle, positive};
use crate::Real;
use crate::law::{EffectLaw, EffectTarget, GeneralisedForce, LawContext, LawSetup, Param, Role, Spec, take};
use std::f64::consts::{PI, TAU};

pub(crate) static SPEC: Spec = Spec {
    kind: "cogging",
    effect: "cogging",
    summary: "a force that is periodic in the place, along a rail or a direction of the floor",
    source: "the first harmonic of a linear motor's cogging force (Gieras, Piech, Tomczuk 2012, section 3.4)",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        positive("amplitude", "N", 1e5, (5.0, 1.5), "of the force"),
        Param {
            lower: 1e-3,
            ..positive("period", "m", 10.0, (0.06, 1.0), "of the place").role(Role::Period)
        },
        angle("phase", TAU, "at the world's origin"),
        angle("angle", PI, "direction in which it is periodic and acts, world").planar(),
    ],
    neutral: &[("amplitude", 0.0)],
    sentence: "A force of up to {amplitude} comes and goes with the place, every {period}.",
    suggested_push: "push slowly and steadily over the same place forth and back: this force keeps its sign where friction \
            turns round",
};

/// The law in place.
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
