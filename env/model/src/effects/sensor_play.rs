//! A reading that follows the load with play: backlash between gripper and object, friction within the sensor. On each
//! reversal it stays where it is until the load has moved on by the width.
//!
//! ```text
//! |truth − reading| ≤ w/2, and = w/2 where the reading moves
//! truth ≈ reading + (w/2) sgn(r),   r: trend of the reading
//! ```
//! A reading that stands still says nothing of the load within the play; its mean there is taken as the reading. The sign is
//! told as far as the trend stands out of its noise; where that is not known, as in a simulation, it is rounded off.

use super::{positive, sign};
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "sensor_play",
    effect: "sensor_play",
    summary: "the reading follows the wrench with play (backlash, hysteresis)",
    source: "the play operator and its inverse: Krasnosel'skiĭ, Pokrovskiĭ 1989; Tao, Kokotović 1996",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        positive("force", "N", 1e4, (4.0, 1.0), "width of the play of either force axis").alternative(),
        positive("torque", "N·m", 1e4, (0.4, 1.0), "width of the play of torque_z").alternative().planar(),
    ],
    neutral: &[("force", 0.0), ("torque", 0.0)],
    sentence: "The reading follows the wrench with a play of {force} and {torque} (width).",
    suggested_push: "load the sensor slowly up and down again with known weights: the two curves lie apart by the play",
};

/// Time in which a reading that crosses the whole play counts as moving, s.
const CROSSING_TIME_S: f64 = 0.5;

/// The law in place.
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
