//! Draws of a posterior, with the lack-of-fit test at the best mode and a summary.

use serde::Serialize;
use trundle_diagnose::{FitCheck, check_fit, for_recording};
use trundle_infer::{Comparison, Watch};
use trundle_model::{Model, PriorFile};
use trundle_posterior::{ModeSummary, PointwiseLogLikelihood, Posterior, SampleOptions, sample};
use trundle_record::Dataset;

use crate::EstimateError;
use crate::checked_fit::LackOfFitSummary;
use crate::summary::NoiseSummary;

/// Inputs of sampling in addition to the recording.
pub struct SampleRequest<'a> {
    /// The model; by default the nominal model of the recording.
    pub model: Option<&'a Model>,
    /// Prior distributions that replace those of the catalogue.
    pub prior: Option<&'a PriorFile>,
    /// Settings of the search and of the sampler.
    pub options: SampleOptions,
}

/// Draws of a posterior, with the result of the lack-of-fit test.
#[derive(Clone, Debug)]
pub struct SampledPosterior {
    /// The draws.
    pub posterior: Posterior,
    /// Whether wrenches are compared because inertia is negligible.
    pub quasi_static: bool,
    /// Result of the test at the best mode; `None` if a parameter has a value for each episode.
    pub check: Option<FitCheck>,
}

/// Samples the posterior of a model's free parameters.
///
/// # Errors
/// If a setting is invalid, no parameter is free, the recording has too few data, or the user interrupts.
pub fn sample_recording(
    data: &Dataset,
    request: &SampleRequest<'_>,
    watch: &dyn Watch,
) -> Result<SampledPosterior, EstimateError> {
    let mut model = for_recording(data, request.model);
    let mut options = request.options.clone();
    if let Some(prior) = request.prior {
        model = prior.apply(&model)?;
        options.fit.per_episode = prior.per_episode();
    }
    let comparison = Comparison::of(data)?;
    let posterior = sample(&comparison, &model, &options, watch)?;
    let is_shared = options.fit.per_episode.is_empty();
    let check = if is_shared { check_fit(data, &comparison, &posterior.fit)? } else { None };
    Ok(SampledPosterior { posterior, quasi_static: comparison.is_quasi_static(), check })
}

/// Settings, parameters, noise and costs of a run.
#[derive(Clone, Debug, Serialize)]
pub struct SampleSummary {
    acceptance: Vec<Option<f64>>,
    /// Parameters with a prior-data conflict, in words.
    excluded_by_prior: Vec<String>,
    /// Result of the lack-of-fit test; `None` without one.
    lack_of_fit: Option<LackOfFitSummary>,
    modes: Vec<ModeSummary>,
    noise: NoiseSummary,
    parameters: Vec<SampledParameter>,
    quasi_static: bool,
    recording: String,
    step_sizes: Vec<f64>,
    /// Evaluations of the density during the warm-up of all chains.
    warmup_evaluations: u64,
}

/// A sampled parameter.
#[derive(Clone, Debug, Serialize)]
pub struct SampledParameter {
    identifiable: bool,
    name: String,
    unit: &'static str,
}

impl SampledPosterior {
    /// Summary of the run on a recording.
    pub fn summary(&self, data: &Dataset) -> SampleSummary {
        let posterior = &self.posterior;
        let parameter = |(slot, identified): (&trundle_model::Slot, &bool)| SampledParameter {
            identifiable: *identified,
            name: slot.name.clone(),
            unit: slot.unit,
        };
        SampleSummary {
            acceptance: posterior.chains.iter().map(|chain| chain.acceptance).collect(),
            excluded_by_prior: posterior.prior_conflicts.clone(),
            lack_of_fit: self.check.map(LackOfFitSummary::from),
            modes: posterior.modes.clone(),
            noise: NoiseSummary::new(&posterior.channels, data),
            parameters: posterior.slots.iter().zip(&posterior.identified).map(parameter).collect(),
            quasi_static: self.quasi_static,
            recording: data.name.clone(),
            step_sizes: posterior.chains.iter().map(|chain| chain.step_size).collect(),
            warmup_evaluations: posterior.chains.iter().map(|chain| chain.warmup_evaluations).sum(),
        }
    }

    /// Log likelihood of each training episode at each draw.
    ///
    /// # Errors
    /// If the recording has too few data.
    pub fn log_likelihood(&self, data: &Dataset) -> Result<PointwiseLogLikelihood, EstimateError> {
        let likelihood = Comparison::of(data)?.with_channels(self.posterior.channels);
        Ok(self.posterior.log_likelihood(&likelihood)?)
    }
}
