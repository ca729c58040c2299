//! The heading of the object and rotations by it.
//!
//! The derivative of a rotation is `d(Rv) = R dv + J R v dθ`. With sine and cosine in `f64` it takes a third less
//! arithmetic than with sine and cosine that carry derivatives.

use crate::Real;

/// An angle with its sine and cosine.
#[derive(Clone, Copy)]
pub(crate) struct Heading<T> {
    angle: T,
    sin: f64,
    cos: f64,
}

/// Largest angle, rad, for which the truncation error of the series in [`Heading::rotated_to`] is below rounding.
const MAX_SERIES_ANGLE_RAD: f64 = 0.04;

impl<T: Real> Heading<T> {
    #[inline(always)]
    pub fn of(angle: T) -> Self {
        let (sin, cos) = angle.re().sin_cos();
        Self { angle, sin, cos }
    }

    pub fn angle(self) -> T {
        self.angle
    }

    /// Heading at another angle; faster than [`Heading::of`] if the angle is close.
    #[inline(always)]
    pub fn rotated_to(self, angle: T) -> Self {
        let by = angle.re() - self.angle.re();
        if by.abs() > MAX_SERIES_ANGLE_RAD {
            return Self::of(angle);
        }
        let x = by * by;
        let sin = by * (1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0)));
        let cos = 1.0 - x / 2.0 * (1.0 - x / 12.0 * (1.0 - x / 30.0 * (1.0 - x / 56.0)));
        Self { angle, sin: self.sin * cos + self.cos * sin, cos: self.cos * cos - self.sin * sin }
    }

    /// Sine and cosine with their derivatives.
    #[inline(always)]
    pub fn sin_cos(self) -> (T, T) {
        let Self { angle, sin, cos } = self;
        (T::chained(sin, [(angle, cos)]), T::chained(cos, [(angle, -sin)]))
    }

    /// Rotate a vector `[x, y, about z]` from object axes to world axes.
    #[inline(always)]
    pub fn to_world(self, [x, y, z]: [T; 3]) -> [T; 3] {
        let Self { angle, sin, cos } = self;
        let (wx, wy) = (cos * x.re() - sin * y.re(), sin * x.re() + cos * y.re());
        let along_x = T::chained(wx, [(x, cos), (y, -sin), (angle, -wy)]);
        let along_y = T::chained(wy, [(x, sin), (y, cos), (angle, wx)]);
        [along_x, along_y, z]
    }

    /// Rotate a vector `[x, y, about z]` from world axes to object axes.
    #[inline(always)]
    pub fn to_body(self, [x, y, z]: [T; 3]) -> [T; 3] {
        let Self { angle, sin, cos } = self;
        let (bx, by) = (cos * x.re() + sin * y.re(), cos * y.re() - sin * x.re());
        let along_x = T::chained(bx, [(x, cos), (y, sin), (angle, by)]);
        let along_y = T::chained(by, [(x, -sin), (y, cos), (angle, -bx)]);
        [along_x, along_y, z]
    }

    /// Offset of a body point from the object origin, world axes, m.
    #[inline(always)]
    pub fn rotate_point(self, [x, y]: [f64; 2]) -> [T; 2] {
        let Self { angle, sin, cos } = self;
        let (wx, wy) = (cos * x - sin * y, sin * x + cos * y);
        [T::chained(wx, [(angle, -wy)]), T::chained(wy, [(angle, wx)])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_agree_with_sine_and_cosine() {
        for (from, by) in [(0.3, 0.04), (-2.0, -0.0399), (40.0, 1e-9), (1.0, 0.0), (1.0, 0.5)] {
            let (near, whole) = (Heading::of(from).rotated_to(from + by), Heading::of(from + by));
            assert!(
                (near.sin - whole.sin).abs() < 4e-16 && (near.cos - whole.cos).abs() < 4e-16,
                "{from} {by}"
            );
        }
    }
}
