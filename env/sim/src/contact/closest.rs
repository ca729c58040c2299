//! Closest points of convex shapes, with the contact normal.

use super::shape::Polygon;
use super::vector::{Vec2, add, dot, scale, sub};

/// Closest points of two shapes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closest {
    /// Unit normal from the first shape to the second.
    pub normal: Vec2,
    pub first: Vec2,
    pub second: Vec2,
}

/// Closest points of two polygons, or the points of least penetration; `None` if they are at least `limit` apart, m.
pub(super) fn polygons(first: &Polygon, second: &Polygon, limit: f64) -> Option<Closest> {
    let (one, edge1) = first.separation(second);
    if one >= limit {
        return None;
    }
    let (two, edge2) = second.separation(first);
    if two >= limit {
        return None;
    }
    if one.max(two) <= 0.0 {
        return Some(if one >= two {
            let normal = first.normals[edge1];
            let point = nearest_corner(second, normal);
            Closest { normal, first: sub(point, scale(normal, one)), second: point }
        } else {
            let normal = second.normals[edge2];
            let point = nearest_corner(first, normal);
            Closest { normal: scale(normal, -1.0), first: point, second: sub(point, scale(normal, two)) }
        });
    }
    let mut best = (f64::INFINITY, None);
    for &corner in &second.points {
        nearest_on_edges(first, corner, &mut best, |normal, on_edge| Closest {
            normal,
            first: on_edge,
            second: corner,
        });
    }
    for &corner in &first.points {
        nearest_on_edges(second, corner, &mut best, |normal, on_edge| Closest {
            normal: scale(normal, -1.0),
            first: corner,
            second: on_edge,
        });
    }
    best.1.filter(|_| best.0 < limit * limit)
}

/// Closest points of a disc around `center` and a polygon; `None` if they are at least `limit` apart, m.
pub(super) fn disc(center: Vec2, radius: f64, polygon: &Polygon, limit: f64) -> Option<Closest> {
    let (outside, edge) = polygon.outside(center);
    if outside - radius >= limit {
        return None;
    }
    let (towards, on_polygon) = if outside <= 0.0 {
        let normal = polygon.normals[edge];
        (normal, sub(center, scale(normal, outside)))
    } else {
        let mut best = (f64::INFINITY, None);
        nearest_on_edges(polygon, center, &mut best, |normal, on_edge| (normal, on_edge));
        if best.0.sqrt() - radius >= limit {
            return None;
        }
        best.1?
    };
    let normal = scale(towards, -1.0);
    Some(Closest { normal, first: add(center, scale(normal, radius)), second: on_polygon })
}

/// The first corner of a polygon that is farthest against a direction.
fn nearest_corner(polygon: &Polygon, direction: Vec2) -> Vec2 {
    let mut best = (f64::INFINITY, [0.0; 2]);
    for &point in &polygon.points {
        let along = dot(direction, point);
        if along < best.0 {
            best = (along, point);
        }
    }
    best.1
}

/// Update `best`, a squared distance and its result, with the point of the polygon's outline that is closest to a point
/// outside. `result` receives the unit normal from the outline to the point, and the closest point.
fn nearest_on_edges<T>(
    polygon: &Polygon,
    point: Vec2,
    best: &mut (f64, Option<T>),
    result: impl Fn(Vec2, Vec2) -> T,
) {
    for (edge, &normal) in polygon.normals.iter().enumerate() {
        let [start, end] = polygon.edge(edge);
        let from = sub(point, start);
        let height = dot(normal, from);
        // A point behind an edge is closer to another one.
        if height < 0.0 || height * height >= best.0 {
            continue;
        }
        let along = sub(end, start);
        let (share, square) = (dot(along, from), dot(along, along));
        if share > 0.0 && share < square {
            *best = (height * height, Some(result(normal, sub(point, scale(normal, height)))));
            continue;
        }
        let corner = if share <= 0.0 { start } else { end };
        let apart = sub(point, corner);
        let distance = dot(apart, apart);
        if distance < best.0 {
            let normal = if distance > 0.0 { scale(apart, distance.sqrt().recip()) } else { normal };
            *best = (distance, Some(result(normal, corner)));
        }
    }
}
