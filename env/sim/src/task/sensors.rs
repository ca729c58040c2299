//! Sensors of the tasks and their noise.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::constants::{MAX_NOISE_SDS, SENSOR_RATE_HZ};
use super::options::Options;
use crate::{Sensor, Tracker};

/// Wrist sensor of all tasks.
pub fn sensor(options: &Options) -> Sensor {
    let default = Sensor::default();
    Sensor {
        rate: SENSOR_RATE_HZ,
        force_noise: default.force_noise * options.noise,
        torque_noise: default.torque_noise * options.noise,
        ..default
    }
}

/// Pose tracker of all tasks.
pub fn tracker(options: &Options) -> Tracker {
    let default = Tracker::default();
    Tracker { noise: default.noise.map(|sd| sd * options.noise), drop_out: options.drop_out, ..default }
}

/// Random-number stream of a seed.
pub fn rng_stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

pub(super) fn add_noise(value: [f64; 3], sd: [f64; 3], rng: &mut ChaCha8Rng) -> [f64; 3] {
    [0, 1, 2]
        .map(|k| value[k] + sd[k] * rng.sample::<f64, _>(StandardNormal).clamp(-MAX_NOISE_SDS, MAX_NOISE_SDS))
}
