//! The nominal model: as given, with its values free, and as fitted.

use crate::parameter::Parameter;
use std::collections::BTreeMap;
use trundle_infer::{Comparison, Fit, FitOptions, InferError, Likelihood, Watch};
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

/// The fit of the nominal model with a random-walk wrench of the size of the recorded one, under the noise that it has
/// without; `None` if wrenches are compared instead of motion.
///
/// A fit without the walk can end where even the sizes of parameters are wrong, above all if the noise is not stated: a
/// fiftieth of the mass, for example, whose motion then passes for noise of the readings.
///
/// The evidence stays that of `base`, because densities with and without the walk are not comparable.
pub(crate) fn undistorted(
    comparison: &Comparison,
    nominal: &Model,
    base: &Fit,
    seed: u64,
    watch: &dyn Watch,
) -> Result<Option<Fit>, InferError> {
    let Comparison::Motion(motion) = comparison else { return Ok(None) };
    let options = FitOptions { seed, ..FitOptions::default() };
    let warm = std::slice::from_ref(&base.values);
    let found = trundle_infer::fit(&motion.softened(1.0), nominal, warm, &options, watch)?;
    let under = comparison.with_tuned_noise(&found.model, &found.values)?;
    let cost = under.cost(&found.model, &found.values)?;
    Ok(Some(Fit { cost, log_evidence: base.log_evidence, channels: under.channels(), ..found }))
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::engine::Engine;
    use crate::engine::plant_engine::PlantEngine;
    use trundle_fixtures::{World, locked};
    use trundle_infer::Quiet;
    use trundle_model::{State, to_body};

    /// A spring of 20 N/m that pulls to the origin.
    fn spring(state: &State<f64>) -> [f64; 3] {
        let [x, y, theta] = state.pose;
        to_body([-20.0 * x, -20.0 * y, 0.0], theta)
    }

    #[test]
    fn a_random_walk_wrench_keeps_a_missing_spring_out_of_the_mass() {
        let world = World { out_of_catalogue: spring, ..World::of(locked()) };
        let mass = locked().mass.unwrap();
        for stated in [true, false] {
            let mut data = world.recording(1);
            data.noise.stated = stated;
            let engine = PlantEngine::new(&data, None).unwrap();
            let base = engine.base(0, &Quiet).unwrap();
            let found = engine.undistorted(&base, 0, &Quiet).unwrap().unwrap();
            let [before, after] = [&base, &found].map(|fitted| fitted.fit.model.body.mass / mass);
            assert!(before < 0.5 && after > 0.7 && after < 1.1, "stated {stated}: {before}, {after}");
        }
    }

    #[test]
    fn a_nominal_model_that_lacks_nothing_is_kept() {
        let data = World::of(locked()).recording(1);
        let engine = PlantEngine::new(&data, None).unwrap();
        let base = engine.base(0, &Quiet).unwrap();
        assert!(engine.undistorted(&base, 0, &Quiet).unwrap().is_none());
    }
}
