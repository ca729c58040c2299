//! The nominal model: as given, with its values free, and as fitted.

use crate::parameter::Parameter;
use std::collections::BTreeMap;
use trundle_infer::{Comparison, Fit, FitOptions, InferError, Watch};
use trundle_model::{Body, Effect, Model};
use trundle_record::Dataset;

/// The model of a recording's object: a model file's model, completed by the recording's directions, shape
/// and feet; the paper's model without a file.
pub fn for_recording(data: &Dataset, model: Option<&Model>) -> Model {
    let Some(model) = model else {
        return Model::nominal(data.body.clone(), data.mass_given, data.dof);
    };
    let mut model = Model { dof: data.dof, ..model.clone() };
    if model.body.fixtures.is_empty() {
        let mass = model.mass.unwrap_or(data.body.mass);
        model.body = Body { mass, ..data.body.clone() };
    }
    if let (None, Some(feet)) = (&model.body.feet, &data.body.feet) {
        model.body = model.body.with_feet(feet);
    }
    model
}

/// The nominal model with its values free, and as given if any value is given.
pub(crate) fn under_test(data: &Dataset, model: Option<&Model>) -> (Model, Option<Model>) {
    let given = for_recording(data, model);
    let mut free = given.clone();
    free.mass = data.mass_given;
    free.body.mass = data.mass_given.or(given.mass).unwrap_or(data.body.mass);
    for effect in &mut free.effects {
        let params = effect.kind.spec().params;
        for (value, _) in effect.values.iter_mut().zip(params).filter(|(_, p)| p.refinement.is_none()) {
            *value = None;
        }
    }
    let has_values =
        model.is_some_and(|m| m.mass.is_some() || m.effects.iter().any(|e| *e != Effect::free(e.kind)));
    (free, has_values.then_some(given))
}

/// Fit the values that a given model leaves free.
pub(crate) fn as_given(comparison: &Comparison, given: &Model, watch: &dyn Watch) -> Result<Fit, InferError> {
    trundle_infer::fit(comparison, given, &[], &FitOptions::default(), watch)
}

/// The given values of the nominal model.
pub(crate) fn given_values(fit: &Fit) -> BTreeMap<String, f64> {
    let free = |name: &str| fit.estimate(name).is_some();
    let slots = fit.model.slots();
    slots.into_iter().filter(|s| !free(&s.name)).filter_map(|s| Some((short(&s.name), s.value?))).collect()
}

/// The name without the prefix `body.`.
fn short(name: &str) -> String {
    name.strip_prefix("body.").unwrap_or(name).to_owned()
}

/// Parameters of the nominal model within a fit.
pub(crate) fn parameters(fit: &Fit, nominal: &Model) -> BTreeMap<String, Parameter> {
    let own: Vec<String> = nominal.slots().into_iter().map(|s| s.name).collect();
    let one = |e: &trundle_infer::Estimate| {
        let kept = |value: f64| e.identified.then_some(value);
        let parameter =
            Parameter { mean: kept(e.mean), sd: kept(e.sd), unit: e.unit, identifiable: e.identified };
        (short(&e.name), parameter)
    };
    fit.estimates.iter().filter(|e| own.contains(&e.name)).map(one).collect()
}
