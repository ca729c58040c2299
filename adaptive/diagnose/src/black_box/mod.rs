//! Diagnosis of a black-box simulator.
//!
//! The simulator is a function ([`Simulator`]). Its calls are expensive, and it provides neither derivatives nor
//! a list of its effects. It is therefore called along the measured motion only and replaced there by its
//! first-order expansion (`linearisation`). A Kalman filter over that expansion (`gains`) weighs the residual
//! by the noise of the force sensor, the tare error and the noise of the tracker, as for trundle's own plant.
//!
//! Laws, including those with internal states (`law_states`), add to the wrench (`law_wrench`); testing one
//! needs no calls. The simulator itself makes all reported predictions (`rollout`). Search, verdict and answer
//! are shared with every other diagnosis (`crate::engine`).

mod apparent_mass;
mod basis;
mod derivatives;
mod engine;
mod experiment;
mod fitting;
mod gains;
mod initial_states;
mod law_states;
mod law_wrench;
mod laws;
mod likelihood;
mod linearisation;
mod parameter_fit;
mod path;
mod predictions;
mod rollout;
mod simulator;
mod view;
mod windows;

use crate::report::Outcome;
use crate::run::{Options, diagnose_with};
use trundle_infer::{InferError, Watch};
use trundle_record::Dataset;

pub(crate) use basis::Basis;
pub use simulator::{BlackBox, Simulator};

/// Diagnose a recording with a black-box simulator.
///
/// # Errors
/// If the recording has too few data, the simulator fails, or the user interrupts.
pub fn diagnose(
    data: &Dataset,
    simulator: &BlackBox<'_>,
    seed: u64,
    watch: &dyn Watch,
) -> Result<Outcome, InferError> {
    let engine = engine::BlackBoxEngine::new(data, simulator, seed, watch)?;
    diagnose_with(&engine, &Options { seed, ..Options::default() }, watch)
}

#[cfg(test)]
mod tests;
