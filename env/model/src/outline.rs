//! Distance between a point and a body's shape.

use crate::{Body, Fixture};
use std::f64::consts::TAU;

impl Body {
    /// Distance from a point, object frame, m, to the shape, and its gradient by the point's coordinates. Both are zero
    /// inside and for a body without a shape.
    pub fn outside(&self, point: [f64; 2]) -> (f64, [f64; 2]) {
        let near = self.fixtures.iter().map(|f| f.outside(point));
        near.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, [0.0; 2]))
    }

    /// The same body with the convex hull of its shape. The mass centre of any load on the body lies in this hull.
    #[must_use]
    pub fn with_convex_hull(&self) -> Self {
        let mut points: Vec<[f64; 2]> = self.fixtures.iter().flat_map(Fixture::hull_points).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let mut vertices = half_hull(points.iter().copied());
        vertices.extend(half_hull(points.iter().rev().copied()));
        let hull = Fixture::Polygon { vertices, density: 1.0 };
        Self { fixtures: if points.is_empty() { vec![] } else { vec![hull] }, ..self.clone() }
    }
}

/// Number of corners that approximate a disc in a hull.
const DISC_CORNERS: usize = 64;

/// Half of the convex hull of points sorted by a coordinate, without its last corner (Andrew 1979).
fn half_hull(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = vec![];
    for point in points {
        while let [.., a, b] = kept[..] {
            let turn = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]);
            if turn > 0.0 {
                break;
            }
            kept.pop();
        }
        kept.push(point);
    }
    kept.pop();
    kept
}

impl Fixture {
    /// Points whose convex hull is that of the fixture.
    fn hull_points(&self) -> Vec<[f64; 2]> {
        match self {
            Self::Polygon { vertices, .. } => vertices.clone(),
            Self::Disc { center: [x, y], radius, .. } => {
                let at = |k: usize| (TAU * k as f64 / DISC_CORNERS as f64).sin_cos();
                (0..DISC_CORNERS).map(at).map(|(sin, cos)| [x + radius * cos, y + radius * sin]).collect()
            }
        }
    }

    fn outside(&self, point: [f64; 2]) -> (f64, [f64; 2]) {
        match self {
            Self::Disc { center, radius, .. } => {
                let (distance, slopes) = distance_between(point, *center);
                if distance > *radius { (distance - radius, slopes) } else { (0.0, [0.0; 2]) }
            }
            Self::Polygon { vertices, .. } if contains(vertices, point) => (0.0, [0.0; 2]),
            Self::Polygon { vertices, .. } => edges(vertices)
                .map(|(a, b)| distance_between(point, nearest_on_segment(a, b, point)))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap_or((0.0, [0.0; 2])),
        }
    }

    /// Depth of a point inside the fixture, m; outside, the negative distance.
    pub(crate) fn depth(&self, [x, y]: [f64; 2]) -> f64 {
        match self {
            Self::Disc { center, radius, .. } => radius - (x - center[0]).hypot(y - center[1]),
            Self::Polygon { vertices, .. } => {
                let far = edges(vertices)
                    .map(|(a, b)| distance_between([x, y], nearest_on_segment(a, b, [x, y])).0);
                let far = far.fold(f64::INFINITY, f64::min);
                if contains(vertices, [x, y]) { far } else { -far }
            }
        }
    }
}

fn edges(vertices: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    vertices.iter().copied().zip(vertices.iter().copied().cycle().skip(1))
}

/// Whether a point lies inside a simple polygon (ray casting).
fn contains(vertices: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let crossed = |&([ax, ay], [bx, by]): &([f64; 2], [f64; 2])| {
        (ay > y) != (by > y) && x < (bx - ax) * (y - ay) / (by - ay) + ax
    };
    edges(vertices).filter(crossed).count() % 2 == 1
}

/// Point of a segment closest to a point.
fn nearest_on_segment([ax, ay]: [f64; 2], [bx, by]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    let (dx, dy) = (bx - ax, by - ay);
    let length = dx * dx + dy * dy;
    let along = if length > 0.0 { ((x - ax) * dx + (y - ay) * dy) / length } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    [ax + along * dx, ay + along * dy]
}

/// Distance of two points and its gradient by the first.
fn distance_between([x, y]: [f64; 2], [ax, ay]: [f64; 2]) -> (f64, [f64; 2]) {
    let (dx, dy) = (x - ax, y - ay);
    let distance = (dx * dx + dy * dy).sqrt();
    if distance > 0.0 { (distance, [dx / distance, dy / distance]) } else { (0.0, [0.0; 2]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_an_l_and_a_disc_are_exact() {
        let l = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let l = Fixture::Polygon { vertices: l, density: 1.0 };
        let disc = Fixture::Disc { center: [5.0, 0.0], radius: 1.0, density: 1.0 };
        let body = Body::from_fixtures(vec![l, disc], 1.0).unwrap();
        for (point, distance, slopes) in [
            ([0.5, 1.5], 0.0, [0.0, 0.0]),
            ([5.5, 0.5], 0.0, [0.0, 0.0]),
            ([1.2, 1.7], 0.2, [1.0, 0.0]),
            ([1.7, 1.2], 0.2, [0.0, 1.0]),
            ([-3.0, -4.0], 5.0, [-0.6, -0.8]),
            ([5.0, 3.0], 2.0, [0.0, 1.0]),
        ] {
            let found = body.outside(point);
            assert!((found.0 - distance).abs() < 1e-12, "{point:?}: {found:?}");
            assert!(found.1.iter().zip(slopes).all(|(a, b)| (a - b).abs() < 1e-12), "{point:?}: {found:?}");
        }
    }

    #[test]
    fn the_hull_of_an_l_contains_its_notch() {
        let l = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let disc = Fixture::Disc { center: [0.0, 0.0], radius: 1.0, density: 1.0 };
        let l = Fixture::Polygon { vertices: l, density: 1.0 };
        let hull = Body::from_fixtures(vec![l, disc], 1.0).unwrap().with_convex_hull();
        assert_eq!(hull.outside([1.4, 1.4]).0, 0.0);
        assert!((hull.outside([2.0, 2.0]).0 - 0.5f64.sqrt()).abs() < 1e-12);
        assert!((hull.outside([-2.0, 0.0]).0 - 1.0).abs() < 2e-3, "the hull of a disc is nearly round");
    }
}
