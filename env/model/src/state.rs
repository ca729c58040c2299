//! How an object moves at one instant.

use crate::Real;
use crate::law::MAX_INNER_STATES;

/// Motion state of the object frame's origin: pose `[m, m, rad]` and twist `[m/s, m/s, rad/s]`, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<T> {
    /// Pose of the object frame in the world.
    pub pose: [T; 3],
    /// Velocity of its origin, and spin.
    pub twist: [T; 3],
    /// States of the laws' own, in the model's order, then zeros.
    pub inner: [T; MAX_INNER_STATES],
}

impl<T: Real> State<T> {
    /// At rest at a pose.
    pub fn at_rest(pose: [f64; 3]) -> Self {
        Self::moving(pose.map(T::lift), [T::zero(); 3])
    }

    /// In motion, the laws' own states at zero.
    pub fn moving(pose: [T; 3], twist: [T; 3]) -> Self {
        Self { pose, twist, inner: [T::zero(); MAX_INNER_STATES] }
    }

    /// Whether all values are finite.
    pub fn is_finite(&self) -> bool {
        self.pose.iter().chain(&self.twist).chain(&self.inner).all(|value| value.re().is_finite())
    }

    /// The same with the laws' own states given.
    #[must_use]
    pub fn with_inner(self, inner: [f64; MAX_INNER_STATES]) -> Self {
        Self { inner: inner.map(T::lift), ..self }
    }
}
