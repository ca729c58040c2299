//! Contact points of one convex piece of the object with one convex piece of an obstacle.

use serde::{Deserialize, Serialize};

use super::closest::{self, Closest};
use super::shape::{Outline, Piece, Polygon};
use super::vector::{Frame, Vec2, add, dot, perpendicular, scale, sub};

/// Cosine of the turn up to which contact points keep their places on both shapes.
const MAX_KEPT_TURN_COS: f64 = 0.999_847_695_156_391_3;
/// Square of the slip up to which contact points keep their places, m².
const MAX_KEPT_SLIP_M2: f64 = 1e-6;
/// Feature of a contact point that is neither a corner nor an edge.
const NO_FEATURE: u32 = u32::MAX;

/// Largest number of contact points of a manifold.
pub(super) const MAX_POINTS: usize = 2;

/// Up to two contact points with a common normal.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Manifold {
    /// Unit normal from the object to the obstacle, object frame.
    pub normal: Vec2,
    /// The same when the points were determined, world frame.
    world_normal: Vec2,
    pub points: [ContactPoint; MAX_POINTS],
    pub count: usize,
}

/// A contact point.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct ContactPoint {
    /// Point on the object, object frame, m.
    pub on_object: Vec2,
    /// Point on the obstacle, world frame, m.
    pub on_obstacle: Vec2,
    /// Distance along the normal, negative in penetration, m.
    pub distance: f64,
    /// Corners and edges of object and obstacle that make the contact.
    features: [u32; 2],
    /// Impulse along the normal in the last step, N·s.
    pub impulse: f64,
    /// Impulse of friction in the last step, N·s.
    pub friction_impulse: f64,
}

impl Manifold {
    /// Update the points for the present pose of the object. `outline` is a buffer for the piece's outline in world axes,
    /// and `is_placed` whether it has been written for this pose.
    pub fn update(
        &mut self,
        frame: &Frame,
        piece: &Piece,
        (outline, is_placed): (&mut Polygon, &mut bool),
        obstacle: &Polygon,
        limit: f64,
    ) {
        let (points, count) = (self.points, self.count);
        match piece.outline {
            Outline::Disc => {
                self.count = 0;
                let center = frame.to_world(piece.center);
                if let Some(found) = closest::disc(center, piece.radius, obstacle, limit) {
                    self.set_normal(frame, found.normal);
                    self.push(frame, found.first, found.second, found.normal, [NO_FEATURE; 2]);
                    if count == 1 {
                        self.points[0].impulse = points[0].impulse;
                        self.points[0].friction_impulse = points[0].friction_impulse;
                    }
                }
            }
            Outline::Polygon(_) => {
                if self.keep_points(frame) {
                    return;
                }
                self.count = 0;
                if !std::mem::replace(is_placed, true) {
                    piece.place(frame, outline);
                }
                if let Some(found) = closest::polygons(outline, obstacle, limit) {
                    self.set_normal(frame, found.normal);
                    self.clip_edges(frame, outline, obstacle, &found);
                    self.match_impulses(&points[..count]);
                }
            }
        }
    }

    /// Keep the places of the points on both shapes after a small motion, and update their distances.
    fn keep_points(&mut self, frame: &Frame) -> bool {
        let normal = frame.rotate(self.normal);
        if self.count == 0 || dot(normal, self.world_normal) < MAX_KEPT_TURN_COS {
            return false;
        }
        let mut distances = [0.0; 2];
        for (point, distance) in self.points[..self.count].iter().zip(&mut distances) {
            let apart = sub(point.on_obstacle, frame.to_world(point.on_object));
            *distance = dot(apart, normal);
            let slip = sub(apart, scale(normal, *distance));
            if *distance * point.distance < 0.0 || dot(slip, slip) > MAX_KEPT_SLIP_M2 {
                return false;
            }
        }
        for (point, distance) in self.points.iter_mut().zip(distances) {
            point.distance = distance;
        }
        true
    }

    fn set_normal(&mut self, frame: &Frame, normal: Vec2) {
        self.normal = frame.rotate_back(normal);
        self.world_normal = normal;
    }

    fn push(&mut self, frame: &Frame, first: Vec2, second: Vec2, normal: Vec2, features: [u32; 2]) {
        self.points[self.count] = ContactPoint {
            on_object: frame.to_local(first),
            on_obstacle: second,
            distance: dot(sub(second, first), normal),
            features,
            impulse: 0.0,
            friction_impulse: 0.0,
        };
        self.count += 1;
    }

    /// Contact points at the ends of the common part of the two edges that face each other.
    fn clip_edges(&mut self, frame: &Frame, world: &Polygon, obstacle: &Polygon, found: &Closest) {
        let normal = found.normal;
        let one = Edge::facing(world, normal, normal);
        let two = Edge::facing(obstacle, scale(normal, -1.0), normal);
        if two.range[0] > one.range[1] || one.range[0] > two.range[1] {
            self.push(frame, found.first, found.second, normal, [NO_FEATURE; 2]);
            return;
        }
        for end in [0, 1] {
            // The end of the edge that ends first.
            let is_second = if end == 0 { two.range[0] > one.range[0] } else { two.range[1] < one.range[1] };
            let (first, second, features) = if is_second {
                (one.at(two.range[end]), two.points[end], [one.edge_feature, two.features[end]])
            } else {
                (one.points[end], two.at(one.range[end]), [one.features[end], two.edge_feature])
            };
            self.push(frame, first, second, normal, features);
        }
    }

    /// Take over the impulses of earlier points with the same features.
    fn match_impulses(&mut self, earlier: &[ContactPoint]) {
        for point in &mut self.points[..self.count] {
            for old in earlier.iter().filter(|old| old.features == point.features) {
                (point.impulse, point.friction_impulse) = (old.impulse, old.friction_impulse);
            }
        }
    }
}

/// An edge, directed along the tangent of the contact.
struct Edge {
    points: [Vec2; 2],
    /// Places of the ends along the tangent, m.
    range: [f64; 2],
    features: [u32; 2],
    edge_feature: u32,
}

impl Edge {
    fn facing(polygon: &Polygon, direction: Vec2, normal: Vec2) -> Self {
        let (edge, tangent) = (polygon.facing(direction), perpendicular(normal));
        let next = (edge + 1) % polygon.points.len();
        let points = polygon.edge(edge);
        let range = points.map(|point| dot(point, tangent));
        let features = [edge, next].map(|corner| 2 * corner as u32);
        let edge_feature = 2 * edge as u32 + 1;
        if range[1] < range[0] {
            let [a, b] = points;
            return Self {
                points: [b, a],
                range: [range[1], range[0]],
                features: [features[1], features[0]],
                edge_feature,
            };
        }
        Self { points, range, features, edge_feature }
    }

    /// The point at a place along the tangent.
    fn at(&self, place: f64) -> Vec2 {
        let [low, high] = self.range;
        let share = if high > low { (place - low) / (high - low) } else { 0.0 };
        add(self.points[0], scale(sub(self.points[1], self.points[0]), share))
    }
}
