//! Whether an unnamed wrench predicts: one second ahead, on training episodes that it was not fitted to.

use super::regression::Regression;
use super::with;
use rayon::prelude::*;
use trundle_infer::{Fit, InferError, windows};
use trundle_record::{Dataset, Prepared};

/// Share of the mean square error that it may leave, at most.
const LEAVES: f64 = 0.9;

/// What the simulation under test errs by itself.
pub(super) struct Proof {
    /// Mean square error of each training episode, m².
    before: Vec<f64>,
}

impl Proof {
    /// Of a fit without an unnamed wrench.
    ///
    /// # Errors
    /// When the fit's values do not suit its model.
    pub fn new(data: &Dataset, fit: &Fit) -> Result<Self, InferError> {
        let before = data.training.par_iter().map(|e| error(data, fit, e)).collect::<Result<_, _>>()?;
        Ok(Self { before })
    }

    /// Share of the mean square error that is left where each episode is predicted by what the others taught; `None`
    /// where that is too much, or more than before in every other episode.
    ///
    /// # Errors
    /// When the fit's values do not suit its model.
    pub fn share(&self, data: &Dataset, fit: &Fit, by: &Regression) -> Result<Option<f64>, InferError> {
        let one = |(k, episode): (usize, &Prepared)| match by.unnamed(Some(k)) {
            Some(unnamed) => error(data, &with(fit, unnamed), episode),
            None => Ok(f64::INFINITY),
        };
        let after = data.training.par_iter().enumerate().map(one).collect::<Result<Vec<_>, _>>()?;
        let better = after.iter().zip(&self.before).filter(|(after, before)| after < before).count();
        let share = after.iter().sum::<f64>() / self.before.iter().sum::<f64>();
        Ok((share < LEAVES && 2 * better > after.len()).then_some(share))
    }
}

/// Mean square of the errors within windows of a second, m², a turn counted at the radius of gyration.
fn error(data: &Dataset, fit: &Fit, episode: &Prepared) -> Result<f64, InferError> {
    let rho = if data.dof[2] { fit.model.body.gyration } else { 0.0 };
    let (mut sum, mut count) = (0.0, 0.0);
    for window in windows(&fit.model, &fit.values, &fit.channels, episode, &data.noise)? {
        let Some(window) = window else { return Ok(f64::INFINITY) };
        for sample in &window.samples {
            let [x, y, theta] = sample.error.into();
            sum += x * x + y * y + (rho * theta).powi(2);
            count += 1.0;
        }
    }
    Ok(if count > 0.0 { sum / count } else { 0.0 })
}
