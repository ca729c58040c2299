//! An offset of the force-torque sensor that remains after the tare, or drifts.
//!
//! ```text
//! reading = truth + b + d (t − t_contact),   sensor axes, from contact on
//! ```

use super::signed;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "force_bias",
    effect: "force_bias",
    summary: "an offset of the force-torque reading after the tare, constant or drifting",
    source: "difference of reading and truth, sensor frame",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        signed("force_x", "N", 1e4, 2.0, "offset at contact"),
        signed("force_y", "N", 1e4, 2.0, "offset at contact").planar(),
        signed("torque_z", "N·m", 1e4, 0.5, "offset at contact").planar(),
        signed("drift_x", "N/s", 1e3, 0.3, "drift of the offset").refinement(0.0),
        signed("drift_y", "N/s", 1e3, 0.3, "drift of the offset").refinement(0.0).planar(),
    ],
    neutral: &[("force_x", 0.0), ("force_y", 0.0), ("torque_z", 0.0)],
    sentence: "The force sensor has an offset of ({force_x}, {force_y}) and {torque_z}.",
    suggested_push: "rotate object and gripper by 90° and repeat the push: an offset of the sensor rotates with the \
        gripper, a slope keeps its direction in the world",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct ForceBias<T> {
    offset: [T; 3],
    drift: [T; 2],
}

impl<T: Real> EffectLaw<T> for ForceBias<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [fx, fy, tz, dx, dy] = take(values);
        Self { offset: [fx, fy, tz], drift: [dx, dy] }
    }

    #[inline]
    fn correct(&self, reading: [T; 3], clock: Clock) -> [T; 3] {
        if !clock.in_contact() {
            return reading;
        }
        let t = clock.since_contact;
        [
            reading[0] - self.offset[0] - self.drift[0] * t,
            reading[1] - self.offset[1] - self.drift[1] * t,
            reading[2] - self.offset[2],
        ]
    }
}
