//! Profile of one free parameter of a recording.

use serde::Serialize;
use trundle_diagnose::for_recording;
use trundle_infer::{Comparison, Density, FitOptions, InferError, Shape, Target, Watch, fit, profile};
use trundle_model::{Model, PriorFile};
use trundle_record::Dataset;

use crate::EstimateError;

/// Inputs of a profile in addition to the recording.
pub struct ProfileRequest<'a> {
    /// Name of the parameter.
    pub parameter: &'a str,
    /// The model; by default the nominal model of the recording.
    pub model: Option<&'a Model>,
    /// Prior distributions that replace those of the catalogue.
    pub prior: Option<&'a PriorFile>,
    /// Values of the parameter; chosen automatically by default.
    pub grid: Option<&'a [f64]>,
    /// Settings of the search.
    pub options: FitOptions,
}

/// Profile of a parameter, SI units.
#[derive(Clone, Debug, Serialize)]
pub struct ProfileSummary {
    name: String,
    unit: &'static str,
    values: Vec<f64>,
    deviance: Vec<f64>,
    interval: [Option<f64>; 2],
    shape: &'static str,
    modes: Vec<f64>,
    mean: Option<f64>,
    sd: Option<f64>,
}

/// Fits a model and profiles one of its free parameters.
///
/// # Errors
/// If the parameter is not free, the recording has too few data, or the user interrupts.
pub fn profile_recording(
    data: &Dataset,
    request: &ProfileRequest<'_>,
    watch: &dyn Watch,
) -> Result<ProfileSummary, EstimateError> {
    let mut model = for_recording(data, request.model);
    let mut options = request.options.clone();
    if let Some(prior) = request.prior {
        model = prior.apply(&model)?;
        options.per_episode = prior.per_episode();
    }
    let comparison = Comparison::of(data)?;
    // The name is checked before the fit.
    let k = index_of(&Target::new(&comparison, &model, &options.per_episode)?, request.parameter)?;
    let fitted = fit(&comparison, &model, &[], &options, watch)?;
    let comparison = comparison.with_channels(fitted.channels);
    let target = Target::new(&comparison, &model, &options.per_episode)?;
    let found = profile(&target, &fitted, k, request.grid, watch)?;
    let estimate = &fitted.estimates[k];
    let if_identified = |value: f64| estimate.identified.then_some(value);
    Ok(ProfileSummary {
        name: found.name,
        unit: found.unit,
        values: found.values,
        deviance: found.deviance,
        interval: found.interval,
        shape: match found.shape {
            Shape::TwoSided => "two-sided",
            Shape::AtLeast => "at least",
            Shape::AtMost => "at most",
            Shape::Flat => "flat",
        },
        modes: found.modes,
        mean: if_identified(estimate.mean),
        sd: if_identified(estimate.sd),
    })
}

/// Index of a free parameter.
fn index_of(target: &Target<'_>, name: &str) -> Result<usize, InferError> {
    let names: Vec<String> = (0..target.dimension()).map(|k| target.slot(k).name).collect();
    names
        .iter()
        .position(|known| known == name)
        .ok_or_else(|| InferError::NotFree { name: name.to_owned(), free: names.join(", ") })
}
