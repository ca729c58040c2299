//! Samples of a prepared episode.

use super::transform::planar_transform;

/// A wrench sample of an episode.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WrenchSample {
    /// Time on the sensor's clock, s.
    pub t: f64,
    /// Tared force x, y in N and torque about the vertical in N m on the object. In sensor axes about the sensor's origin;
    /// without gripper poses, in the axes and about the reference point of the recording.
    pub reading: [f64; 3],
    /// Pose of the frame of the reading in the object frame at `t`: x, y in m, angle in rad.
    pub frame: [f64; 3],
    /// Noise density of the reading due to the uncertainty of `frame`: variance times correlation time, N² s, N² s,
    /// N² m² s.
    pub frame_noise: [f64; 3],
    /// Standard deviation of the position of `frame` along each axis, m.
    pub frame_sd: f64,
}

impl WrenchSample {
    /// The wrench in object axes about the object's origin (equation 13 of the paper).
    pub fn on_object(&self) -> [f64; 3] {
        planar_transform(&self.frame, &self.reading)
    }
}

/// A pose sample of an episode.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseSample {
    /// Time on the tracker's clock, s.
    pub t: f64,
    /// Pose of the object frame in the world: x, y in m, continuous theta in rad.
    pub pose: [f64; 3],
}
