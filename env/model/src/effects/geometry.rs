//! Geometry shared by the laws of floor and obstacles: transformations between body and world, and support points.

use crate::law::{LawContext, Param, Prior, Role};
use crate::{Body, Fixture, Real};

/// Coordinate of a world point along `axis` (0: x, 1: y). The prior covers an area around the world origin.
pub(super) const fn in_world(name: &'static str, axis: usize, help: &'static str) -> Param {
    let param = super::signed(name, "m", 100.0, 2.0, help);
    let role = Role::WorldPoint(axis);
    Param { prior: Prior::Normal { mean: 0.0, sd: 2.0 }, on_rail: axis == 0, role, ..param }
}

impl<T: Real> LawContext<'_, T> {
    /// Transform a point from the object frame to the world, m.
    #[inline]
    pub(crate) fn in_world(&self, point: [T; 2]) -> [T; 2] {
        let [x, y] = self.world_axes(point);
        [self.position[0] + x, self.position[1] + y]
    }

    /// [`LawContext::in_world`] without derivatives.
    #[inline]
    pub(crate) fn in_world_value(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = (self.heading.0.re(), self.heading.1.re());
        [self.position[0].re() + cos * x - sin * y, self.position[1].re() + sin * x + cos * y]
    }

    /// Transform a point from the world to the object frame, m.
    #[inline]
    pub(crate) fn in_object(&self, [x, y]: [T; 2]) -> [T; 2] {
        self.object_axes([x - self.position[0], y - self.position[1]])
    }

    /// Rotate a vector from object axes to world axes.
    #[inline]
    pub(crate) fn world_axes(&self, [x, y]: [T; 2]) -> [T; 2] {
        let (sin, cos) = self.heading;
        [cos * x - sin * y, sin * x + cos * y]
    }

    /// Rotate a vector from world axes to object axes.
    #[inline]
    pub(crate) fn object_axes(&self, [x, y]: [T; 2]) -> [T; 2] {
        let (sin, cos) = self.heading;
        [cos * x + sin * y, cos * y - sin * x]
    }
}

/// Softplus function `w ln(1 + exp(x/w))`, a smooth positive part of width `w`, and its derivative.
#[inline]
pub(super) fn softplus<T: Real>(x: T, width: f64) -> (T, T) {
    let u = x.re() / width;
    let tail = (-u.abs()).exp();
    let value = u.max(0.0) + tail.ln_1p();
    let slope = if u > 0.0 { 1.0 / (1.0 + tail) } else { tail / (1.0 + tail) };
    let bend = slope * (1.0 - slope) / width;
    (T::chained(value * width, [(x, slope)]), T::chained(slope, [(x, bend)]))
}

/// Support points of a body on the floor, object frame, m: its feet, or its corners if it has none. A disc has four
/// corners; a body without a shape is supported at its origin.
pub(super) fn support_points(body: &Body) -> Vec<[f64; 2]> {
    if let Some(feet) = &body.feet {
        return feet.clone();
    }
    let mut found: Vec<[f64; 2]> = vec![];
    for (index, fixture) in body.fixtures.iter().enumerate() {
        let others = || body.fixtures.iter().enumerate().filter(|(k, _)| *k != index);
        for point in outline_points(fixture) {
            let hidden = others().any(|(_, other)| other.depth(point) > SAME_POINT_M);
            let known = found.iter().any(|[x, y]| (x - point[0]).hypot(y - point[1]) < SAME_POINT_M);
            if !hidden && !known {
                found.push(point);
            }
        }
    }
    if found.is_empty() { vec![[0.0; 2]] } else { found }
}

/// Distance below which two points are identical, m.
const SAME_POINT_M: f64 = 1e-6;

fn outline_points(fixture: &Fixture) -> Vec<[f64; 2]> {
    match fixture {
        Fixture::Polygon { vertices, .. } => vertices.clone(),
        Fixture::Disc { center: [x, y], radius: r, .. } => {
            vec![[x + r, *y], [*x, y + r], [x - r, *y], [*x, y - r]]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_rectangles_of_an_l_have_the_corners_of_the_l() {
        let rectangle = |[x, y]: [f64; 2], [w, h]: [f64; 2]| Fixture::Polygon {
            vertices: vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]],
            density: 1.0,
        };
        // The rectangles overlap, so that two corners of the second are not corners of the L.
        let l = vec![rectangle([0.0, 0.0], [1.0, 2.0]), rectangle([0.5, 0.5], [1.5, 1.0])];
        let body = Body::from_fixtures(l, 1.0).unwrap();
        let expected = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0], [2.0, 0.5], [2.0, 1.5]];
        assert_eq!(support_points(&body), expected);
        let feet = [[0.1, 0.1], [0.9, 0.1]];
        assert_eq!(support_points(&body.with_feet(&feet)), feet);
    }

    #[test]
    fn softplus_is_smooth_at_zero_only() {
        for (x, value, slope) in [(-1.0, 0.0, 0.0), (0.0, 1e-3 * 2f64.ln(), 0.5), (1.0, 1.0, 1.0)] {
            let found = softplus(x, 1e-3);
            assert!((found.0 - value).abs() < 1e-15 && (found.1 - slope).abs() < 1e-15, "{x}: {found:?}");
        }
    }
}
