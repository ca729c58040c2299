//! Lines of action: through which point a missing force passes.
//!
//! A force at a point has no moment about it. What the smoothed residual has of moment about a point is compared
//! with its uncertainty, after whatever other mass and damping could do there: nominal parameters bend to what the
//! model lacks, and what they took comes back as such. Samples a tenth of a second apart, errors with Student's tails, so that
//! bursts and reversals, which the smoother blurs, weigh little.

use super::change::{NUMBERS, others};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use trundle_infer::Residual;

/// Degrees of freedom of the errors.
const TAILS: f64 = 4.0;
/// Reweighted so often.
const ROUNDS: usize = 6;
/// Error of the smoothed moment beside its covariance, as a share of the missing force at the radius of gyration: the
/// laws are linear only nearly, the smoother blurs.
const LOOSE: f64 = 0.03;

/// Samples are at least this far apart, s.
const SPACING: f64 = 0.1;

/// A smoothed residual, and what other mass and damping could have put there.
struct Sample<'a> {
    episode: usize,
    seen: &'a Residual,
    others: [[f64; 3]; NUMBERS],
}

/// The samples of all episodes.
pub(crate) struct Lines<'a> {
    samples: Vec<Sample<'a>>,
    /// Missing force at the radius of gyration, root mean square, N·m.
    size: f64,
}

/// How well all lines pass through a point.
#[derive(Clone, Debug)]
pub(crate) struct Through {
    /// Log density of the moments about it.
    pub log_density: f64,
    /// Mean square of the moments left, as a share of the missing force at the radius of gyration, squared.
    pub left: f64,
    /// Correlation of neighbouring samples' moments.
    pub correlation: f64,
}

impl<'a> Lines<'a> {
    /// From the smoothed residuals of the episodes that `keep` keeps, moments compared with forces at `arm`.
    pub fn new(courses: &'a [Vec<Residual>], arm: f64, keep: impl Fn(usize) -> bool) -> Self {
        let mut samples = Vec::new();
        for (episode, course) in courses.iter().enumerate().filter(|(e, _)| keep(*e)) {
            let mut next = f64::NEG_INFINITY;
            for (seen, others) in course.iter().zip(others(course, arm, [true; 3])) {
                if seen.t >= next {
                    next = seen.t + SPACING;
                    samples.push(Sample { episode, seen, others });
                }
            }
        }
        let square: f64 = samples.iter().map(|s| s.seen.wrench[0].powi(2) + s.seen.wrench[1].powi(2)).sum();
        let size = arm * (square / samples.len().max(1) as f64).sqrt();
        Self { samples, size: size.max(f64::MIN_POSITIVE) }
    }

    /// How well the lines pass through a point of the object frame that may move with the pose.
    pub fn through(&self, point: &impl Fn(&Residual) -> [f64; 2]) -> Through {
        let n = self.samples.len();
        let moment = |[x, y]: [f64; 2], w: &[f64; 3]| w[2] - x * w[1] + y * w[0];
        let points: Vec<[f64; 2]> = self.samples.iter().map(|s| point(s.seen)).collect();
        let pairs = || self.samples.iter().zip(&points);
        let seen = DVector::from_iterator(n, pairs().map(|(s, p)| moment(*p, &s.seen.wrench)));
        let design = DMatrix::from_fn(n, NUMBERS, |i, j| moment(points[i], &self.samples[i].others[j]));
        let floor = (LOOSE * self.size).powi(2);
        let variance =
            DVector::from_iterator(n, pairs().map(|(s, p)| floor + variance(*p, &s.seen.covariance)));
        let left = robust(&seen, &design, &variance);
        self.judged(&left, &variance)
    }

    fn judged(&self, left: &DVector<f64>, variance: &DVector<f64>) -> Through {
        let density = |(l, v): (&f64, &f64)| -0.5 * (TAILS + 1.0) * (l * l / (v * TAILS)).ln_1p();
        let log_density = left.iter().zip(variance.iter()).map(density).sum();
        let (mut product, mut square) = (0.0, 0.0);
        for k in 1..self.samples.len() {
            if self.samples[k].episode == self.samples[k - 1].episode {
                product += (left[k] * left[k - 1]).clamp(-9.0 * variance[k], 9.0 * variance[k]);
                square += (left[k] * left[k]).min(9.0 * variance[k]);
            }
        }
        let correlation = if square > 0.0 { (product / square).clamp(0.0, 0.95) } else { 0.0 };
        let mean = left.norm_squared() / self.samples.len().max(1) as f64;
        Through { log_density, left: mean / self.size.powi(2), correlation }
    }
}

/// Variance of the moment about a point.
fn variance([x, y]: [f64; 2], covariance: &Matrix3<f64>) -> f64 {
    let arm = Vector3::new(y, -x, 1.0);
    arm.dot(&(covariance * arm)).max(0.0)
}

/// What a fit of the columns under Student's errors leaves.
fn robust(seen: &DVector<f64>, design: &DMatrix<f64>, variance: &DVector<f64>) -> DVector<f64> {
    let columns = design.ncols();
    let scale = DVector::from_fn(columns, |j, _| design.column(j).norm().max(f64::MIN_POSITIVE).recip());
    let design = design * DMatrix::from_diagonal(&scale);
    let mut left = seen.clone();
    for _ in 0..ROUNDS {
        let weight = left.zip_map(variance, |l, v| (TAILS + 1.0) / (TAILS * v + l * l));
        let mut weighted = design.clone();
        for (mut row, w) in weighted.row_iter_mut().zip(weight.iter()) {
            row *= *w;
        }
        let mut normal = design.tr_mul(&weighted);
        let ridge = 1e-9 * normal.trace().max(f64::MIN_POSITIVE);
        (0..columns).for_each(|k| normal[(k, k)] += ridge);
        let Some(factor) = normal.cholesky() else { return left };
        left = seen - &design * factor.solve(&weighted.tr_mul(seen));
    }
    left
}
