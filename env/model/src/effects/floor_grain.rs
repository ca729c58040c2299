//! A floor with a grain: boards, tiles with joints, brushed concrete. It resists along one direction of the world,
//! regardless of the heading of the object.
//!
//! ```text
//! F = −μ (v·g) g,   g = (cos angle, sin angle) in the world, at the object origin
//! ```

use super::{angle, positive};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Spec, take};
use std::f64::consts::PI;

pub(crate) static SPEC: Spec = Spec {
    kind: "floor_grain",
    effect: "floor_grain",
    summary: "a floor with a grain: viscous friction along one direction of the world",
    source: "orthotropic friction of textured floors (Mróz and Stupkiewicz 1994), its viscous form",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[
        positive("mu", "N·s/m", 1e6, (30.0, 1.5), "viscous friction along the direction"),
        angle("angle", PI, "the direction, world").planar(),
    ],
    neutral: &[("mu", 0.0)],
    sentence: "The floor resists with {mu} along the direction {angle} in the world.",
    suggested_push: "rotate the object by 90° and repeat the push: a floor grain keeps its direction in the world, a \
        wheel rotates with the object",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct FloorGrain<T> {
    mu: T,
    /// World axes.
    grain: [T; 2],
}

impl<T: Real> EffectLaw<T> for FloorGrain<T> {
    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [mu, angle] = take(values);
        let (sin, cos) = angle.sin_cos();
        Self { mu, grain: [cos, sin] }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        let [x, y] = at.object_axes(self.grain);
        sum.add_damping_at([T::zero(); 2], [self.mu * x * x, self.mu * x * y, self.mu * y * y]);
    }
}
