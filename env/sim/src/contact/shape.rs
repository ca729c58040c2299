//! Convex pieces of the object and of obstacles.

use rapier2d_f64::prelude::Collider;

use super::vector::{Frame, Vec2, add, dot, scale, sub};
use crate::SimError;

/// A convex piece with its bounding circle, m.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub outline: Outline,
    pub center: Vec2,
    pub radius: f64,
}

#[derive(Clone, Debug)]
pub(super) enum Outline {
    Polygon(Polygon),
    Disc,
}

/// A convex polygon, counterclockwise.
#[derive(Clone, Debug, Default)]
pub(super) struct Polygon {
    pub points: Vec<Vec2>,
    /// Outward unit normals; entry k belongs to the edge from point k to the next one.
    pub normals: Vec<Vec2>,
}

impl Piece {
    /// The shape of an engine collider, in the frame of the collider's parent.
    ///
    /// # Errors
    /// If the collider is neither a convex polygon nor a disc.
    pub fn of(collider: &Collider) -> Result<Self, SimError> {
        let pose = collider.position();
        let (rotation, origin) = (pose.rotation, [pose.translation.x, pose.translation.y]);
        let turned = |[x, y]: Vec2| [rotation.re * x - rotation.im * y, rotation.im * x + rotation.re * y];
        if let Some(ball) = collider.shape().as_ball() {
            return Ok(Self { outline: Outline::Disc, center: origin, radius: ball.radius });
        }
        let Some(polygon) = collider.shape().as_convex_polygon() else {
            return Err(SimError::Shape { what: "contact".to_owned() });
        };
        let points: Vec<Vec2> = polygon.points().iter().map(|p| add(origin, turned([p.x, p.y]))).collect();
        let normals = polygon.normals().iter().map(|n| turned([n.x, n.y])).collect();
        let sum = points.iter().fold([0.0; 2], |sum, &point| add(sum, point));
        let center = scale(sum, 1.0 / points.len().max(1) as f64);
        let distances = points.iter().map(|&point| sub(point, center)).map(|[x, y]| x.hypot(y));
        let radius = distances.fold(0.0, f64::max);
        Ok(Self { outline: Outline::Polygon(Polygon { points, normals }), center, radius })
    }

    /// Write the outline in world axes, with the piece's parent at `frame`.
    pub fn place(&self, frame: &Frame, outline: &mut Polygon) {
        let Outline::Polygon(polygon) = &self.outline else { return };
        for (to, &point) in outline.points.iter_mut().zip(&polygon.points) {
            *to = frame.to_world(point);
        }
        for (to, &normal) in outline.normals.iter_mut().zip(&polygon.normals) {
            *to = frame.rotate(normal);
        }
    }
}

impl Polygon {
    /// Signed distance of a point from the line of the edge that it is farthest outside of, m, and that edge.
    /// It is a lower bound on the distance of the point from the polygon.
    #[inline]
    pub fn outside(&self, point: Vec2) -> (f64, usize) {
        let mut farthest = (f64::NEG_INFINITY, 0);
        for (edge, (&corner, &normal)) in self.points.iter().zip(&self.normals).enumerate() {
            let distance = dot(normal, sub(point, corner));
            if distance > farthest.0 {
                farthest = (distance, edge);
            }
        }
        farthest
    }

    /// Start and end of an edge.
    #[inline]
    pub fn edge(&self, edge: usize) -> [Vec2; 2] {
        let next = if edge + 1 < self.points.len() { edge + 1 } else { 0 };
        [self.points[edge], self.points[next]]
    }

    /// The edge that faces a direction most.
    #[inline]
    pub fn facing(&self, direction: Vec2) -> usize {
        let mut best = (f64::NEG_INFINITY, 0);
        for (edge, &normal) in self.normals.iter().enumerate() {
            let along = dot(normal, direction);
            if along > best.0 {
                best = (along, edge);
            }
        }
        best.1
    }

    /// The largest distance by which an edge of this polygon separates it from `other`, m, and that edge. Negative if
    /// none separates them.
    #[inline]
    pub fn separation(&self, other: &Self) -> (f64, usize) {
        let mut largest = (f64::NEG_INFINITY, 0);
        for (edge, (&corner, &normal)) in self.points.iter().zip(&self.normals).enumerate() {
            let nearest =
                other.points.iter().fold(f64::INFINITY, |least, &point| least.min(dot(normal, point)));
            let distance = nearest - dot(normal, corner);
            if distance > largest.0 {
                largest = (distance, edge);
            }
        }
        largest
    }
}
