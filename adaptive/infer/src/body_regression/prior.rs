//! Prior of a body's parameters and its damping.

use nalgebra::{Matrix4, Vector4};
use trundle_model::Body;

use super::parameters::{DRY_FRICTION, Parameters, Precision};

/// Standard deviation of the logarithm of the mass: a factor of two.
const LOG_MASS_SD: f64 = 0.7;
/// Standard deviation of the mass centre from that of the outline, as a fraction of half its sides.
const MASS_CENTRE_SD: f64 = 0.2;
/// Standard deviation of the inertia about the mass centre of the outline, relative to that of a uniform body.
const INERTIA_SD: f64 = 0.3;
/// Standard deviation of the damping per mass, 1/s. A wheel with this damping stops the body within 0.15 s.
const DAMPING_SD_PER_S: f64 = 7.0;
/// Standard deviation of the dry friction per mass, N/kg: a coefficient of friction of 0.15.
const DRY_FRICTION_SD_N_PER_KG: f64 = 1.5;
/// Precision of a friction that is zero, relative to that of the prior.
const PINNED: f64 = 1e9;

/// Prior, relative to the outline and the mass.
#[derive(Clone, Debug)]
pub(super) struct BodyPrior {
    /// Most probable mass, kg.
    mass: f64,
    /// Mass centre of the outline, object frame, m.
    centre: [f64; 2],
    /// Half the sides of the bounding box, m.
    pub half: [f64; 2],
    /// Radius of gyration of the outline about its mass centre, m.
    pub gyration: f64,
    /// Mean and precision of mass, first moments and inertia, known from steps that are no longer used.
    known: Option<(Vector4<f64>, Matrix4<f64>)>,
}

impl BodyPrior {
    pub fn of(body: &Body) -> Self {
        let [low, high] = body.bounds();
        let half = [0, 1].map(|k| 0.5 * (high[k] - low[k]));
        Self { mass: body.mass, centre: body.com, half, gyration: body.gyration, known: None }
    }

    /// Replace the prior of mass, first moments and inertia by their posterior.
    pub fn learn_mass(&mut self, mean: &Parameters, precision: &Precision) {
        let covariance = precision.cholesky().map(|factor| factor.inverse());
        let marginal = covariance.and_then(|all| all.fixed_view::<4, 4>(0, 0).into_owned().cholesky());
        self.known =
            marginal.map(|factor| (mean.fixed_rows::<4>(0).into_owned(), factor.inverse())).or(self.known);
    }

    /// Mean and precision. The prior of the mass is log-normal and expanded at `mass`; the others scale with it. Without dry
    /// friction the last parameter is zero.
    pub fn at(&self, mass: f64, is_dry: bool) -> (Parameters, Precision) {
        let ([cx, cy], [a, b], rho) = (self.centre, self.half, self.gyration * self.gyration);
        let expanded = mass * (1.0 - (mass / self.mass).ln());
        let mut precision = Precision::zeros();
        precision[(0, 0)] = (LOG_MASS_SD * mass).powi(-2);
        // Moments relative to a uniform body of the same mass: m c − m centre, and I − m (ρ² + centre²).
        let relative = [(1, cx, MASS_CENTRE_SD * a), (2, cy, MASS_CENTRE_SD * b)];
        let inertia = (3, rho + cx * cx + cy * cy, INERTIA_SD * rho);
        for (k, per_mass, sd) in relative.into_iter().chain([inertia]) {
            let weight = (mass * sd).powi(-2);
            precision[(k, k)] += weight;
            precision[(0, 0)] += weight * per_mass * per_mass;
            precision[(0, k)] -= weight * per_mass;
            precision[(k, 0)] -= weight * per_mass;
        }
        let damping = DAMPING_SD_PER_S * mass;
        let entries = [1.0, 0.5, 1.0, a, b, rho];
        for (k, scale) in entries.into_iter().enumerate() {
            precision[(4 + k, 4 + k)] = (damping * scale).powi(-2);
        }
        let pinned = if is_dry { 1.0 } else { PINNED };
        precision[(DRY_FRICTION, DRY_FRICTION)] = pinned * (DRY_FRICTION_SD_N_PER_KG * mass).powi(-2);
        let mut mean = Parameters::zeros();
        mean[0] = expanded;
        mean[1] = expanded * cx;
        mean[2] = expanded * cy;
        mean[3] = expanded * (rho + cx * cx + cy * cy);
        if let Some((values, certainty)) = &self.known {
            mean.fixed_rows_mut::<4>(0).copy_from(values);
            precision.fixed_view_mut::<4, 4>(0, 0).copy_from(certainty);
        }
        (mean, precision)
    }
}
