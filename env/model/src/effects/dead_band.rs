//! A sensor that does not read small loads, and larger ones too low: a threshold in its electronics, a slack mount.
//!
//! ```text
//! reading = sgn(truth) max(|truth| − b, 0),   each axis
//! truth  ≈ reading + b sgn(reading)
//! ```
//! Within the band the reading is nothing but noise and says nothing of the truth, whose mean there is taken as zero. The sign is told as far as the reading stands out of its noise; where that is not
//! known, as in a simulation, it is rounded off over a fifth of the band.

use super::{positive, sign};
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "dead_band",
    effect: "dead_band",
    summary: "the sensor does not read small loads, and larger ones too low",
    source: "Tao, Kokotović 1996, dead zone and its inverse",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        positive("force", "N", 1e4, (3.0, 1.0), "half width of the band of either force axis").alternative(),
        positive("torque", "N·m", 1e4, (0.3, 1.0), "half width of the band of torque_z")
            .alternative()
            .planar(),
    ],
    neutral: &[("force", 0.0), ("torque", 0.0)],
    sentence: "The force sensor has a dead band: forces below {force} and torques below {torque} are not read, and larger \
               ones by as much too low.",
    suggested_push: "pull on the sensor with a spring balance, slowly more and more: the load at which it begins to read is the band",
};

/// Over which share of the band the sign is rounded off.
const SMOOTHING_FRACTION: f64 = 0.2;

/// The law in place.
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
