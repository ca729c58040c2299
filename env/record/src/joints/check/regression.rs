//! Linear least squares with standard deviations that allow for correlated residuals.

use nalgebra::{DMatrix, DVector};

/// Relative size of the smallest singular value that counts.
const MIN_SINGULAR_VALUE: f64 = 1e-9;
/// Longest correlation of residuals that is summed, as a share of the rows.
const MAX_CORRELATED_SHARE: usize = 20;

/// Regressors, and the inverse of their normal matrix.
pub(super) struct Regressors {
    rows: DMatrix<f64>,
    inverse: DMatrix<f64>,
    scales: Vec<f64>,
}

/// Result of a regression.
pub(super) struct Fit {
    pub coefficients: Vec<f64>,
    /// Standard deviations; infinite for a regressor that is zero.
    pub sd: Vec<f64>,
    /// Residual sum of squares relative to that of the response about its mean.
    pub unexplained: f64,
    /// Number of rows, divided by the correlation length of the residuals.
    pub independent_rows: f64,
}

impl Fit {
    /// Coefficient in its standard deviations.
    pub fn z(&self, index: usize) -> f64 {
        if self.sd[index] > 0.0 { self.coefficients[index] / self.sd[index] } else { 0.0 }
    }
}

impl Regressors {
    /// Prepares `columns` of equal length. `None` without rows, or if the columns are not finite.
    pub fn new(columns: &[Vec<f64>]) -> Option<Self> {
        let n = columns.first()?.len();
        let scale = |column: &Vec<f64>| (column.iter().map(|x| x * x).sum::<f64>() / n as f64).sqrt();
        let scales: Vec<f64> = columns.iter().map(scale).collect();
        if n < 4 * columns.len() || scales.iter().any(|scale| !scale.is_finite()) {
            return None;
        }
        let unit = |scale: f64| if scale > 0.0 { 1.0 / scale } else { 0.0 };
        let rows =
            DMatrix::from_fn(n, columns.len(), |row, column| columns[column][row] * unit(scales[column]));
        let normal = rows.tr_mul(&rows) / n as f64;
        let inverse = normal.pseudo_inverse(MIN_SINGULAR_VALUE).ok()? / n as f64;
        Some(Self { rows, inverse, scales })
    }

    /// Share of `response` that the regressors do not explain.
    pub fn unexplained(&self, response: &[f64]) -> f64 {
        let y = DVector::from_column_slice(response);
        let right = self.rows.tr_mul(&y);
        let explained = (right.transpose() * &self.inverse * &right)[0];
        let square = y.norm_squared();
        let total = square - y.sum().powi(2) / y.len() as f64;
        if total > 0.0 { ((square - explained) / total).max(0.0) } else { 1.0 }
    }

    /// Values of `response` that the regressors give.
    pub fn predict(&self, response: &[f64]) -> Vec<f64> {
        let y = DVector::from_column_slice(response);
        let predicted = &self.rows * (&self.inverse * self.rows.tr_mul(&y));
        predicted.iter().copied().collect()
    }

    /// Regression of `response`.
    pub fn fit(&self, response: &[f64]) -> Fit {
        let y = DVector::from_column_slice(response);
        let scaled = &self.inverse * self.rows.tr_mul(&y);
        let predicted = &self.rows * &scaled;
        let residual: Vec<f64> = (&y - &predicted).iter().copied().collect();
        let correlation = correlation_length(&residual);
        let independent_rows = y.len() as f64 / correlation;
        let variance = residual.iter().map(|r| r * r).sum::<f64>() / y.len() as f64 * correlation;
        let sd = |k: usize| match self.scales[k] > 0.0 {
            true => (variance * self.inverse[(k, k)].max(0.0)).sqrt() / self.scales[k],
            false => f64::INFINITY,
        };
        let unit = |k: usize| if self.scales[k] > 0.0 { scaled[k] / self.scales[k] } else { 0.0 };
        Fit {
            coefficients: (0..self.scales.len()).map(unit).collect(),
            sd: (0..self.scales.len()).map(sd).collect(),
            unexplained: self.unexplained(response),
            independent_rows,
        }
    }
}

/// Sum of the autocorrelation of `values` up to its first negative value.
fn correlation_length(values: &[f64]) -> f64 {
    let square: f64 = values.iter().map(|v| v * v).sum();
    if square <= 0.0 {
        return 1.0;
    }
    let mut length = 1.0;
    for lag in 1..(values.len() / MAX_CORRELATED_SHARE).max(2).min(values.len()) {
        let product: f64 = values[lag..].iter().zip(values).map(|(a, b)| a * b).sum();
        if product <= 0.0 {
            break;
        }
        length += 2.0 * product / square;
    }
    length
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn exact_data_give_the_exact_coefficients() {
        let x: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.1).collect();
        let columns = vec![x.clone(), vec![1.0; 100], vec![0.0; 100]];
        let y: Vec<f64> = x.iter().map(|x| 3.0 * x - 2.0).collect();
        let fit = Regressors::new(&columns).unwrap().fit(&y);
        assert!((fit.coefficients[0] - 3.0).abs() < 1e-9 && (fit.coefficients[1] + 2.0).abs() < 1e-9);
        assert!(fit.unexplained < 1e-12 && fit.sd[2].is_infinite());
    }
}
