//! Motion of the object in one simulation step, computed by another simulator.

/// Motion of the object in one simulation step, computed by another simulator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExternalStep {
    /// Pose of the object after the step, world frame `[m, m, rad]`.
    pub pose: [f64; 3],
    /// Twist of the object's origin after the step, world frame `[m/s, m/s, rad/s]`.
    pub twist: [f64; 3],
    /// Mean wrench of the gripper on the object during the step, object axes about the object origin `[N, N, N·m]`.
    pub wrench: [f64; 3],
    /// Impulse of obstacles on the object during the step, N·s.
    pub impulse: f64,
}

impl ExternalStep {
    pub(super) fn is_finite(&self) -> bool {
        let motion = self.pose.iter().chain(&self.twist).chain(&self.wrench);
        motion.chain([&self.impulse]).all(|value| value.is_finite())
    }
}
