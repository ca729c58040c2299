//! Linearised models, and starting points of fits.

use nalgebra::{DMatrix, DVector};
use trundle_infer::{FilteredEpisodes, Fit, InferError};
use trundle_model::{Effect, Model};

/// A fitted model's whitened innovations, and their derivatives by parameters and effects.
pub(crate) trait Linearisation: Sync {
    /// All whitened innovations in one vector.
    fn residual(&self) -> DVector<f64>;

    /// Derivatives by every fitted parameter, and its slot if it belongs to the model.
    fn own_derivatives(&self, fit: &Fit) -> Result<(DMatrix<f64>, Vec<Option<usize>>), InferError>;

    /// Derivatives by some slots of a model. At `values` it must be equivalent to the fitted model.
    fn derivatives(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<DMatrix<f64>, InferError>;
}

impl Linearisation for FilteredEpisodes<'_> {
    fn residual(&self) -> DVector<f64> {
        self.residual()
    }

    fn own_derivatives(&self, fit: &Fit) -> Result<(DMatrix<f64>, Vec<Option<usize>>), InferError> {
        let slots = fit.model.slots();
        let free: Vec<usize> =
            fit.estimates.iter().filter_map(|e| slots.iter().position(|s| s.name == e.name)).collect();
        let slopes = self.slopes(&fit.model, &fit.values, &free)?;
        Ok((stacked(&slopes), free.into_iter().map(Some).collect()))
    }

    fn derivatives(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<DMatrix<f64>, InferError> {
        Ok(stacked(&self.slopes(model, values, free)?))
    }
}

/// A starting point for the fit of a candidate.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    /// The candidate with values for all parameters.
    pub effect: Effect,
    /// Values of the fit's own slots.
    pub base: Vec<f64>,
    /// Gain in log likelihood that the Newton step promises, nats.
    pub gain: f64,
    /// The effect before that step.
    pub neutral: Effect,
}

/// Matrices stacked vertically.
fn stacked(parts: &[DMatrix<f64>]) -> DMatrix<f64> {
    let columns = parts.first().map_or(0, DMatrix::ncols);
    let mut all = DMatrix::zeros(parts.iter().map(DMatrix::nrows).sum(), columns);
    let mut row = 0;
    for part in parts {
        all.rows_mut(row, part.nrows()).copy_from(part);
        row += part.nrows();
    }
    all
}
