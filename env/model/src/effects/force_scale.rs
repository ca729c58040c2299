//! A force-torque sensor with a wrong gain: a wrong calibration matrix, a wrong unit, an amplifier.
//!
//! ```text
//! reading = diag(gain_x, gain_y, gain_torque) truth,   sensor axes
//! ```
//! A common factor of mass, friction and force does not change the motion. If the mass is free, only ratios of gains
//! are identifiable and `gain_x` is fixed to 1.

use super::positive;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Param, Spec, take};

/// A gain with a prior spread of about a third.
const fn gain(name: &'static str, help: &'static str) -> Param {
    Param { lower: 0.01, ..positive(name, "1", 100.0, (1.0, 0.3), help).alternative() }
}

pub(crate) static SPEC: Spec = Spec {
    kind: "force_scale",
    effect: "force_scale",
    summary: "wrong gains of the force-torque reading; only their ratios are identifiable unless the mass is given",
    source: "ratio of reading and truth, sensor axes",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        Param { needs_known_mass: true, ..gain("gain_x", "gain of force_x; 1 if the mass is free") },
        gain("gain_y", "gain of force_y").planar(),
        gain("gain_torque", "gain of torque_z").planar(),
    ],
    neutral: &[("gain_x", 1.0), ("gain_y", 1.0), ("gain_torque", 1.0)],
    sentence: "The force sensor has wrong gains: {gain_x} (force_x), {gain_y} (force_y) and {gain_torque} (torque_z).",
    suggested_push: "rotate the gripper by 90° on the object and repeat the push: the gain rotates with the sensor, \
        mass and friction do not; weigh the object to separate a common gain from the mass",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct ForceScale<T> {
    /// Inverse gains.
    share: [T; 3],
}

impl<T: Real> EffectLaw<T> for ForceScale<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        Self { share: take(values).map(T::recip) }
    }

    #[inline]
    fn correct(&self, reading: [T; 3], _clock: Clock) -> [T; 3] {
        [0, 1, 2].map(|k| reading[k] * self.share[k])
    }
}
