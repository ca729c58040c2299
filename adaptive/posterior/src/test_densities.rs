//! Test densities with known moments.

use nalgebra::{DMatrix, DVector};
use trundle_infer::{Density, InferError, Linearised};

/// A centred normal density.
pub(crate) struct Gaussian {
    pub precision: DMatrix<f64>,
}

impl Gaussian {
    /// Unit variances and equal correlations.
    pub fn correlated(n: usize, correlation: f64) -> Self {
        let covariance = DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { correlation });
        Self { precision: covariance.try_inverse().unwrap() }
    }
}

impl Density for Gaussian {
    fn dimension(&self) -> usize {
        self.precision.nrows()
    }

    fn cost(&self, z: &[f64]) -> Result<f64, InferError> {
        let z = DVector::from_column_slice(z);
        Ok(0.5 * z.dot(&(&self.precision * &z)))
    }

    fn linearise(&self, z: &[f64]) -> Result<Linearised, InferError> {
        let gradient = &self.precision * DVector::from_column_slice(z);
        Ok(Linearised { cost: self.cost(z)?, gradient, curvature: self.precision.clone() })
    }
}

/// A banana-shaped density: `x` is standard normal, and `y` is normal about `x²/2` with unit variance. Its
/// gradient is too steep by the factor `wrong`.
pub(crate) struct Banana {
    pub wrong: f64,
}

impl Density for Banana {
    fn dimension(&self) -> usize {
        2
    }

    fn cost(&self, z: &[f64]) -> Result<f64, InferError> {
        Ok(0.5 * z[0] * z[0] + 0.5 * (z[1] - 0.5 * z[0] * z[0]).powi(2))
    }

    fn linearise(&self, z: &[f64]) -> Result<Linearised, InferError> {
        let bend = z[1] - 0.5 * z[0] * z[0];
        let gradient = DVector::from_vec(vec![z[0] - z[0] * bend, bend]) * self.wrong;
        let curvature = DMatrix::identity(2, 2);
        Ok(Linearised { cost: self.cost(z)?, gradient, curvature })
    }
}
