//! Dead band of a sensor, which reads small loads as zero and larger loads too low: an electronic threshold, a slack
//! mount.
//!
//! ```text
//! reading = sgn(truth) max(|truth| − b, 0),   each axis
//! truth  ≈ reading + b sgn(reading)
//! ```
//! Within the band the reading is pure noise, and the truth is taken as zero on average. The sign is weighted by the
//! signal-to-noise ratio of the reading. If the noise is unknown, as in a simulation, the sign is smoothed over a fifth
//! of the band.

use super::{positive, sign};
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "dead_band",
    effect: "dead_band",
    summary: "dead band of the sensor: small loads read zero, larger loads too low",
    source: "Tao, Kokotović 1996, dead zone and its inverse",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        positive("force", "N", 1e4, (3.0, 1.0), "half width of the dead band of both force axes")
            .alternative(),
        positive("torque", "N·m", 1e4, (0.3, 1.0), "half width of the dead band of torque_z")
            .alternative()
            .planar(),
    ],
    neutral: &[("force", 0.0), ("torque", 0.0)],
    sentence: "The force sensor has a dead band: it reads forces below {force} and torques below {torque} as zero, and \
        larger ones too low by that amount.",
    suggested_push: "increase the load on the sensor slowly with a spring balance: the dead band ends at the load with \
        the first reading",
};

/// Fraction of the band over which the sign is smoothed.
const SMOOTHING_FRACTION: f64 = 0.2;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct DeadBand<T> {
    band: [T; 3],
}

impl<T: Real> EffectLaw<T> for DeadBand<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [force, torque] = take(values);
        Self { band: [force, force, torque] }
    }

    #[inline]
    fn correct(&self, reading: [T; 3], clock: Clock) -> [T; 3] {
        [0, 1, 2].map(|k| reading[k] + self.band[k] * self.sign(k, reading[k], clock))
    }
}

impl<T: Real> DeadBand<T> {
    fn sign(&self, k: usize, reading: T, clock: Clock) -> T {
        sign(reading, clock.noise[0][k], self.band[k] * SMOOTHING_FRACTION)
    }
}
