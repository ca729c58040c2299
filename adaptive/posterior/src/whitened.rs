//! A density in coordinates that are whitened at a mode.
//!
//! ```text
//! z = m + L w,   L Lᵀ = H⁻¹        H: Gauss-Newton curvature of −log density at the mode m
//! ```
//!
//! Where the posterior is normal, `w` is standard normal, so that all directions have the same scale and a
//! sampler needs few steps. The map is linear, so it is valid for any posterior.

use nalgebra::{DMatrix, DVector};
use trundle_infer::{Density, InferError};

/// A density over `w`.
pub struct Whitened<'a> {
    density: &'a dyn Density,
    mode: DVector<f64>,
    factor: DMatrix<f64>,
}

impl<'a> Whitened<'a> {
    /// Whitens around `mode` with `precision` there. A precision that is not positive definite leaves the
    /// coordinates unscaled.
    pub fn new(density: &'a dyn Density, mode: &[f64], precision: &DMatrix<f64>) -> Self {
        let n = mode.len();
        let upper = precision.clone().cholesky().and_then(|c| c.l().transpose().try_inverse());
        let factor = upper.unwrap_or_else(|| DMatrix::identity(n, n));
        Self { density, mode: DVector::from_column_slice(mode), factor }
    }

    /// Number of coordinates.
    pub fn dimension(&self) -> usize {
        self.mode.len()
    }

    /// The point `z` of `w`.
    pub fn point(&self, w: &[f64]) -> Vec<f64> {
        let z = &self.mode + &self.factor * DVector::from_column_slice(w);
        z.iter().copied().collect()
    }

    /// −log density at `w`, infinite where it cannot be evaluated.
    ///
    /// # Errors
    /// As [`Density::cost`].
    pub fn cost(&self, w: &[f64]) -> Result<f64, InferError> {
        self.density.cost(&self.point(w))
    }

    /// −log density at `w`, and its gradient by `w` as given by the density.
    ///
    /// # Errors
    /// As [`Density::linearise`].
    pub fn cost_and_gradient(&self, w: &[f64]) -> Result<(f64, DVector<f64>), InferError> {
        let at = self.density.linearise(&self.point(w))?;
        Ok((at.cost, self.factor.tr_mul(&at.gradient)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_densities::Gaussian;

    #[test]
    fn a_normal_density_becomes_standard() {
        let density = Gaussian::correlated(3, 0.9);
        let white = Whitened::new(&density, &[0.0; 3], &density.precision);
        let w = [0.3, -1.2, 2.0];
        let (cost, cost_and_gradient) = white.cost_and_gradient(&w).unwrap();
        assert!((cost - 0.5 * w.iter().map(|x| x * x).sum::<f64>()).abs() < 1e-12);
        assert!(cost_and_gradient.iter().zip(&w).all(|(s, w)| (s - w).abs() < 1e-12));
    }
}
