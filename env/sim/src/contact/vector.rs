//! Vectors in the plane.

pub(super) type Vec2 = [f64; 2];

#[inline(always)]
pub(super) fn add([ax, ay]: Vec2, [bx, by]: Vec2) -> Vec2 {
    [ax + bx, ay + by]
}

#[inline(always)]
pub(super) fn sub([ax, ay]: Vec2, [bx, by]: Vec2) -> Vec2 {
    [ax - bx, ay - by]
}

#[inline(always)]
pub(super) fn scale([x, y]: Vec2, factor: f64) -> Vec2 {
    [x * factor, y * factor]
}

#[inline(always)]
pub(super) fn dot([ax, ay]: Vec2, [bx, by]: Vec2) -> f64 {
    ax * bx + ay * by
}

#[inline(always)]
pub(super) fn cross([ax, ay]: Vec2, [bx, by]: Vec2) -> f64 {
    ax * by - ay * bx
}

/// The vector turned by a quarter turn, counterclockwise.
#[inline(always)]
pub(super) fn perpendicular([x, y]: Vec2) -> Vec2 {
    [-y, x]
}

/// Largest angle, rad, and its tangent, for which the truncation errors of the series here are below rounding.
const MAX_SERIES_ANGLE_RAD: f64 = 0.02;

/// The angle with a tangent, rad.
#[inline(always)]
pub(super) fn angle_of_tangent(tangent: f64) -> f64 {
    if tangent.abs() > MAX_SERIES_ANGLE_RAD {
        return tangent.atan();
    }
    let x = tangent * tangent;
    tangent * (1.0 - x * (1.0 / 3.0 - x * (1.0 / 5.0 - x * (1.0 / 7.0 - x / 9.0))))
}

/// A pose in the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub origin: Vec2,
    /// Cosine and sine of the heading.
    pub rotation: Vec2,
}

impl Frame {
    pub fn new([x, y, heading]: [f64; 3]) -> Self {
        let (sin, cos) = heading.sin_cos();
        Self { origin: [x, y], rotation: [cos, sin] }
    }

    /// The frame turned by an angle, rad; faster than [`Frame::new`] if the angle is small.
    #[inline(always)]
    pub fn turned(self, by: f64) -> Self {
        let (sin, cos) = if by.abs() > MAX_SERIES_ANGLE_RAD {
            by.sin_cos()
        } else {
            let x = by * by;
            let sin = by * (1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0)));
            (sin, 1.0 - x / 2.0 * (1.0 - x / 12.0 * (1.0 - x / 30.0 * (1.0 - x / 56.0))))
        };
        let [own_cos, own_sin] = self.rotation;
        Self { rotation: [own_cos * cos - own_sin * sin, own_sin * cos + own_cos * sin], ..self }
    }

    #[inline(always)]
    pub fn rotate(&self, [x, y]: Vec2) -> Vec2 {
        let [cos, sin] = self.rotation;
        [cos * x - sin * y, sin * x + cos * y]
    }

    #[inline(always)]
    pub fn rotate_back(&self, [x, y]: Vec2) -> Vec2 {
        let [cos, sin] = self.rotation;
        [cos * x + sin * y, cos * y - sin * x]
    }

    #[inline(always)]
    pub fn to_world(self, point: Vec2) -> Vec2 {
        add(self.origin, self.rotate(point))
    }

    #[inline(always)]
    pub fn to_local(self, point: Vec2) -> Vec2 {
        self.rotate_back(sub(point, self.origin))
    }
}
