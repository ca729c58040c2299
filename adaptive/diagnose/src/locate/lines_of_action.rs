//! Lines of action of a missing force.
//!
//! A force at a point has no moment about it. The moment of the smoothed residual about a point is compared with
//! its uncertainty. Different mass and damping are fitted at the same time, because missing effects bias the
//! nominal parameters and thereby the residual. Samples are a tenth of a second apart. Errors have a Student
//! distribution, so that bursts and reversals, which the smoother blurs, have a small weight.

use super::change_points::{MODEL_ERROR_SHARE, PARAMETERS, parameter_wrenches};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use trundle_infer::Residual;

/// Degrees of freedom of the Student distribution.
const STUDENT_DOF: f64 = 4.0;
/// Number of reweightings.
const REWEIGHTINGS: usize = 6;

/// Minimum spacing of samples, s.
const MIN_SAMPLE_SPACING_S: f64 = 0.1;

/// A smoothed residual, with the contributions of different mass and damping.
struct Sample<'a> {
    episode: usize,
    residual: &'a Residual,
    unit_wrenches: [[f64; 3]; PARAMETERS],
}

/// The samples of all episodes.
pub(crate) struct LinesOfAction<'a> {
    samples: Vec<Sample<'a>>,
    /// Root mean square of the missing force at the radius of gyration, N·m.
    moment_scale: f64,
}

/// How closely all lines of action pass through a point.
#[derive(Clone, Debug)]
pub(crate) struct PointFit {
    /// Log density of the moments about the point.
    pub log_density: f64,
    /// Mean square of the residual moments, relative to that of the missing force at the radius of gyration.
    pub residual_share: f64,
    /// Correlation of the moments of neighbouring samples.
    pub correlation: f64,
}

impl<'a> LinesOfAction<'a> {
    /// Collects the smoothed residuals of the episodes that `keep` selects. Moments are compared with forces at
    /// `arm`.
    pub fn new(residuals: &'a [Vec<Residual>], arm: f64, keep: impl Fn(usize) -> bool) -> Self {
        let mut samples = Vec::new();
        for (episode, residuals) in residuals.iter().enumerate().filter(|(e, _)| keep(*e)) {
            let mut next = f64::NEG_INFINITY;
            for (residual, unit_wrenches) in
                residuals.iter().zip(parameter_wrenches(residuals, arm, [true; 3]))
            {
                if residual.t >= next {
                    next = residual.t + MIN_SAMPLE_SPACING_S;
                    samples.push(Sample { episode, residual, unit_wrenches });
                }
            }
        }
        let square: f64 =
            samples.iter().map(|s| s.residual.wrench[0].powi(2) + s.residual.wrench[1].powi(2)).sum();
        let moment_scale = arm * (square / samples.len().max(1) as f64).sqrt();
        Self { samples, moment_scale: moment_scale.max(f64::MIN_POSITIVE) }
    }

    /// Evaluates a point of the object frame, which may depend on the pose.
    pub fn fit_point(&self, point: &impl Fn(&Residual) -> [f64; 2]) -> PointFit {
        let n = self.samples.len();
        let moment = |[x, y]: [f64; 2], w: &[f64; 3]| w[2] - x * w[1] + y * w[0];
        let points: Vec<[f64; 2]> = self.samples.iter().map(|s| point(s.residual)).collect();
        let pairs = || self.samples.iter().zip(&points);
        let moments = DVector::from_iterator(n, pairs().map(|(s, p)| moment(*p, &s.residual.wrench)));
        let design =
            DMatrix::from_fn(n, PARAMETERS, |i, j| moment(points[i], &self.samples[i].unit_wrenches[j]));
        let floor = (MODEL_ERROR_SHARE * self.moment_scale).powi(2);
        let variance =
            DVector::from_iterator(n, pairs().map(|(s, p)| floor + variance(*p, &s.residual.covariance)));
        let residuals = student_residuals(&moments, &design, &variance);
        self.evaluate(&residuals, &variance)
    }

    fn evaluate(&self, residuals: &DVector<f64>, variance: &DVector<f64>) -> PointFit {
        let density = |(l, v): (&f64, &f64)| -0.5 * (STUDENT_DOF + 1.0) * (l * l / (v * STUDENT_DOF)).ln_1p();
        let log_density = residuals.iter().zip(variance.iter()).map(density).sum();
        let (mut product, mut square) = (0.0, 0.0);
        for k in 1..self.samples.len() {
            if self.samples[k].episode == self.samples[k - 1].episode {
                product += (residuals[k] * residuals[k - 1]).clamp(-9.0 * variance[k], 9.0 * variance[k]);
                square += (residuals[k] * residuals[k]).min(9.0 * variance[k]);
            }
        }
        let correlation = if square > 0.0 { (product / square).clamp(0.0, 0.95) } else { 0.0 };
        let mean = residuals.norm_squared() / self.samples.len().max(1) as f64;
        PointFit { log_density, residual_share: mean / self.moment_scale.powi(2), correlation }
    }
}

/// Variance of the moment about a point.
fn variance([x, y]: [f64; 2], covariance: &Matrix3<f64>) -> f64 {
    let arm = Vector3::new(y, -x, 1.0);
    arm.dot(&(covariance * arm)).max(0.0)
}

/// Residuals of a regression on the columns of `design` with Student errors.
fn student_residuals(moments: &DVector<f64>, design: &DMatrix<f64>, variance: &DVector<f64>) -> DVector<f64> {
    let columns = design.ncols();
    let scale = DVector::from_fn(columns, |j, _| design.column(j).norm().max(f64::MIN_POSITIVE).recip());
    let design = design * DMatrix::from_diagonal(&scale);
    let mut residuals = moments.clone();
    for _ in 0..REWEIGHTINGS {
        let weight = residuals.zip_map(variance, |l, v| (STUDENT_DOF + 1.0) / (STUDENT_DOF * v + l * l));
        let mut weighted = design.clone();
        for (mut row, w) in weighted.row_iter_mut().zip(weight.iter()) {
            row *= *w;
        }
        let mut normal = design.tr_mul(&weighted);
        let ridge = 1e-9 * normal.trace().max(f64::MIN_POSITIVE);
        (0..columns).for_each(|k| normal[(k, k)] += ridge);
        let Some(factor) = normal.cholesky() else { return residuals };
        residuals = moments - &design * factor.solve(&weighted.tr_mul(moments));
    }
    residuals
}
