//! Viscous friction that differs between forward and backward motion along one direction of the body: a worn guide,
//! brushed felt, a drive with asymmetric losses.
//!
//! ```text
//! F = −Δμ |v·n| n,   n = (cos angle, sin angle), at the object origin
//! ```
//! The wheel represents the odd part of the friction and this law the even part. Alone, the law can add energy;
//! together with a wheel of μ ≥ |Δμ| it is dissipative.

use super::{angle, signed};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Spec, take};
use std::f64::consts::TAU;

pub(crate) static SPEC: Spec = Spec {
    kind: "directional_friction",
    effect: "directional_friction",
    summary: "viscous friction that differs between forward and backward motion along a body direction",
    source: "Janot, Gautier, Brunot 2019 (EMPS), direction-dependent model",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        angle("angle", TAU, "the direction, object frame"),
        signed(
            "difference",
            "N·s/m",
            1e6,
            30.0,
            "half the difference of forward and backward coefficients; μ is larger by this forward and smaller backward",
        ),
    ],
    neutral: &[("difference", 0.0)],
    sentence: "Viscous friction depends on the direction of motion: it exceeds its mean by {difference} forward and \
        falls below it by as much backward.",
    suggested_push: "push forward and backward at the same speed",
};

/// Speed over which the absolute value is smoothed, m/s.
const SMOOTHING_SPEED_M_PER_S: f64 = 1e-3;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct DirectionalFriction<T> {
    normal: [T; 2],
    difference: T,
}

impl<T: Real> EffectLaw<T> for DirectionalFriction<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [angle, difference] = take(values);
        let (sin, cos) = angle.sin_cos();
        Self { normal: [cos, sin], difference }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        let [nx, ny] = self.normal;
        let along = at.twist[0] * nx + at.twist[1] * ny;
        let size = self.difference
            * ((along.squared() + SMOOTHING_SPEED_M_PER_S * SMOOTHING_SPEED_M_PER_S).sqrt()
                - SMOOTHING_SPEED_M_PER_S);
        sum.add_force_at([T::zero(); 2], [-(size * nx), -(size * ny)]);
    }
}
