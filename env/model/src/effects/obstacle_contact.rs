//! Contact with a fixed obstacle that is not in the model: a table leg, a post, a box on the floor.
//!
//! ```text
//! F = −(k s(d) + c s'(d) v·n) n,   d = radius − distance of the footprint's boundary from (x, y),   c = 2 ζ √(k m)
//! ```
//! `n` is the outward normal of the boundary at the nearest edge or corner, and `s` the positive part, smoothed over
//! millimetres. The obstacle is round, because contact on one side does not identify a more detailed shape. With the
//! default stiffness it yields by a millimetre or two under a typical push, and impacts are nearly plastic.

use super::geometry::{in_world, softplus};
use super::positive;
use crate::boundary::{Boundary, Piece};
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Role, Spec, take};
use crate::{Body, Real};

pub(crate) static SPEC: Spec = Spec {
    kind: "obstacle_contact",
    effect: "obstacle_contact",
    summary: "contact with a fixed obstacle that is not in the model",
    source: "the compliant normal force of Hunt and Crossley 1975, with damping independent of depth",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        in_world("x", 0, "centre of the obstacle, world"),
        in_world("y", 1, "centre of the obstacle, world"),
        positive("radius", "m", 5.0, (0.05, 0.7), "radius of the obstacle")
            .role(Role::Region)
            .at_least(5e-3)
            .refinement(0.05),
        positive("stiffness", "N/m", 1e6, (3e4, 1.0), "contact force per depth").refinement(3e4),
        positive("friction", "1", 2.0, (0.3, 0.7), "coefficient of dry friction along the boundary")
            .role(Role::Shape)
            .refinement(0.0),
    ],
    neutral: &[("stiffness", 0.0)],
    sentence: "The object hits a fixed obstacle near ({x}, {y}).",
    suggested_push: "push slowly against the place from two sides: an obstacle stops the object at a line, friction \
        does not",
};

/// Depth over which the onset of contact is smoothed, m.
const SMOOTHING_DEPTH_M: f64 = 1e-3;

/// Largest gap, in smoothing depths, at which the contact force is evaluated.
const MAX_GAP_SMOOTHING_DEPTHS: f64 = 40.0;

/// Damping ratio for the total mass.
const DAMPING_RATIO: f64 = 0.7;

/// Speed below which friction is proportional to the speed, m/s.
const CREEP_M_PER_S: f64 = 1e-3;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct ObstacleContact<T> {
    boundary: Boundary,
    center: [T; 2],
    radius: T,
    stiffness: T,
    friction: T,
}

impl<T: Real> EffectLaw<T> for ObstacleContact<T> {
    fn new(values: &[T], site: &LawSetup<'_, T>) -> Self {
        let [x, y, radius, stiffness, friction] = take(values);
        Self { boundary: Boundary::new(site.body), center: [x, y], radius, stiffness, friction }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        if !at.clock.in_contact() {
            return;
        }
        let center = at.in_object(self.center);
        let within = self.radius.re() + MAX_GAP_SMOOTHING_DEPTHS * SMOOTHING_DEPTH_M;
        self.boundary
            .pieces_near(center.map(T::re), within, |piece| self.add_contact_force(piece, center, at, sum));
    }
}

impl<T: Real> ObstacleContact<T> {
    /// Add the contact force at one piece of the boundary. `center`: centre of the obstacle, object frame, m.
    fn add_contact_force(
        &self,
        piece: Piece,
        center: [T; 2],
        at: &LawContext<'_, T>,
        sum: &mut GeneralisedForce<T>,
    ) {
        let (distance, [nx, ny]) = distance_and_normal(piece, center);
        let (depth, share) = softplus(self.radius - distance, SMOOTHING_DEPTH_M);
        let force = self.stiffness * depth;
        sum.add_force_at(center, [-(nx * force), -(ny * force)]);
        let c = (self.stiffness * at.mass).sqrt() * share * (2.0 * DAMPING_RATIO);
        sum.add_damping_at(center, [c * nx * nx, c * nx * ny, c * ny * ny]);
        if self.friction.re() > 0.0 {
            // Friction acts at the boundary. The normal force acts along the line through the centre, so any point on
            // it is equivalent.
            let foot = [center[0] - nx * distance, center[1] - ny * distance];
            let [vx, vy] = at.point_velocity(foot);
            let slip = vy * nx - vx * ny;
            let c = self.friction * force / (slip.squared() + CREEP_M_PER_S * CREEP_M_PER_S).sqrt();
            sum.add_damping_at(foot, [c * ny * ny, -(c * nx * ny), c * nx * nx]);
        }
    }
}

/// Point of an obstacle's surface closest to a body at `pose`, world, m.
pub fn obstacle_surface(body: &Body, center: [f64; 2], radius: f64, pose: [f64; 3]) -> [f64; 2] {
    let (sin, cos) = pose[2].sin_cos();
    let (dx, dy) = (center[0] - pose[0], center[1] - pose[1]);
    let (_, [ox, oy]) = body.outside([cos * dx + sin * dy, cos * dy - sin * dx]);
    [center[0] - radius * (cos * ox - sin * oy), center[1] - radius * (sin * ox + cos * oy)]
}

/// Distance of a point from a piece of the boundary, and the outward normal.
fn distance_and_normal<T: Real>(piece: Piece, [x, y]: [T; 2]) -> (T, [T; 2]) {
    match piece {
        Piece::Flat { point, normal } => {
            let distance = (x - point[0]) * normal[0] + (y - point[1]) * normal[1];
            (distance, normal.map(T::lift))
        }
        Piece::Round { center, radius } => {
            let (dx, dy) = (x - center[0], y - center[1]);
            let length = (dx.squared() + dy.squared() + 1e-18).sqrt();
            (length - radius, [dx / length, dy / length])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_surface_faces_the_body() {
        let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 1.0).unwrap();
        // Rotated by 90°, the short side of the table faces the post.
        let found = obstacle_surface(&body, [2.0, 1.5], 0.1, [2.0, 0.5, std::f64::consts::FRAC_PI_2]);
        assert!((found[0] - 2.0).abs() < 1e-12 && (found[1] - 1.4).abs() < 1e-12, "{found:?}");
    }
}
