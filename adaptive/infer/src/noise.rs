//! Noise of the instruments.

use trundle_record::{Noise, Prepared};

/// Noise standard deviations of each channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channels {
    /// Pose sample: x, y, θ in m, m, rad.
    pub pose: [f64; 3],
    /// One wrench sample, reading axes: N, N, N·m.
    pub reading: [f64; 3],
    /// Random walk of the model discrepancy, a wrench: N/√s, N/√s, N·m/√s.
    pub wander: [f64; 3],
}

impl Channels {
    /// Noise stated by a recording or estimated from it.
    pub fn of(noise: &Noise) -> Self {
        Self { pose: noise.pose, reading: [noise.force, noise.force, noise.torque], wander: [0.0; 3] }
    }

    /// The same with pose and reading noise multiplied by factors.
    #[must_use]
    pub fn scaled(&self, pose: f64, reading: f64) -> Self {
        Self { pose: self.pose.map(|s| s * pose), reading: self.reading.map(|s| s * reading), ..*self }
    }
}

/// Variance of the tare error of each reading axis.
pub(crate) fn tare_variance(episode: &Prepared) -> [f64; 3] {
    episode.tare_sd.map(|s| s * s)
}
