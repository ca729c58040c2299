//! Quadratic expansion in `z` of the −log likelihood of a push: the information form of a Gaussian.

use crate::target::prior_of;
use crate::{Coordinates, InferError, Likelihood};
use nalgebra::{DMatrix, DVector};
use trundle_model::Model;

/// `cost + gradient·(z − at) + ½ (z − at)ᵀ curvature (z − at)`.
#[derive(Clone, Debug)]
pub(super) struct Quadratic {
    pub at: DVector<f64>,
    pub cost: f64,
    pub gradient: DVector<f64>,
    pub curvature: DMatrix<f64>,
}

impl Quadratic {
    pub fn zero(n: usize) -> Self {
        let (at, gradient) = (DVector::zeros(n), DVector::zeros(n));
        Self { at, cost: 0.0, gradient, curvature: DMatrix::zeros(n, n) }
    }

    /// A likelihood's expansion at `z`, with Gauss-Newton curvature.
    pub fn of(
        likelihood: &dyn Likelihood,
        model: &Model,
        coordinates: &Coordinates,
        z: &DVector<f64>,
    ) -> Result<Self, InferError> {
        let (values, slopes) = coordinates.values(z.as_slice());
        let at = likelihood.linearise(model, &values, coordinates.free())?;
        let slopes = DVector::from_vec(slopes);
        let curvature =
            DMatrix::from_fn(z.len(), z.len(), |i, j| at.curvature[(i, j)] * slopes[i] * slopes[j]);
        let cost = if at.cost.is_nan() { f64::INFINITY } else { at.cost };
        Ok(Self { at: z.clone(), cost, gradient: at.gradient.component_mul(&slopes), curvature })
    }

    /// Exact expansion of the prior at `z`.
    pub fn of_prior(coordinates: &Coordinates, z: &DVector<f64>) -> Self {
        let parameters: Vec<usize> = (0..z.len()).collect();
        let footprint_priors = coordinates.footprint_priors().iter().enumerate();
        let terms = footprint_priors
            .map(|(k, footprint_prior)| (k, coordinates.coordinates_of(footprint_prior)))
            .collect();
        let prior = prior_of(coordinates, &parameters, &terms, z.as_slice());
        Self { at: z.clone(), cost: prior.cost, gradient: prior.gradient, curvature: prior.curvature }
    }

    /// Value and gradient at `z`.
    pub fn value(&self, z: &DVector<f64>) -> (f64, DVector<f64>) {
        let d = z - &self.at;
        let turned = &self.curvature * &d;
        (self.cost + self.gradient.dot(&d) + 0.5 * d.dot(&turned), &self.gradient + turned)
    }

    /// The same function, expanded at `z`.
    pub fn moved(&self, z: &DVector<f64>) -> Self {
        let (cost, gradient) = self.value(z);
        Self { at: z.clone(), cost, gradient, curvature: self.curvature.clone() }
    }

    /// Adds another expansion, moved to this one's point.
    pub fn add(&mut self, other: &Self) {
        let (cost, gradient) = other.value(&self.at);
        self.cost += cost;
        self.gradient += gradient;
        self.curvature += &other.curvature;
    }
}
