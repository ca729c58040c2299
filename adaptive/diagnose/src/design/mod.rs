//! Discriminating experiments and certificates of indistinguishability.
//!
//! [`experiment`] searches parametrised pushes for the one with the largest difference between two models after a
//! refit of either. [`certificate`] quantifies how much the predictions of two fitted models differ on a
//! recording.

mod certificate;
mod competing_model;
mod experiment;
mod instructions;
mod library;
mod model_files;
mod push;
mod search;
mod separation;
mod setup;
mod synthetic;
mod verification;

pub use certificate::{Certificate, certificate};
pub(crate) use certificate::{OPEN_LOOP_NOISE_FACTOR, SimulatedPair, certificate_from_simulations};
pub use competing_model::CompetingModel;
pub use experiment::{Experiment, PlannedPush, experiment, needed_repeats, success_probability};
pub use model_files::{DesignedExperiment, ModelFile, PushedObject, design_experiment};
pub use push::{Profile, Push};
pub(crate) use separation::misfit_after_refit;
pub use setup::{Instruments, Limits, Setup};
pub(crate) use synthetic::PosePredictor;
pub(crate) use verification::verify;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
