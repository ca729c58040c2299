//! The instruments of all tasks, and random numbers.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::options::Options;
use super::rules::{CUT, SENSOR_RATE};
use crate::{Sensor, Tracker};

/// The wrist sensor of all tasks.
pub fn sensor(options: &Options) -> Sensor {
    let plain = Sensor::default();
    Sensor {
        rate: SENSOR_RATE,
        force_noise: plain.force_noise * options.noise,
        torque_noise: plain.torque_noise * options.noise,
        ..plain
    }
}

/// The tracker of all tasks.
pub fn tracker(options: &Options) -> Tracker {
    let plain = Tracker::default();
    Tracker { noise: plain.noise.map(|sd| sd * options.noise), drop_out: options.drop_out, ..plain }
}

/// Stream of random numbers from a seed.
pub fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number);
    random
}

pub(super) fn blur(value: [f64; 3], sd: [f64; 3], random: &mut ChaCha8Rng) -> [f64; 3] {
    [0, 1, 2].map(|k| value[k] + sd[k] * random.sample::<f64, _>(StandardNormal).clamp(-CUT, CUT))
}
