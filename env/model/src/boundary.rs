//! Outer boundary of a body's shape: the edges, corners and discs that a round obstacle can touch.

use crate::{Body, Fixture};

/// A piece of the boundary: flat, or round about a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Piece {
    /// An edge: a point on it, and its outward normal.
    Flat { point: [f64; 2], normal: [f64; 2] },
    /// A corner (radius 0) or a disc.
    Round { center: [f64; 2], radius: f64 },
}

impl Piece {
    /// Signed distance from a point to the piece, negative inside, m.
    pub fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        match self {
            Self::Flat { point, normal } => (x - point[0]) * normal[0] + (y - point[1]) * normal[1],
            Self::Round { center, radius } => (x - center[0]).hypot(y - center[1]) - radius,
        }
    }
}

/// Outer boundary of a body: edges, convex corners and discs of its fixtures.
#[derive(Clone, Debug)]
pub(crate) struct Boundary {
    fixtures: Vec<Fixture>,
    edges: Vec<Edge>,
    corners: Vec<Corner>,
    /// Centre of the bounding box and its half diagonal, m.
    middle: [f64; 2],
    reach: f64,
}

#[derive(Clone, Debug)]
struct Edge {
    of: usize,
    from: [f64; 2],
    along: [f64; 2],
    normal: [f64; 2],
    length: f64,
}

/// A convex corner with the directions of its two edges.
#[derive(Clone, Debug)]
struct Corner {
    at: [f64; 2],
    along: [[f64; 2]; 2],
}

/// A boundary point is exposed if no other fixture covers the point this far outside of it, m.
const OFFSET_M: f64 = 1e-7;

impl Boundary {
    pub fn new(body: &Body) -> Self {
        let [low, high] = body.bounds();
        let middle = [0, 1].map(|k| (low[k] + high[k]) / 2.0);
        let reach = (high[0] - low[0]).hypot(high[1] - low[1]) / 2.0;
        let mut boundary =
            Self { fixtures: body.fixtures.clone(), edges: vec![], corners: vec![], middle, reach };
        for (of, fixture) in body.fixtures.iter().enumerate() {
            let Fixture::Polygon { vertices, .. } = fixture else { continue };
            let edges = edges(of, vertices);
            for (edge, next) in edges.iter().zip(edges.iter().cycle().skip(1)) {
                if cross(edge.along, next.along) > 0.0 && !boundary.covered(next.from, of, -OFFSET_M) {
                    boundary.corners.push(Corner { at: next.from, along: [edge.along, next.along] });
                }
            }
            boundary.edges.extend(edges);
        }
        boundary
    }

    /// Visit the pieces near a point, object frame, m.
    ///
    /// For a point outside, these are all pieces closer than `within`: usually one, two in a notch. For a point inside,
    /// it is the piece with the smallest depth.
    pub fn pieces_near(&self, point: [f64; 2], within: f64, mut visit: impl FnMut(Piece)) {
        let off = (point[0] - self.middle[0]).hypot(point[1] - self.middle[1]);
        if off - self.reach > within {
            return;
        }
        if self.fixtures.iter().all(|f| f.depth(point) <= 0.0) {
            self.outside(point).filter(|piece| piece.distance(point) < within).for_each(visit);
        } else if let Some(nearest) =
            self.inside(point).max_by(|a, b| a.distance(point).total_cmp(&b.distance(point)))
        {
            visit(nearest);
        }
    }

