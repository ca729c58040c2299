//! Rigid bodies and convex colliders for the physics engine, with the exact mass, mass centre and inertia of the model.

use rapier2d_f64::parry::transformation::hertel_mehlhorn;
use rapier2d_f64::prelude::*;
use trundle_model::{Body, Fixture, Plant, Rigid};

use crate::SimError;
use crate::gripper::relative;

/// Friction coefficient of the object's rim against walls and obstacles.
pub(crate) const RIM_FRICTION_COEFFICIENT: f64 = 0.3;

type ConvexPiece = (Pose, SharedShape);

/// A dynamic body with this mass, mass centre and inertia. It never sleeps.
pub(crate) fn rigid_body(rigid: &Rigid<f64>) -> RigidBody {
    RigidBodyBuilder::dynamic().additional_mass_properties(mass_properties(rigid)).can_sleep(false).build()
}

/// Mass, mass centre and inertia as an engine type.
pub(crate) fn mass_properties(rigid: &Rigid<f64>) -> MassProperties {
    MassProperties::new(Vector::new(rigid.com[0], rigid.com[1]), rigid.mass, rigid.inertia)
}

/// Convex colliders of the body's outline; none for a point on a rail. Their density is zero because [`rigid_body`]
/// carries the mass. Separate pieces are several times faster than a compound shape, and stepping them does not allocate.
pub(crate) fn object_colliders(body: &Body) -> Result<Vec<Collider>, SimError> {
    let mut pieces = vec![];
    for (index, fixture) in body.fixtures.iter().enumerate() {
        match fixture {
            Fixture::Polygon { vertices, .. } => {
                pieces.extend(convex_pieces(vertices, || format!("body.fixture {}", index + 1))?);
            }
            Fixture::Disc { center, radius, .. } => {
                let center = Vector::new(center[0], center[1]);
                pieces.push((Pose::from_translation(center), SharedShape::ball(*radius)));
            }
        }
    }
    Ok(pieces.into_iter().map(collider).collect())
}

/// Convex colliders of a fixed obstacle with these corners, world frame, m.
pub(crate) fn obstacle_colliders(polygon: &[[f64; 2]], index: usize) -> Result<Vec<Collider>, SimError> {
    Ok(convex_pieces(polygon, || format!("obstacle {}", index + 1))?.into_iter().map(collider).collect())
}

/// A collider expressed in the tracked frame, if the plant's frame is not the object's own.
pub(crate) fn in_tracked_frame(mut piece: Collider, plant: &Plant<f64>) -> Collider {
    if let Some(mount) = plant.mount() {
        let [x, y, angle] = relative(mount, [0.0; 3]);
        piece.set_position(Pose::new(Vector::new(x, y), angle) * *piece.position());
    }
    piece
}

fn collider((pose, shape): ConvexPiece) -> Collider {
    ColliderBuilder::new(shape)
        .position(pose)
        .density(0.0)
        .friction(RIM_FRICTION_COEFFICIENT)
        .restitution(0.0)
        .build()
}

/// Convex decomposition of a simple polygon. The pieces of a self-intersecting polygon cover a different area, which
/// is an error.
fn convex_pieces(polygon: &[[f64; 2]], what: impl Fn() -> String) -> Result<Vec<ConvexPiece>, SimError> {
    let corners: Vec<Vector> = polygon.iter().map(|&[x, y]| Vector::new(x, y)).collect();
    let pieces = TriMesh::from_polygon(corners).and_then(|triangles| {
        let pieces = hertel_mehlhorn(triangles.vertices(), triangles.indices());
        let shapes = pieces.into_iter().map(SharedShape::convex_polyline);
        shapes.map(|shape| shape.map(|s| (Pose::IDENTITY, s))).collect::<Option<Vec<ConvexPiece>>>()
    });
    let area = area(polygon);
    let covers = |pieces: &Vec<ConvexPiece>| {
        let covered: f64 = pieces.iter().map(|(_, shape)| shape.mass_properties(1.0).mass()).sum();
        area > 0.0 && (covered - area).abs() <= 1e-9 * area
    };
    pieces.filter(covers).ok_or_else(|| SimError::Shape { what: what() })
}

/// Area of a simple polygon, m².
fn area(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let twice: f64 = polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
    twice.abs() / 2.0
}
