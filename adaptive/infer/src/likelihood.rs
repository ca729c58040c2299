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

/// A cost, and what it takes to differentiate it there.
pub struct Look<'a> {
    /// −log density; infinite where it cannot be evaluated, never NaN.
    pub cost: f64,
    rest: Box<dyn FnOnce() -> Result<Linearised, InferError> + 'a>,
}

impl<'a> Look<'a> {
    /// A cost, and how its derivatives come about.
    pub fn new(cost: f64, rest: impl FnOnce() -> Result<Linearised, InferError> + 'a) -> Self {
        Self { cost: if cost.is_nan() { f64::INFINITY } else { cost }, rest: Box::new(rest) }
    }

    /// Derivatives that are known already.
    pub fn known(at: Linearised) -> Self {
        Self::new(at.cost, || Ok(at))
    }

    /// The cost with its derivatives.
    ///
    /// # Errors
    /// As what is looked at.
    pub fn linearise(self) -> Result<Linearised, InferError> {
        (self.rest)()
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

    /// The cost, with its derivatives by the slots `free` to be asked for afterwards: half of the steps that a search
    /// tries are not taken. `likely`: they will be, so that it may work them out at once.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    fn look<'a>(
        &'a self,
        model: &'a Model,
        values: &[f64],
        free: &'a [usize],
        likely: bool,
    ) -> Result<Look<'a>, InferError> {
        if likely {
            return self.linearise(model, values, free).map(Look::known);
        }
        let (cost, values) = (self.cost(model, values)?, values.to_vec());
        Ok(Look::new(cost, move || self.linearise(model, &values, free)))
    }

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

    /// Values from which a search had better start than from `values`: with all strengths of laws multiplied by one factor.
    /// `None` where there are no such.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    fn rescaled(&self, model: &Model, values: &[f64]) -> Result<Option<Vec<f64>>, InferError> {
        let _ = (model, values);
        Ok(None)
    }

    /// The same comparison for each episode alone, with its name, in order.
    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)>;

    /// A cheaper comparison with about the same optimum, to sort starts with, which in turn may have one that leads
    /// there from farther away; `None` where this one is all there is.
    fn coarse(&self) -> Option<&dyn Likelihood> {
        None
    }
}
