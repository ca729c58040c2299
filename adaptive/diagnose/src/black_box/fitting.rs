//! Fits of laws along the measured motion.

use super::basis::Basis;
use super::engine::BlackBoxEngine;
use super::laws::has_laws_on_object;
use super::likelihood::PathLikelihood;
use crate::fitted_model::{Effort, FittedModel, Job};
use rayon::prelude::*;
use std::sync::Arc;
use trundle_infer::{Fit, FitOptions, InferError, Watch, fit};
use trundle_model::Model;

/// Refits of laws on the object. Each uses the uncertainty of the laws' wrenches at the fit before it.
const UNCERTAINTY_REFITS: usize = 2;
/// Number of starts that the search proposes per place of an effect.
const STARTS_PER_PLACE: usize = 4;
/// Maximum number of further linearisations of one model.
const MAX_LINEARISATIONS: usize = 4;
/// Relative change of a simulator parameter below which the linearisation is accepted.
const MAX_RELATIVE_CHANGE: f64 = 0.03;

impl BlackBoxEngine<'_> {
    /// Fits laws to the linearised simulator. A full fit relinearises the simulator at the fitted parameters.
    pub(super) fn fit_laws(
        &self,
        job: Job,
        effort: Effort,
        seed: u64,
        watch: &dyn Watch,
    ) -> Result<FittedModel, InferError> {
        let mut model = self.bare.clone();
        model.effects.extend(job.added.iter().cloned());
        let near = Some(effort.steps());
        let options =
            FitOptions { starts: 0, seed, distant_starts: false, local_steps: near, ..FitOptions::default() };
        let (mut likelihood, parameters) = match job.basis {
            Some(Basis { likelihood, parameters, is_biased: false }) => (likelihood, parameters),
            _ => (self.likelihood.clone(), self.likelihood.values.clone()),
        };
        if likelihood.channels != job.channels {
            likelihood = Arc::new(likelihood.with_channels(job.channels).with_subset());
        }
        let start = |laws: &Vec<f64>| laws.iter().chain(&parameters).copied().collect();
        let starts: Vec<Vec<f64>> = job.warm.iter().map(start).collect();
        // Follow the starts of every place: the first cost does not show which place is best.
        let one = |starts: &[Vec<f64>]| fit_at_linearisation(&likelihood, &model, starts, &options, watch);
        let all = starts.par_chunks(STARTS_PER_PLACE).map(one).collect::<Result<Vec<_>, InferError>>()?;
        let best = all.into_iter().min_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
        let Some(mut found) = best else {
            return Err(InferError::NoStart { recording: self.data.name.clone(), starts: 0 });
        };
        let linearisations = if effort == Effort::Full { MAX_LINEARISATIONS } else { 0 };
        for _ in 0..linearisations {
            let values = likelihood.trust_region_values(&found);
            let is_converged = |(a, b): (&f64, &f64)| (a - b).abs() < MAX_RELATIVE_CHANGE * b.abs().max(1e-9);
            if values.iter().zip(&likelihood.values).all(is_converged) {
                break;
            }
            let dof = self.bare.dof;
            let updated =
                PathLikelihood::new(self.simulator, &values, &self.paths, likelihood.channels, dof, watch)?;
            likelihood = Arc::new(updated);
            let at: Vec<f64> = found.values.iter().chain(&values).copied().collect();
            found = fit_at_linearisation(&likelihood, &model, &[at], &options, watch)?;
        }
        let parameters = likelihood.parameter_values(&found);
        Ok(FittedModel::new(job.added, found, Some(Basis { likelihood, parameters, is_biased: false })))
    }
}

/// Fits laws together with the simulator's parameters, at one linearisation.
fn fit_at_linearisation(
    likelihood: &PathLikelihood,
    model: &Model,
    starts: &[Vec<f64>],
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Fit, InferError> {
    let mut found = fit(likelihood, model, starts, options, watch)?;
    if !has_laws_on_object(model) {
        return Ok(found);
    }
    for _ in 0..UNCERTAINTY_REFITS {
        let parameters = likelihood.parameter_values(&found);
        let uncertain = likelihood.with_law_uncertainty(&found.model.plant(&found.values)?, &parameters);
        let at: Vec<f64> = found.values.iter().copied().chain(parameters).collect();
        found = fit(&uncertain, model, &[at], options, watch)?;
    }
    Ok(found)
}
