//! Linear regression, the paper's LR: sample-efficient, and exact only for linear objects.

use super::checks::check;
use super::error::BaselineError;
use super::features::Features;
use super::features::Scale;
use super::predictor::{Predictor, StateVector};
use super::transitions::Transition;
use nalgebra::DMatrix;

/// Relative tolerance below which singular values count as zero.
const RANK_TOLERANCE: f64 = 1e-10;

/// `x' − x = A [x, u, 1] dt` by least squares. With fewer observations than coefficients, the minimum-norm
/// solution for standardised features is used.
#[derive(Clone, Debug)]
pub struct Linear {
    features: Features,
    scale: Scale,
    mean: StateVector,
    /// One row for each feature, one column for each channel.
    slopes: DMatrix<f64>,
}

impl Linear {
    /// Fit to transitions, which should have one `dt`.
    ///
    /// # Errors
    /// When `training` is empty, or a number is not finite.
    pub fn fit(training: &[Transition], features: Features) -> Result<Self, BaselineError> {
        check(training)?;
        let n = training.len();
        let rows: Vec<_> = training.iter().map(|t| features.of(&t.before, &t.wrench)).collect();
        let scale = Scale::of(&rows, features.count());
        let rates: Vec<_> = training.iter().map(|t| features.rate(t)).collect();
        let mean = std::array::from_fn(|k| rates.iter().map(|r| r[k]).sum::<f64>() / n as f64);
        let inputs: Vec<f64> = rows.iter().flat_map(|row| scale.apply(row)).collect();
        let design = DMatrix::from_row_slice(n, features.count(), &inputs);
        let targets = DMatrix::from_fn(n, 6, |i, k| rates[i][k] - mean[k]);
        Ok(Self { features, scale, mean, slopes: least_squares(design, &targets) })
    }
}

/// Minimum-norm least-squares solution by singular values.
fn least_squares(design: DMatrix<f64>, targets: &DMatrix<f64>) -> DMatrix<f64> {
    let nothing = DMatrix::zeros(design.ncols(), targets.ncols());
    let svd = design.svd(true, true);
    let tolerance = RANK_TOLERANCE * svd.singular_values.max();
    // `solve` fails only without singular vectors.
    if tolerance > 0.0 { svd.solve(targets, tolerance).unwrap_or(nothing) } else { nothing }
}

impl Predictor for Linear {
    fn predict(&self, x: &StateVector, u: &[f64; 3], dt: f64) -> StateVector {
        let input = self.scale.apply(&self.features.of(x, u));
        let rate = std::array::from_fn(|k| {
            self.mean[k] + self.slopes.column(k).iter().zip(&input).map(|(slope, z)| slope * z).sum::<f64>()
        });
        self.features.after(x, rate, dt)
    }
}
