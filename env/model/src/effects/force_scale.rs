//! A force-torque sensor with a wrong gain: a wrong calibration matrix, a wrong unit, an amplifier.
//!
//! ```text
//! reading = diag(gain_x, gain_y, gain_torque) truth,   sensor axes
//! ```
//! Twice the mass and twice the friction under twice the force move alike. Where the mass is free only the ratios
//! are held, and `gain_x` is 1.

use super::positive;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Param, Spec, take};

/// A gain, a priori within a third either way.
const fn gain(name: &'static str, help: &'static str) -> Param {
    Param { lower: 0.01, ..positive(name, "1", 100.0, (1.0, 0.3), help).alternative() }
}

pub(crate) static SPEC: Spec = Spec {
    kind: "force_scale",
    effect: "force_scale",
    summary: "the wrong gain of the force-torque reading; only ratios are held unless the mass is given",
    source: "reading over truth, sensor axes",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        Param { needs_known_mass: true, ..gain("gain_x", "of force_x; 1 where the mass is free") },
        gain("gain_y", "of force_y").planar(),
        gain("gain_torque", "of torque_z").planar(),
    ],
    neutral: &[("gain_x", 1.0), ("gain_y", 1.0), ("gain_torque", 1.0)],
    sentence: "The force sensor has the wrong gain: it reads {gain_x} (force_x), {gain_y} (force_y) and {gain_torque} \
               (torque_z) of the truth.",
    suggested_push: "turn the gripper by a quarter on the object and repeat the push: the gain turns with the sensor, mass and \
            friction do not; weigh the object to tell a gain common to all axes from its mass",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct ForceScale<T> {
    /// Truth over reading.
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
