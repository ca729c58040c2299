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
