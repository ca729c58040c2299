//! A sloping floor: a constant acceleration in the world. It acts after contact; before contact the object is held at
//! rest.
//!
//! ```text
//! F = M (accel_x, accel_y) in the world, at the mass centre
//! ```

use super::signed;
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "floor_slope",
    effect: "floor_slope",
    summary: "a sloping floor: a constant acceleration in the world after contact",
    source: "component of gravity along the floor, g·sin(slope)",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        signed("accel_x", "m/s²", 10.0, 0.2, "acceleration along world x"),
        signed("accel_y", "m/s²", 10.0, 0.2, "acceleration along world y").planar(),
    ],
    neutral: &[("accel_x", 0.0), ("accel_y", 0.0)],
    sentence: "The floor slopes and accelerates the object by ({accel_x}, {accel_y}) in the world.",
    suggested_push: "rotate object and gripper by 90° and repeat the push: a slope keeps its direction in the world, \
        an offset of the sensor rotates with the gripper",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct FloorSlope<T> {
    accel: [T; 2],
}

impl<T: Real> EffectLaw<T> for FloorSlope<T> {
    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [x, y] = take(values);
        Self { accel: [x, y] }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        if !at.clock.in_contact() {
            return;
        }
        let (sin, cos) = at.heading;
        let [ax, ay] = self.accel.map(|a| a * at.mass);
        sum.add_force_at(at.com, [cos * ax + sin * ay, cos * ay - sin * ax]);
    }
}
