//! Inertia of the end effector behind the sensor, which adds to the reading during acceleration.
//!
//! ```text
//! reading = truth + m a,   a: acceleration of the grasp point, from contact on
//! ```
//! The object with a point mass `m` at the grasp moves under the reading as the object alone moves under the true
//! wrench. The law adds this point mass and does not estimate an acceleration from noisy poses.

use super::positive;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Rigid, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "gripper_inertia",
    effect: "gripper_inertia",
    summary: "inertia of the end effector in the force reading",
    source: "Newton's second law for the mass between sensor and grasp (Kubus, Kröger, Wahl 2008)",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: true,
    inner_states: &[],
    params: &[positive("mass", "kg", 1e3, (1.0, 1.0), "mass between sensor and object")],
    neutral: &[("mass", 0.0)],
    sentence: "The force reading includes the inertia of the gripper with mass {mass}.",
    suggested_push: "shake the object from two distant grasps: the mass of the gripper moves with the grasp, the mass \
        of the object does not",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct GripperInertia<T> {
    mass: T,
}

impl<T: Real> EffectLaw<T> for GripperInertia<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [mass] = take(values);
        Self { mass }
    }

    #[inline]
    fn change_mass(&self, clock: Clock, grasp: [f64; 2], rigid: &mut Rigid<T>) {
        if clock.in_contact() {
            rigid.add_point_mass(self.mass, grasp.map(T::lift));
        }
    }
}
