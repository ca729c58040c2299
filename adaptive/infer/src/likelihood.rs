//! What every comparison of a model with a recording offers.

use crate::{Channels, InferError};
use nalgebra::{DMatrix, DVector};
use trundle_model::{Model, Slot};

/// A cost with its derivatives by some parameters.
pub struct Linearised {
    /// −log p(data | parameters).
    pub cost: f64,
    /// Its gradient.
    pub gradient: DVector<f64>,
    /// The Gauss-Newton approximation of its second derivatives.
    pub curvature: DMatrix<f64>,
}

impl Linearised {
    /// Sum of parts over `n` parameters, in the order given.
    pub(crate) fn sum(n: usize, parts: impl IntoIterator<Item = Self>) -> Self {
        let zero = Self { cost: 0.0, gradient: DVector::zeros(n), curvature: DMatrix::zeros(n, n) };
        parts.into_iter().fold(zero, |mut sum, part| {
            sum.cost += part.cost;
            sum.gradient += part.gradient;
            sum.curvature += part.curvature;
            sum
        })
    }
}

/// Compares a model with a recording.
pub trait Likelihood: Sync {
    /// −log p(data | values), `values` one for each of [`Model::slots`], then one for each of
    /// [`Likelihood::noise`]; infinite where the model cannot be evaluated.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError>;

    /// The cost with its derivatives by the slots `free`.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError>;

    /// The noise that it assumes.
    fn channels(&self) -> Channels;

    /// The same comparison with the noise estimated at these values, where the recording does not
    /// state it; `None` where it does.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    fn tuned(&self, model: &Model, values: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError>;

    /// Parameters of its own, estimated with the model's: the noise `σ` of eq. 6.
    fn noise(&self) -> Vec<Slot> {
        vec![]
    }

    /// The same comparison for each episode alone, with its name, in order.
    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)>;

    /// A cheaper comparison with about the same optimum, to sort starts with, which in turn may have one that leads
    /// there from farther away; `None` where this one is all there is.
    fn coarse(&self) -> Option<&dyn Likelihood> {
        None
    }
}
