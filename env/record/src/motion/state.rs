//! Estimated motion of an object.

/// Estimated motion of the object at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Time, s.
    pub t: f64,
    /// x, y in m and theta in rad of the object frame in the world.
    pub pose: [f64; 3],
    /// Velocity of the origin of the object frame in world axes, m/s, and the angular velocity, rad/s.
    pub twist: [f64; 3],
    /// Time derivative of `twist`, m/s² and rad/s².
    pub accel: [f64; 3],
    /// Covariance of (pose, velocity, acceleration) for each axis (x, y, theta).
    pub cov: [[[f64; 3]; 3]; 3],
}
