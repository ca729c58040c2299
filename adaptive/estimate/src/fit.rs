//! Fit of a model to one or several recordings, with its summary.

use std::collections::BTreeMap;

use trundle_diagnose::for_recording;
use trundle_infer::{Fit, FitOptions, Watch, score};
use trundle_model::{Model, Posterior, PriorFile, Stepper};
use trundle_record::{Dataset, Prepared};

use crate::checked_fit::CheckedFit;
use crate::likelihood::{LikelihoodChoice, LikelihoodKind, LikelihoodOptions};
use crate::recordings::merged;
use crate::start::start_values;
use crate::summary::{FitSummary, NoiseSummary, parameters};
use crate::{EstimateError, IdentifiabilitySummary};

/// Inputs of a fit in addition to the recordings.
pub struct FitRequest<'a> {
    /// The model; by default the nominal model of the recording.
    pub model: Option<&'a Model>,
    /// Prior distributions that replace those of the catalogue.
    pub prior: Option<&'a PriorFile>,
    /// Values of all free parameters at which the search also starts.
    pub start: Option<&'a BTreeMap<String, f64>>,
    /// Likelihood.
    pub likelihood: LikelihoodOptions,
    /// Simulator in place of the laws.
    pub simulator: Option<&'a dyn Stepper>,
    /// Settings of the search.
    pub options: FitOptions,
}

/// A fitted model with its summary.
#[derive(Clone, Debug)]
pub struct FitReport {
    /// The model with all values.
    pub model: Model,
    /// Posterior of the model's parameters; `None` if none is identified.
    pub posterior: Option<Posterior>,
    /// Summary.
    pub summary: FitSummary,
}

/// Fits a model to the training episodes of recordings of one object (see [`crate::combined`]).
///
/// # Errors
/// If an argument is invalid, a recording has too few data, or the user interrupts.
pub fn fit_recordings(
    recordings: &[Dataset],
    request: &FitRequest<'_>,
    watch: &dyn Watch,
) -> Result<FitReport, EstimateError> {
    let data = merged(recordings)?;
    let mut model = for_recording(&data, request.model);
    let mut options = request.options.clone();
    if let Some(prior) = request.prior {
        model = prior.apply(&model)?;
        options.per_episode.extend(prior.per_episode());
    }
    let choice = LikelihoodChoice::new(&request.likelihood, recordings, &model, request.simulator)?;
    let start = request.start.map(|start| start_values(&model, start)).transpose()?;
    let fit = choice.fit(&model, start.as_slice(), &options, watch)?;
    let can_test = choice.kind() == LikelihoodKind::Filter && options.per_episode.is_empty();
    let mut checked =
        if can_test { CheckedFit::new(recordings, &model, fit)? } else { CheckedFit::untested(fit) };
    let is_excluded = reject_if_excluded(&mut checked.fit);
    let summary = summary(&data, &checked, &choice, is_excluded)?;
    Ok(FitReport { model: checked.fit.model.clone(), posterior: model_posterior(&checked.fit), summary })
}

/// If a prior set by the user conflicts with the data, no parameter counts as identified, because the others
/// compensate for it. Returns whether that is the case.
fn reject_if_excluded(fit: &mut Fit) -> bool {
    let base = |name: &str| name.split('[').next().unwrap_or(name).to_owned();
    let is_excluded =
        fit.prior_conflicts.iter().any(|conflict| fit.model.priors.contains_key(&base(&conflict.name)));
    for estimate in &mut fit.estimates {
        estimate.identified &= !is_excluded;
    }
    is_excluded
}

/// The posterior of the model's parameters, without the noise of the likelihood.
fn model_posterior(fit: &Fit) -> Option<Posterior> {
    let posterior = fit.posterior()?;
    let kept: Vec<usize> =
        (0..posterior.names.len()).filter(|&k| !posterior.names[k].starts_with("noise.")).collect();
    let row = |i: &usize| kept.iter().map(|&j| posterior.covariance[*i][j]).collect();
    (!kept.is_empty()).then(|| Posterior {
        names: kept.iter().map(|&k| posterior.names[k].clone()).collect(),
        mean: kept.iter().map(|&k| posterior.mean[k]).collect(),
        covariance: kept.iter().map(row).collect(),
    })
}

fn summary(
    data: &Dataset,
    checked: &CheckedFit,
    choice: &LikelihoodChoice<'_>,
    is_excluded: bool,
) -> Result<FitSummary, EstimateError> {
    let (fit, quasi_static) = (&checked.fit, choice.is_quasi_static());
    let score_of = |episodes: &[Prepared]| {
        score(&fit.model, &fit.values, &fit.channels, episodes, &data.noise, quasi_static)
    };
    let held_out = (!data.held_out.is_empty()).then(|| score_of(&data.held_out)).transpose()?;
    Ok(FitSummary {
        recording: data.name.clone(),
        parameters: parameters(checked),
        log_evidence: fit.log_evidence,
        converged: fit.converged,
        quasi_static,
        lack_of_fit: checked.check.map(Into::into),
        intervals: checked.basis.into(),
        noise: NoiseSummary::new(&fit.channels, data),
        training: score_of(&data.training)?,
        held_out,
        excluded_by_prior: fit.prior_conflicts.iter().map(ToString::to_string).collect(),
        identifiability: (!is_excluded).then(|| IdentifiabilitySummary::from(fit)),
        likelihood: choice.kind().name(),
        loss: choice.loss(),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
