//! The rigid body: fixtures, mass, inertia and support points.

use crate::ModelError;
use crate::fixture::{EMPTY_BOUNDS, Fixture, Support};
use crate::pressure::uniform_pressure;

/// Geometry and mass distribution of a rigid body. All fields except `mass` are independent of the mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Shape, object frame; empty for a point mass on a rail.
    pub fixtures: Vec<Fixture>,
    /// Mass, kg.
    pub mass: f64,
    /// Mass centre, object frame, m.
    pub com: [f64; 2],
    /// Radius of gyration about the mass centre, m.
    pub gyration: f64,
    /// Support points: the given feet, or cells of a flat face.
    pub support: Vec<Support>,
    /// Feet as given, object frame, m; `None` for a flat face.
    pub feet: Option<Vec<[f64; 2]>>,
}

impl Body {
    /// A body of uniform density over one polygon. `mass` in kg.
    ///
    /// # Errors
    /// When the polygon has no area or the mass is not positive.
    pub fn from_footprint(footprint: &[[f64; 2]], mass: f64) -> Result<Self, ModelError> {
        Self::from_fixtures(vec![Fixture::Polygon { vertices: footprint.to_vec(), density: 1.0 }], mass)
    }

    /// A body made of several fixtures of given relative density. `mass` in kg.
    ///
    /// # Errors
    /// When the fixtures have no area or the mass is not positive.
    pub fn from_fixtures(fixtures: Vec<Fixture>, mass: f64) -> Result<Self, ModelError> {
        check_mass(mass)?;
        let (mut weight, mut first, mut polar) = (0.0, [0.0; 2], 0.0);
        for (w, [fx, fy], p) in fixtures.iter().map(Fixture::moments) {
            weight += w;
            first = [first[0] + fx, first[1] + fy];
            polar += p;
        }
        if !(weight.is_finite() && weight > 0.0) {
            return Err(ModelError::NoArea);
        }
        let com = first.map(|m| m / weight);
        let gyration = (polar / weight - com[0] * com[0] - com[1] * com[1]).max(0.0).sqrt();
        let support = uniform_pressure(&fixtures, bounds(&fixtures));
        Ok(Self { fixtures, mass, com, gyration, support, feet: None })
    }

    /// A point mass, for an object on a rail that has no footprint. `mass` in kg.
    ///
    /// # Errors
    /// When the mass is not positive.
    pub fn point(mass: f64) -> Result<Self, ModelError> {
        check_mass(mass)?;
        let support = vec![Support { point: [0.0; 2], share: 1.0 }];
        Ok(Self { fixtures: vec![], mass, com: [0.0; 2], gyration: 1.0, support, feet: None })
    }

    /// The same body on `feet` (object frame, m). Static equilibrium determines the load of three feet; for more feet
    /// it is a least-squares solution.
    #[must_use]
    pub fn with_feet(mut self, feet: &[[f64; 2]]) -> Self {
        if !feet.is_empty() {
            self.support = foot_loads(feet, self.com);
            self.feet = Some(feet.to_vec());
        }
        self
    }

    /// Moment of inertia about the mass centre, kg·m².
    pub fn inertia(&self) -> f64 {
        self.mass * self.gyration * self.gyration
    }

    /// Smallest and largest coordinates of the shape, `[[x, y], [x, y]]`, m, object frame.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        if self.fixtures.is_empty() {
            return [[0.0; 2]; 2];
        }
        bounds(&self.fixtures)
    }
}

fn check_mass(mass: f64) -> Result<(), ModelError> {
    if mass.is_finite() && mass > 0.0 { Ok(()) } else { Err(ModelError::Mass(mass)) }
}

fn bounds(fixtures: &[Fixture]) -> [[f64; 2]; 2] {
    fixtures.iter().map(Fixture::bounds).fold(EMPTY_BOUNDS, |[a, b], [c, d]| {
        [[a[0].min(c[0]), a[1].min(c[1])], [b[0].max(d[0]), b[1].max(d[1])]]
    })
}

/// Static loads of the feet: the least-squares deviation from equal shares subject to Σs = 1 and Σs·p = com.
/// Negative shares (a foot that would lift) are set to zero.
fn foot_loads(feet: &[[f64; 2]], com: [f64; 2]) -> Vec<Support> {
    let n = feet.len() as f64;
    let center = [0, 1].map(|k| feet.iter().map(|p| p[k]).sum::<f64>() / n);
    let (mut sxx, mut sxy, mut syy) = (0.0, 0.0, 0.0);
    for p in feet {
        let (x, y) = (p[0] - center[0], p[1] - center[1]);
        sxx += x * x;
        sxy += x * y;
        syy += y * y;
    }
    let det = sxx * syy - sxy * sxy;
    let (dx, dy) = (com[0] - center[0], com[1] - center[1]);
    // Feet in a line, or one foot, cannot balance a moment: they get equal shares.
    let (a, b) = if det > 1e-12 * (sxx + syy).powi(2) {
        ((syy * dx - sxy * dy) / det, (sxx * dy - sxy * dx) / det)
    } else {
        (0.0, 0.0)
    };
    let raw: Vec<f64> =
        feet.iter().map(|p| (1.0 / n + a * (p[0] - center[0]) + b * (p[1] - center[1])).max(0.0)).collect();
    let total: f64 = raw.iter().sum();
    feet.iter().zip(raw).map(|(&point, s)| Support { point, share: s / total }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: [[f64; 2]; 4] = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];

    #[test]
    fn rectangle_has_the_textbook_inertia() {
        let body = Body::from_footprint(&TABLE, 22.0).unwrap();
        assert!((body.inertia() - 22.0 * (1.2f64.powi(2) + 0.8f64.powi(2)) / 12.0).abs() < 1e-12);
        assert!(body.com[0].abs() < 1e-15 && body.com[1].abs() < 1e-15);
        assert!((body.support.iter().map(|s| s.share).sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_disc_and_a_square_balance_by_area_and_density() {
        let square =
            Fixture::Polygon { vertices: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], density: 1.0 };
        let disc = Fixture::Disc { center: [3.0, 0.5], radius: 1.0, density: std::f64::consts::FRAC_1_PI };
        let body = Body::from_fixtures(vec![square, disc], 2.0).unwrap();
        assert!((body.com[0] - 1.75).abs() < 1e-12 && (body.com[1] - 0.5).abs() < 1e-12);
        let expected = (1.0 / 6.0 + 1.25f64.powi(2)) + (0.5 + 1.25f64.powi(2));
        assert!((body.inertia() - expected).abs() < 1e-12);
    }

    #[test]
    fn three_feet_are_in_static_equilibrium() {
        let body = Body::from_footprint(&[[0.0, 0.0], [0.15, 0.0], [0.0, 0.15]], 1.5).unwrap();
        let feet = [[0.01, 0.01], [0.13, 0.01], [0.01, 0.13]];
        let support = body.clone().with_feet(&feet).support;
        for k in 0..2 {
            let moment: f64 = support.iter().map(|s| s.share * s.point[k]).sum();
            assert!((moment - body.com[k]).abs() < 1e-12);
        }
    }

    #[test]
    fn invalid_bodies_are_rejected() {
        assert!(matches!(Body::from_footprint(&TABLE, 0.0), Err(ModelError::Mass(_))));
        assert!(matches!(Body::from_footprint(&[[0.0, 0.0], [1.0, 0.0]], 1.0), Err(ModelError::NoArea)));
        assert!(matches!(Body::from_footprint(&TABLE, f64::NAN), Err(ModelError::Mass(_))));
    }
}
