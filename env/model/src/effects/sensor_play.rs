//! A reading that follows the load with play: backlash between gripper and object, friction within the sensor. After a
//! reversal the reading is constant until the load has changed by the width of the play.
//!
//! ```text
//! |truth − reading| ≤ w/2, and = w/2 while the reading changes
//! truth ≈ reading + (w/2) sgn(r),   r: trend of the reading
//! ```
//! A constant reading does not determine the load within the play; the reading is taken as its mean. The sign is
//! weighted by the signal-to-noise ratio of the trend. If the noise is unknown, as in a simulation, the sign is
//! smoothed.

use super::{positive, sign};
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "sensor_play",
    effect: "sensor_play",
    summary: "the force reading follows the wrench with play (backlash, hysteresis)",
    source: "the play operator and its inverse: Krasnosel'skiĭ, Pokrovskiĭ 1989; Tao, Kokotović 1996",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        positive("force", "N", 1e4, (4.0, 1.0), "width of the play of both force axes").alternative(),
        positive("torque", "N·m", 1e4, (0.4, 1.0), "width of the play of torque_z").alternative().planar(),
    ],
    neutral: &[("force", 0.0), ("torque", 0.0)],
    sentence: "The force reading follows the wrench with play of width {force} (force) and {torque} (torque).",
    suggested_push: "load and unload the sensor slowly with known weights: the two curves differ by the play",
};

/// Time in which a reading must cross the play to count as changing, s.
const CROSSING_TIME_S: f64 = 0.5;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct SensorPlay<T> {
    width: [T; 3],
}

impl<T: Real> EffectLaw<T> for SensorPlay<T> {
    const IS_POSE_INVARIANT: bool = true;
    const USES_TREND: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [force, torque] = take(values);
        Self { width: [force, force, torque] }
    }

    #[inline]
    fn correct(&self, reading: [T; 3], clock: Clock) -> [T; 3] {
        [0, 1, 2].map(|k| reading[k] + self.width[k] * (self.sign(k, clock) / 2.0))
    }
}

impl<T: Real> SensorPlay<T> {
    fn sign(&self, k: usize, clock: Clock) -> T {
        sign(T::lift(clock.trend[k]), clock.noise[1][k], self.width[k] / CROSSING_TIME_S)
    }
}
