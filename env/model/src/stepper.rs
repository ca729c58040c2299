//! The interface of simulators: free motion by the laws alone, or an engine with contacts.

use crate::{Clock, Model, Plant, State};
use thiserror::Error;

/// Input of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInput {
    /// Mean wrench on the object over the step, object axes about the object origin, `[N, N, N·m]`.
    pub applied: [f64; 3],
    /// Time and grasp.
    pub clock: Clock,
    /// Duration, s.
    pub dt: f64,
}

/// A model with parameter values.
#[derive(Clone, Copy, Debug)]
pub struct ModelInstance<'a> {
    /// The model.
    pub model: &'a Model,
    /// Values, one for each of [`Model::slots`].
    pub values: &'a [f64],
    /// Plant of the model with these values.
    pub plant: &'a Plant<f64>,
}

/// Error of a rollout.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("step {step}: {reason}")]
pub struct StepError {
    /// Index of the input.
    pub step: usize,
    /// Problem, with the value.
    pub reason: String,
}

/// A simulator: it maps an initial state and inputs to a motion by repeated application of `g` of the paper's eq. 5.
///
/// Implementations are called from several threads and must be deterministic. States that are not finite mean that the
/// model cannot be evaluated at these values; an error ends the fit.
pub trait Stepper: Sync {
    /// States after each input, in order.
    ///
    /// # Errors
    /// When the simulation fails.
    fn rollout(
        &self,
        at: &ModelInstance<'_>,
        start: &State<f64>,
        inputs: &[StepInput],
    ) -> Result<Vec<State<f64>>, StepError>;
}

/// Simulator of free motion: the laws alone, without contacts.
#[derive(Clone, Copy, Debug, Default)]
pub struct FreeMotion;

impl Stepper for FreeMotion {
    fn rollout(
        &self,
        at: &ModelInstance<'_>,
        start: &State<f64>,
        inputs: &[StepInput],
    ) -> Result<Vec<State<f64>>, StepError> {
        let next = |state: &mut State<f64>, drive: &StepInput| {
            *state = at.plant.step(state, drive.applied, drive.clock, drive.dt);
            Some(*state)
        };
        Ok(inputs.iter().scan(*start, next).collect())
    }
}
