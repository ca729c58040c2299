//! How noisy the instruments are.

use trundle_record::{Noise, Prepared};

/// Standard deviations of each channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channels {
    /// Pose sample: x, y, θ in m, m, rad.
    pub pose: [f64; 3],
    /// One wrench sample, reading axes: N, N, N·m.
    pub reading: [f64; 3],
    /// Random walk of an unnamed wrench on top of it: N/√s, N/√s, N·m/√s.
    pub wander: [f64; 3],
}

impl Channels {
    /// As stated by, or estimated from, a recording.
    pub fn of(noise: &Noise) -> Self {
        Self { pose: noise.pose, reading: [noise.force, noise.force, noise.torque], wander: [0.0; 3] }
    }

    /// The same with poses and readings noisier by factors.
    #[must_use]
    pub fn scaled(&self, pose: f64, reading: f64) -> Self {
        Self { pose: self.pose.map(|s| s * pose), reading: self.reading.map(|s| s * reading), ..*self }
    }
}

/// Variance of the tare error of each reading axis.
pub(crate) fn tare_variance(episode: &Prepared) -> [f64; 3] {
    episode.tare_sd.map(|s| s * s)
}
