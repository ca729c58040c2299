//! Contact candidates: points of the object's rim at which the missing force points inwards.
//!
//! The force of a contact acts at the rim, within the friction cone about the inward normal, and its line of
//! action passes through the contact point. The strongest such samples become candidates. An impact is short,
//! so that randomly drawn places would miss it.

use trundle_infer::Residual;
use trundle_model::{Body, Fixture};

/// A place where the object may have touched an obstacle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactCandidate {
    /// Position in the world, m.
    pub at: [f64; 2],
    /// Outward normal of the object, world axes.
    pub normal: [f64; 2],
    /// Squared significance of the missing force.
    strength: f64,
}

/// Distance between points of the rim, m.
const RIM_SPACING_M: f64 = 0.02;
/// Points of a disc's rim, and directions in which the normal is searched.
const RIM_ANGLES: usize = 48;
/// Distance from the rim at which the normal is evaluated, m.
const NORMAL_PROBE_M: f64 = 1e-3;
/// Least cosine of the angle between a contact force and the inward normal: a friction coefficient of 0.75.
const MIN_NORMAL_COSINE: f64 = 0.8;
/// Least squared significance of a force.
const MIN_SQUARED_SIGNIFICANCE: f64 = 25.0;
/// Largest distance between a line of action and its point of the rim, m.
const MAX_LINE_DISTANCE_M: f64 = 0.1;
/// Least distance between two candidates, m.
const MIN_SPACING_M: f64 = 0.04;
/// Most candidates that are returned.
const MAX_CANDIDATES: usize = 12;

/// Contact candidates from the missing wrenches along the episodes, the strongest first.
pub(crate) fn contact_candidates(courses: &[Vec<Residual>], body: &Body) -> Vec<ContactCandidate> {
    let rim = rim(body);
    let mut all: Vec<ContactCandidate> =
        courses.iter().flatten().filter_map(|residual| candidate(residual, &rim)).collect();
    all.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    let mut kept: Vec<ContactCandidate> = Vec::new();
    for candidate in all {
        let is_apart = |other: &ContactCandidate| distance(other.at, candidate.at) > MIN_SPACING_M;
        if kept.len() < MAX_CANDIDATES && kept.iter().all(is_apart) {
            kept.push(candidate);
        }
    }
    kept
}

/// The contact candidate that a missing wrench implies, if any.
fn candidate(residual: &Residual, rim: &[([f64; 2], [f64; 2])]) -> Option<ContactCandidate> {
    let [fx, fy, moment] = residual.wrench;
    let force = fx.hypot(fy);
    let inverse = residual.covariance.fixed_view::<2, 2>(0, 0).try_inverse()?;
    let f = nalgebra::Vector2::new(fx, fy);
    let strength = f.dot(&(inverse * f));
    if strength < MIN_SQUARED_SIGNIFICANCE {
        return None;
    }
    let inwards = |(_, n): &&([f64; 2], [f64; 2])| -(fx * n[0] + fy * n[1]) > MIN_NORMAL_COSINE * force;
    let line_distance = |p: [f64; 2]| (moment - (p[0] * fy - p[1] * fx)).abs() / force;
    let (point, normal) =
        rim.iter().filter(inwards).min_by(|a, b| line_distance(a.0).total_cmp(&line_distance(b.0)))?;
    if line_distance(*point) > MAX_LINE_DISTANCE_M {
        return None;
    }
    let (sin, cos) = residual.pose[2].sin_cos();
    let rotated = |[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y];
    let at = rotated(*point);
    Some(ContactCandidate {
        at: [residual.pose[0] + at[0], residual.pose[1] + at[1]],
        normal: rotated(*normal),
        strength,
    })
}

/// Points of the rim with their outward normals, object frame.
fn rim(body: &Body) -> Vec<([f64; 2], [f64; 2])> {
    let points = body.fixtures.iter().flat_map(outline);
    // Points between two fixtures are not on the rim.
    let with_normal = |p: [f64; 2]| {
        let out = |angle: f64| [p[0] + NORMAL_PROBE_M * angle.cos(), p[1] + NORMAL_PROBE_M * angle.sin()];
        let steps = (0..RIM_ANGLES).map(|k| out(k as f64 * std::f64::consts::TAU / RIM_ANGLES as f64));
        let (distance, normal) =
            steps.map(|q| body.outside(q)).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, [0.0; 2]));
        (distance > 0.5 * NORMAL_PROBE_M).then_some((p, normal))
    };
    points.filter_map(with_normal).collect()
}

fn outline(fixture: &Fixture) -> Vec<[f64; 2]> {
    match fixture {
        Fixture::Disc { center: [x, y], radius, .. } => (0..RIM_ANGLES)
            .map(|k| (k as f64 * std::f64::consts::TAU / RIM_ANGLES as f64).sin_cos())
            .map(|(sin, cos)| [x + radius * cos, y + radius * sin])
            .collect(),
        Fixture::Polygon { vertices, .. } => {
            let next = vertices.iter().cycle().skip(1);
            vertices.iter().zip(next).flat_map(|(a, b)| along(*a, *b)).collect()
        }
    }
}

/// Points of an edge, including its first corner.
fn along(a: [f64; 2], b: [f64; 2]) -> Vec<[f64; 2]> {
    let count = (distance(a, b) / RIM_SPACING_M).ceil().max(1.0);
    (0..count as usize).map(|k| [0, 1].map(|i| a[i] + (b[i] - a[i]) * k as f64 / count)).collect()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    fn residuals_of(wrench: [f64; 3]) -> Vec<Vec<Residual>> {
        let covariance = Matrix3::from_diagonal(&[1.0, 1.0, 0.01].into());
        let pose = [1.0, 2.0, std::f64::consts::FRAC_PI_2];
        vec![vec![Residual { t: 0.0, pose, twist: [0.0; 3], wrench, covariance }]]
    }

    fn table() -> Body {
        Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 20.0).unwrap()
    }

    #[test]
    fn an_impact_shows_its_contact_point() {
        // 30 N against the front edge, 0.2 m to the left. The table's x axis points along the world's y axis.
        let found = contact_candidates(&residuals_of([-30.0, 0.0, 0.2 * 30.0]), &table());
        let ContactCandidate { at, normal, .. } = found[0];
        assert!((at[0] - 0.8).abs() < 0.011 && (at[1] - 2.6).abs() < 1e-9, "{at:?}");
        assert!(normal[0].abs() < 1e-6 && (normal[1] - 1.0).abs() < 1e-6, "{normal:?}");
    }

    #[test]
    fn impossible_contacts_are_excluded() {
        let nothing = |wrench| contact_candidates(&residuals_of(wrench), &table()).is_empty();
        assert!(nothing([-1.0, 0.0, 0.0]), "too weak");
        assert!(nothing([-30.0, 0.0, 30.0]), "its line of action misses the table");
        assert!(nothing([0.0, 0.0, 30.0]), "no force");
    }
}
