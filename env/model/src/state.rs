//! Motion state of an object.

use crate::Real;
use crate::law::MAX_INNER_STATES;

/// Motion state of the object frame's origin: pose `[m, m, rad]` and twist `[m/s, m/s, rad/s]`, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<T> {
    /// Pose of the object frame in the world.
    pub pose: [T; 3],
    /// Velocity of the object origin, and spin.
    pub twist: [T; 3],
    /// Inner states of the laws, in the model's order, padded with zeros.
    pub inner: [T; MAX_INNER_STATES],
}

impl<T: Real> State<T> {
    /// State at rest.
    pub fn at_rest(pose: [f64; 3]) -> Self {
        Self::moving(pose.map(T::lift), [T::zero(); 3])
    }

    /// State in motion, with inner states of zero.
    pub fn moving(pose: [T; 3], twist: [T; 3]) -> Self {
        Self { pose, twist, inner: [T::zero(); MAX_INNER_STATES] }
    }

    /// Whether all values are finite.
    pub fn is_finite(&self) -> bool {
        self.pose.iter().chain(&self.twist).chain(&self.inner).all(|value| value.re().is_finite())
    }

    /// Copy with the given inner states.
    #[must_use]
    pub fn with_inner(self, inner: [f64; MAX_INNER_STATES]) -> Self {
        Self { inner: inner.map(T::lift), ..self }
    }
}
