//! The end-effector's own mass, which the sensor before it reads too when it accelerates.
//!
//! ```text
//! reading = truth + m a,   a: acceleration of the reading's origin, from contact on
//! ```
//! The object with a point mass `m` at the grasp moves under the whole reading as the object alone does under the
//! truth, so that is what is simulated: no acceleration is ever taken from noisy poses.

use super::positive;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Rigid, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "gripper_inertia",
    effect: "gripper_inertia",
    summary: "the end-effector's own mass in the reading when it accelerates",
    source: "Newton's second law for what lies between sensor and grasp (Kubus, Kröger, Wahl 2008)",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: true,
    inner_states: &[],
    params: &[positive("mass", "kg", 1e3, (1.0, 1.0), "between the sensor and the object")],
    neutral: &[("mass", 0.0)],
    sentence: "The force reading holds the inertia of {mass} of the gripper itself.",
    suggested_push: "shake the object from two grasps far apart: the gripper's mass moves with the grasp, the object's does not",
};

/// The law in place.
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
