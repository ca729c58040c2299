//! The experiment for two model files, on top of a recording or without one.

use super::{Bench, Experiment, Limits, Rival, experiment};
use crate::nominal::under_test;
use trundle_infer::{Comparison, FitOptions, InferError, Watch, fit};
use trundle_model::{Body, Model, Posterior};
use trundle_record::{Dataset, Noise};

/// A model as its file has it.
pub type Written = (Model, Option<Posterior>);

/// An experiment, and the two models at their values.
pub struct Designed {
    /// What to do.
    pub experiment: Experiment,
    /// The models, fitted where there is a recording.
    pub models: [Model; 2],
}

/// What is pushed.
pub enum Object<'a> {
    /// The object of a recording, whose episodes count.
    Recorded(&'a Dataset),
    /// An object that nothing was recorded of: its body, or that of the first model, and the instruments' noise.
    New(Option<Body>, Noise),
}

/// The `count` pushes that best tell two models apart.
///
/// With a recording both are fitted to it, their values being where the search starts. Without one each goes as far as
/// its posterior says, or, where it has none, as the catalogue's priors do.
///
/// # Errors
/// When a model has no value where one is needed or cannot be fitted, or the user interrupts.
pub fn between(
    models: [&Written; 2],
    object: &Object<'_>,
    limits: Limits,
    count: usize,
    watch: &dyn Watch,
) -> Result<Designed, InferError> {
    let names = names([&models[0].0, &models[1].0]);
    let (bench, first, second) = match object {
        Object::Recorded(data) => {
            let comparison = Comparison::of(data)?;
            let of = |k: usize| fitted(&names[k], &models[k].0, data, &comparison, watch);
            let ((first, channels), (second, _)) = (of(0)?, of(1)?);
            (Bench::after(data, &channels, limits), first, second)
        }
        Object::New(body, noise) => {
            let body = body.clone().unwrap_or_else(|| models[0].0.body.clone());
            let of = |k: usize| {
                let (model, posterior) = models[k];
                Rival::of_file(&names[k], &shaped(model, &body), posterior.as_ref())
            };
            let (first, second) = (of(0)?, of(1)?);
            (Bench::bare(body, models[0].0.dof, limits, noise.clone()), first, second)
        }
    };
    let experiment = experiment(&bench, &first, &second, count, watch)?;
    Ok(Designed { experiment, models: [first.model().clone(), second.model().clone()] })
}

fn fitted(
    name: &str,
    model: &Model,
    data: &Dataset,
    comparison: &Comparison,
    watch: &dyn Watch,
) -> Result<(Rival, trundle_infer::Channels), InferError> {
    let (free, given) = under_test(data, Some(model));
    let values: Option<Vec<f64>> = given
        .and_then(|g| g.slots().into_iter().zip(free.slots()).map(|(g, f)| f.value.or(g.value)).collect());
    let starts = if values.is_some() { 1 } else { FitOptions::default().starts };
    let options = FitOptions { starts, distant_starts: values.is_none(), ..FitOptions::default() };
    let fit = fit(comparison, &free, values.as_slice(), &options, watch)?;
    Ok((Rival::fitted(name, &fit), fit.channels))
}

/// The model with the object's shape where its own file has none.
fn shaped(model: &Model, body: &Body) -> Model {
    if !model.body.fixtures.is_empty() {
        return model.clone();
    }
    let mass = model.mass.unwrap_or(body.mass);
    Model { body: Body { mass, ..body.clone() }, mass: Some(mass), ..model.clone() }
}

/// What to call two models: the effects that one has and the other has not, or not as often.
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
        (a, b) if a.is_empty() && b.is_empty() => ["the first".to_owned(), "the second".to_owned()],
        (a, b) if a.is_empty() => [format!("a model without {b}"), b],
        (a, b) if b.is_empty() => [a.clone(), format!("a model without {a}")],
        (a, b) => [a, b],
    }
}
