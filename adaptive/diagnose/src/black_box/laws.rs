//! The rigid body and the laws that are added to a black-box simulator.

use crate::fitted_model::FittedModel;
use trundle_infer::InferError;
use trundle_model::{EffectTarget, Kind, Model, Plant};
use trundle_record::Dataset;

/// Plant with the laws of a model.
pub(super) fn plant(fitted: &FittedModel) -> Result<Plant<f64>, InferError> {
    Ok(fitted.fit.model.plant(&fitted.fit.values)?)
}

/// Rigid body without laws. Its mass is the stated one, else `apparent_mass`, else that of the footprint.
pub(super) fn body(data: &Dataset, apparent_mass: Option<f64>) -> Model {
    let mass = data.mass_given.or(apparent_mass).unwrap_or(data.body.mass);
    let mut model = Model::nominal(data.body.clone(), Some(mass), data.dof);
    model.body.mass = mass;
    model.effects.clear();
    model
}

/// Whether any effect of a model acts on the object rather than on the instruments.
pub(super) fn has_laws_on_object(model: &Model) -> bool {
    model.effects.iter().any(|e| e.kind.spec().target != EffectTarget::Instrument)
}

/// Whether effects of a kind can be added. Events of a wheel cannot: only the simulator has the wheel.
pub(super) fn can_be_added(kind: &Kind) -> bool {
    !kind.changes_wheels()
}
