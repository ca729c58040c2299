//! Fits of a discrepancy wrench.

use super::regression::Regression;
use super::training_set::TrainingSet;
use crate::fitted_model::MAX_FIT_STEPS;
use std::sync::Arc;
use trundle_infer::{Fit, FitOptions, InferError, MotionLikelihood, Watch, fit};
use trundle_model::{Discrepancy, Model};
use trundle_record::Dataset;

/// Data and settings for fits of a discrepancy.
pub(super) struct Fitter<'a> {
    pub data: &'a Dataset,
    /// Nominal model with free parameters.
    pub nominal: &'a Model,
    /// Likelihood whose noise includes the random walk that the discrepancy leaves.
    pub motion: &'a MotionLikelihood,
    /// Fit of the nominal model.
    pub fit: &'a Fit,
    pub watch: &'a dyn Watch,
}

impl Fitter<'_> {
    /// Fits the wrench to all training episodes or all but one, then the parameters and the wrench alternately for
    /// `rounds` rounds. Without these rounds, the bias of the parameters due to the discrepancy remains.
    pub fn fit(
        &self,
        without: Option<usize>,
        by: &Regression,
        rounds: usize,
    ) -> Result<Option<Fit>, InferError> {
        let motion = self.motion.only(|k| Some(k) != without);
        let Some(unnamed) = by.discrepancy(without) else { return Ok(None) };
        let mut best = with_discrepancy(self.fit, unnamed);
        for _ in 0..rounds {
            let mut bare = self.refitted(&motion, &best, without.is_none())?;
            bare.model.discrepancy = None;
            let updated = TrainingSet::new(&motion, &bare)?
                .and_then(|training| by.relinearised(&training)?.discrepancy(None));
            let Some(unnamed) = updated else { break };
            best = with_discrepancy(&bare, unnamed);
        }
        Ok(Some(best))
    }

    /// Refits the parameters with the discrepancy wrench of `from`, and unstated noise if the fit is the final one.
    fn refitted(&self, motion: &MotionLikelihood, from: &Fit, is_final: bool) -> Result<Fit, InferError> {
        let model = Model { discrepancy: from.model.discrepancy.clone(), ..self.nominal.clone() };
        let local = FitOptions {
            starts: 0,
            distant_starts: false,
            local_steps: Some(MAX_FIT_STEPS),
            ..FitOptions::default()
        };
        let options = if is_final { local } else { FitOptions { noise_rounds: 0, ..local } };
        fit(motion, &model, std::slice::from_ref(&from.values), &options, self.watch)
    }
}

/// Adds a discrepancy wrench to the model of a fit.
fn with_discrepancy(fit: &Fit, unnamed: Discrepancy) -> Fit {
    let mut fit = fit.clone();
    fit.model.discrepancy = Some(Arc::new(unnamed));
    fit
}