    fn outside(&self, p: [f64; 2]) -> impl Iterator<Item = Piece> + '_ {
        let flat = self.facing(p).filter(move |piece| piece.distance(p) >= 0.0);
        let corners = self.corners.iter().filter(move |corner| {
            let arm = difference(p, corner.at);
            dot(arm, corner.along[0]) >= 0.0 && dot(arm, corner.along[1]) < 0.0
        });
        let corners = corners.map(|corner| Piece::Round { center: corner.at, radius: 0.0 });
        flat.chain(corners).chain(self.discs(p))
    }

    fn inside(&self, p: [f64; 2]) -> impl Iterator<Item = Piece> + '_ {
        let behind = move |piece: &Piece| piece.distance(p) <= 0.0;
        self.facing(p).chain(self.discs(p)).filter(behind)
    }

    /// Exposed edges onto which the point projects.
    fn facing(&self, p: [f64; 2]) -> impl Iterator<Item = Piece> + '_ {
        self.edges.iter().filter_map(move |edge| {
            let along = dot(difference(p, edge.from), edge.along);
            let out = [0, 1].map(|k| edge.from[k] + edge.along[k] * along + edge.normal[k] * OFFSET_M);
            let seen = (0.0..edge.length).contains(&along) && !self.covered(out, edge.of, 0.0);
            seen.then_some(Piece::Flat { point: edge.from, normal: edge.normal })
        })
    }

    fn discs(&self, p: [f64; 2]) -> impl Iterator<Item = Piece> + '_ {
        self.fixtures.iter().enumerate().filter_map(move |(of, fixture)| {
            let Fixture::Disc { center, radius, .. } = fixture else { return None };
            let arm = difference(p, *center);
            let share = (radius + OFFSET_M) / dot(arm, arm).sqrt().max(1e-12);
            let out = [0, 1].map(|k| center[k] + arm[k] * share);
            (!self.covered(out, of, 0.0)).then_some(Piece::Round { center: *center, radius: *radius })
        })
    }

    /// Whether a point lies deeper than `depth` inside a fixture other than `of`.
    fn covered(&self, point: [f64; 2], of: usize, depth: f64) -> bool {
        self.fixtures.iter().enumerate().any(|(k, other)| k != of && other.depth(point) > depth)
    }
}

/// Edges of a polygon in counter-clockwise order.
fn edges(of: usize, vertices: &[[f64; 2]]) -> Vec<Edge> {
    let mut corners = vertices.to_vec();
    let twice: f64 = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(&a, &b)| cross(a, b)).sum();
    if twice < 0.0 {
        corners.reverse();
    }
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    let edge = |(&from, &to): (&[f64; 2], &[f64; 2])| {
        let side = difference(to, from);
        let length = dot(side, side).sqrt();
        let along = side.map(|s| s / length);
        (length > 0.0).then_some(Edge { of, from, along, normal: [along[1], -along[0]], length })
    };
    pairs.filter_map(edge).collect()
}

fn difference(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle([x, y]: [f64; 2], [w, h]: [f64; 2]) -> Fixture {
        Fixture::Polygon { vertices: vec![[x, y], [x, y + h], [x + w, y + h], [x + w, y]], density: 1.0 }
    }

    fn distances(boundary: &Boundary, point: [f64; 2]) -> Vec<f64> {
        let mut found = vec![];
        boundary.pieces_near(point, 0.3, |piece| found.push(piece.distance(point)));
        found
    }

    #[test]
    fn two_rectangles_in_an_l_have_one_common_boundary() {
        let l = vec![rectangle([0.0, 0.0], [2.0, 1.0]), rectangle([0.0, 1.0], [1.0, 1.0])];
        let boundary = Boundary::new(&Body::from_fixtures(l, 1.0).unwrap());
        for (point, expected) in [
            (vec![1.5, 1.2], vec![0.2]),
            // On the straight side where the two meet: one piece, not two.
            (vec![-0.2, 1.0], vec![0.2]),
            // In the notch: both sides.
            (vec![1.1, 1.2], vec![0.2, 0.1]),
            // At a convex corner, and out of range.
            (vec![2.03, -0.04], vec![0.05]),
            (vec![2.5, 1.5], vec![]),
            // Inside, near a side; the seam between the rectangles is not a boundary.
            (vec![0.1, 1.02], vec![-0.1]),
            (vec![0.1, 0.98], vec![-0.1]),
        ] {
            let mut found = distances(&boundary, [point[0], point[1]]);
            found.sort_by(|a, b| b.total_cmp(a));
            assert_eq!(found.len(), expected.len(), "{point:?}: {found:?}");
            assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12), "{point:?}: {found:?}");
        }
    }

    #[test]
    fn a_disc_is_round() {
        let disc = Fixture::Disc { center: [1.0, 0.0], radius: 0.5, density: 1.0 };
        let boundary = Boundary::new(&Body::from_fixtures(vec![disc], 1.0).unwrap());
        assert!((distances(&boundary, [1.0, 0.6])[0] - 0.1).abs() < 1e-12);
        assert!((distances(&boundary, [1.0, 0.4])[0] + 0.1).abs() < 1e-12);
    }
}
