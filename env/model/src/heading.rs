//! An angle of the object, and what it turns.
//!
//! A rotation's derivative is `d(Rv) = R dv + J R v dθ`: with sine and cosine as plain numbers it takes
//! a third less arithmetic than with sine and cosine that carry derivatives themselves.

use crate::Real;

/// An angle with its sine and cosine.
#[derive(Clone, Copy)]
pub(crate) struct Heading<T> {
    angle: T,
    sin: f64,
    cos: f64,
}

impl<T: Real> Heading<T> {
    #[inline(always)]
    pub fn of(angle: T) -> Self {
        let (sin, cos) = angle.re().sin_cos();
        Self { angle, sin, cos }
    }

    /// Sine and cosine with their derivatives.
    #[inline(always)]
    pub fn sin_cos(self) -> (T, T) {
        let Self { angle, sin, cos } = self;
        (T::chained(sin, [(angle, cos)]), T::chained(cos, [(angle, -sin)]))
    }

    /// A vector `[x, y, about z]` of the body, in world axes.
    #[inline(always)]
    pub fn to_world(self, [x, y, z]: [T; 3]) -> [T; 3] {
        let Self { angle, sin, cos } = self;
        let (wx, wy) = (cos * x.re() - sin * y.re(), sin * x.re() + cos * y.re());
        let along_x = T::chained(wx, [(x, cos), (y, -sin), (angle, -wy)]);
        let along_y = T::chained(wy, [(x, sin), (y, cos), (angle, wx)]);
        [along_x, along_y, z]
    }

    /// A vector `[x, y, about z]` in world axes, in those of the body.
    #[inline(always)]
    pub fn to_body(self, [x, y, z]: [T; 3]) -> [T; 3] {
        let Self { angle, sin, cos } = self;
        let (bx, by) = (cos * x.re() + sin * y.re(), cos * y.re() - sin * x.re());
        let along_x = T::chained(bx, [(x, cos), (y, sin), (angle, by)]);
        let along_y = T::chained(by, [(x, -sin), (y, cos), (angle, -bx)]);
        [along_x, along_y, z]
    }

    /// A point that the body carries, from its origin, world axes, m.
    #[inline(always)]
    pub fn place(self, [x, y]: [f64; 2]) -> [T; 2] {
        let Self { angle, sin, cos } = self;
        let (wx, wy) = (cos * x - sin * y, sin * x + cos * y);
        [T::chained(wx, [(angle, -wy)]), T::chained(wy, [(angle, wx)])]
    }
}
