//! Interface of all comparisons of a model with a recording.

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
    /// Sum of parts over `n` parameters, in the given order.
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

/// A cost whose derivatives are computed on demand.
pub struct Evaluation<'a> {
    /// −log density; infinite where it cannot be evaluated, never NaN.
    pub cost: f64,
    derivatives: Box<dyn FnOnce() -> Result<Linearised, InferError> + 'a>,
}

impl<'a> Evaluation<'a> {
    /// A cost and a function that computes its derivatives.
    pub fn new(cost: f64, derivatives: impl FnOnce() -> Result<Linearised, InferError> + 'a) -> Self {
        Self { cost: if cost.is_nan() { f64::INFINITY } else { cost }, derivatives: Box::new(derivatives) }
    }

    /// A cost whose derivatives are already known.
    pub fn of(at: Linearised) -> Self {
        Self::new(at.cost, || Ok(at))
    }

    /// The cost with its derivatives.
    ///
    /// # Errors
    /// When the computation of the derivatives fails.
    pub fn linearise(self) -> Result<Linearised, InferError> {
        (self.derivatives)()
    }
}

/// Compares a model with a recording.
pub trait Likelihood: Sync {
    /// −log p(data | values). `values` has one entry for each of [`Model::slots`], then one for each of
    /// [`Likelihood::noise`]. Infinite where the model cannot be evaluated.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError>;

    /// The cost with its derivatives by the slots `free`.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError>;

    /// The cost, with derivatives by the slots `free` on demand: a search rejects about half of its steps.
    /// `likely` means that the derivatives are probably required, so that they may be computed at once.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    fn evaluate<'a>(
        &'a self,
        model: &'a Model,
        values: &[f64],
        free: &'a [usize],
        likely: bool,
    ) -> Result<Evaluation<'a>, InferError> {
        if likely {
            return self.linearise(model, values, free).map(Evaluation::of);
        }
        let (cost, values) = (self.cost(model, values)?, values.to_vec());
        Ok(Evaluation::new(cost, move || self.linearise(model, &values, free)))
    }

    /// The assumed noise.
    fn channels(&self) -> Channels;

    /// The same comparison with noise estimated at these values; `None` if the recording states its noise.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    fn tuned(&self, model: &Model, values: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError>;

    /// The likelihood's own parameters, estimated together with those of the model: the noise `σ` of eq. 6.
    fn noise(&self) -> Vec<Slot> {
        vec![]
    }

    /// Better starting values for a search, with all strengths of laws multiplied by one factor; `None` if
    /// the likelihood provides none.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    fn rescaled(&self, model: &Model, values: &[f64]) -> Result<Option<Vec<f64>>, InferError> {
        let _ = (model, values);
        Ok(None)
    }

    /// χ² of the whitened residuals, and their number; zero of both if the likelihood has no such residuals or the
    /// model cannot be evaluated.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    fn chi_squared(&self, model: &Model, values: &[f64]) -> Result<(f64, usize), InferError> {
        let _ = (model, values);
        Ok((0.0, 0))
    }

    /// The same comparison for each episode alone, with its name, in order.
    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)>;

    /// A cheaper comparison with about the same optimum, for ranking starts. It may in turn have a cheaper
    /// one for distant starts. `None` if there is none.
    fn coarse(&self) -> Option<&dyn Likelihood> {
        None
    }
}
