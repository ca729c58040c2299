//! Experiments for two model files, with or without a recording.

use super::competing_model::CompetingModel;
use super::experiment::{Experiment, experiment};
use super::setup::{Limits, Setup};
use crate::nominal::under_test;
use trundle_infer::{Comparison, FitOptions, InferError, Watch, fit};
use trundle_model::{Body, Model, Posterior};
use trundle_record::{Dataset, Noise};

/// A model and its posterior, as read from a file.
pub type ModelFile = (Model, Option<Posterior>);

/// A designed experiment, and the two models with their values.
pub struct DesignedExperiment {
    /// The experiment.
    pub experiment: Experiment,
    /// The models, fitted to the recording if there is one.
    pub models: [Model; 2],
}

/// The object of an experiment.
pub enum PushedObject<'a> {
    /// The object of a recording, whose episodes count as data.
    Recorded(&'a Dataset),
    /// An object without a recording: its body, else that of the first model, and the noise of the instruments.
    New(Option<Body>, Noise),
}

/// Designs the `count` pushes that best discriminate between two models.
///
/// With a recording, both models are fitted to it, starting from their values. Without one, the posterior of a
/// model limits its parameters, or the catalogue's priors if it has none.
///
/// # Errors
/// If a required value of a model is missing, or a model cannot be fitted, or if the user interrupts.
pub fn design_experiment(
    models: [&ModelFile; 2],
    object: &PushedObject<'_>,
    limits: Limits,
    count: usize,
    watch: &dyn Watch,
) -> Result<DesignedExperiment, InferError> {
    let names = names([&models[0].0, &models[1].0]);
    let (setup, first, second) = match object {
        PushedObject::Recorded(data) => {
            let comparison = Comparison::of(data)?;
            let of = |k: usize| fit_model(&names[k], &models[k].0, data, &comparison, watch);
            let ((first, channels), (second, _)) = (of(0)?, of(1)?);
            (Setup::from_recording(data, &channels, limits), first, second)
        }
        PushedObject::New(body, noise) => {
            let body = body.clone().unwrap_or_else(|| models[0].0.body.clone());
            let of = |k: usize| {
                let (model, posterior) = models[k];
                CompetingModel::from_file(&names[k], &with_shape(model, &body), posterior.as_ref())
            };
            let (first, second) = (of(0)?, of(1)?);
            (Setup::without_recording(body, models[0].0.dof, limits, noise.clone()), first, second)
        }
    };
    let experiment = experiment(&setup, &first, &second, count, watch)?;
    Ok(DesignedExperiment { experiment, models: [first.model().clone(), second.model().clone()] })
}

fn fit_model(
    name: &str,
    model: &Model,
    data: &Dataset,
    comparison: &Comparison,
    watch: &dyn Watch,
) -> Result<(CompetingModel, trundle_infer::Channels), InferError> {
    let (free, given) = under_test(data, Some(model));
    let values: Option<Vec<f64>> = given
        .and_then(|g| g.slots().into_iter().zip(free.slots()).map(|(g, f)| f.value.or(g.value)).collect());
    let starts = if values.is_some() { 1 } else { FitOptions::default().starts };
    let options = FitOptions { starts, distant_starts: values.is_none(), ..FitOptions::default() };
    let fit = fit(comparison, &free, values.as_slice(), &options, watch)?;
    Ok((CompetingModel::from_fit(name, &fit), fit.channels))
}

/// The model with the given body if its own file has no shape.
fn with_shape(model: &Model, body: &Body) -> Model {
    if !model.body.fixtures.is_empty() {
        return model.clone();
    }
    let mass = model.mass.unwrap_or(body.mass);
    Model { body: Body { mass, ..body.clone() }, mass: Some(mass), ..model.clone() }
}

/// Names of two models: the effects that one has and the other has not, or has less often.
fn names([first, second]: [&Model; 2]) -> [String; 2] {
    let own = |model: &Model, other: &Model| -> String {
        let mut others: Vec<_> = other.effects.iter().map(|e| e.kind).collect();
        let mut names: Vec<&str> = Vec::new();
        for effect in &model.effects {
            match others.iter().position(|kind| *kind == effect.kind) {
                Some(k) => {
                    others.swap_remove(k);
                }
                None => names.push(effect.kind.spec().effect),
            }
        }
        names.join(" + ")
    };
    match (own(first, second), own(second, first)) {
        (a, b) if a.is_empty() && b.is_empty() => {
            ["the first model".to_owned(), "the second model".to_owned()]
        }
        (a, b) if a.is_empty() => [format!("a model without {b}"), b],
        (a, b) if b.is_empty() => [a.clone(), format!("a model without {a}")],
        (a, b) => [a, b],
    }
}
