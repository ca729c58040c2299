//! Who simulates: the laws alone, or something that also knows what touches.

use crate::{Clock, Model, Plant, State};
use thiserror::Error;

/// One step's input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInput {
    /// Mean wrench on the object over the step, object axes about the object origin, `[N, N, N·m]`.
    pub applied: [f64; 3],
    /// When.
    pub clock: Clock,
    /// Duration, s.
    pub dt: f64,
}

/// A model at values.
#[derive(Clone, Copy, Debug)]
pub struct ModelInstance<'a> {
    /// The model.
    pub model: &'a Model,
    /// One for each of [`Model::slots`].
    pub values: &'a [f64],
    /// The model at these values.
    pub plant: &'a Plant<f64>,
}

/// Why a rollout broke off.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("step {step}: {reason}")]
pub struct StepError {
    /// Which of the inputs.
    pub step: usize,
    /// What was wrong, with the value.
    pub reason: String,
}

/// Simulates an object from a state under given inputs: `g` of the paper's eq. 5, applied again and again.
///
/// An implementation is asked from several threads and must answer the same to the same question. Numbers that are
/// not finite mean that the model cannot be evaluated there; an error ends the whole fit.
pub trait Stepper: Sync {
    /// The states after each of the inputs, in order.
    ///
    /// # Errors
    /// When it cannot be simulated at all.
    fn rollout(
        &self,
        at: &ModelInstance<'_>,
        start: &State<f64>,
        inputs: &[StepInput],
    ) -> Result<Vec<State<f64>>, StepError>;
}

/// The laws alone: nothing touches.
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
