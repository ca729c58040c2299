//! A diagnosis from start to end.

use crate::decision::decide;
use crate::engine::Engine;
use crate::engine::plant_engine::PlantEngine;
use crate::pushing_time::require_pushing_time;
use crate::report::{Outcome, report};
use crate::units;
use trundle_infer::{InferError, Watch};
use trundle_model::{Model, Scales};
use trundle_record::{Dataset, PrepareOptions, Recording, prepare_with};

/// Options of a diagnosis.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Seed of every random start.
    pub seed: u64,
    /// The nominal model; the paper's if `None`.
    pub model: Option<Model>,
    /// Names of effects to exclude.
    pub without: Vec<String>,
}

/// Diagnose a prepared recording of an object of the size of furniture.
///
/// # Errors
/// If there is not enough data, or the user interrupts.
pub fn diagnose(data: &Dataset, options: &Options, watch: &dyn Watch) -> Result<Outcome, InferError> {
    require_pushing_time(data)?;
    diagnose_with(&PlantEngine::new(data, options.model.as_ref())?, options, watch)
}

/// Diagnose a recording with any engine.
///
/// # Errors
/// As [`diagnose`], and if the simulation fails.
pub(crate) fn diagnose_with(
    engine: &dyn Engine,
    options: &Options,
    watch: &dyn Watch,
) -> Result<Outcome, InferError> {
    let decision = decide(engine, &options.without, options.seed, watch)?;
    report(engine, &decision, watch)
}

/// Diagnose a recording of any size. The search and the decision use the recording's own units (module `units`),
/// the report uses SI units. `data` is the recording prepared with `prepare`.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_recording(
    recording: &Recording,
    data: &Dataset,
    prepare: PrepareOptions,
    options: &Options,
    watch: &dyn Watch,
) -> Result<Outcome, InferError> {
    let scales = units::of(data);
    let unscalable = options.model.as_ref().is_some_and(|model| model.discrepancy.is_some());
    if scales == Scales::SI || unscalable {
        return diagnose(data, options, watch);
    }
    let prepare = PrepareOptions { gravity: prepare.gravity / scales.acceleration(), ..prepare };
    let reduced =
        prepare_with(&recording.in_units(&scales), prepare).map_err(|error| InferError::NoData {
            recording: data.name.clone(),
            reason: error.to_string(),
            remedy: "check the recording with `trundle check`".to_owned(),
        })?;
    let model = options.model.as_ref().map(|model| units::reduced(model, &scales)).transpose()?;
    require_pushing_time(&reduced)?;
    let reduced_engine = PlantEngine::new(&reduced, model.as_ref())?;
    let decision = decide(&reduced_engine, &options.without, options.seed, watch)?;
    let engine = PlantEngine::new(data, options.model.as_ref())?;
    report(&engine, &decision.restored(&engine, &scales)?, watch)
}
