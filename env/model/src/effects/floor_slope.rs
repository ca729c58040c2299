//! A floor that is not level: a constant acceleration in the world, once in contact
//! (until then whatever held the object still holds it).

use super::signed;
use crate::Real;
use crate::law::{EffectLaw, EffectTarget, GeneralisedForce, LawContext, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "floor_slope",
    effect: "floor_slope",
    summary: "a sloping floor: a constant acceleration in the world, once in contact",
    source: "gravity's component along the floor, g·sin(slope)",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        signed("accel_x", "m/s²", 10.0, 0.2, "acceleration along world x"),
        signed("accel_y", "m/s²", 10.0, 0.2, "acceleration along world y").planar(),
    ],
    neutral: &[("accel_x", 0.0), ("accel_y", 0.0)],
    sentence: "The floor slopes: it accelerates the object by ({accel_x}, {accel_y}) in the world.",
    suggested_push: "turn the object by a quarter and repeat the push: a slope stays in the room, an offset of the sensor turns with the gripper",
};

/// The law in place.
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
