//! Anyone's simulator, and what it is called with.

use super::path::Interval;
use trundle_infer::{InferError, StateVector, Watch};
use trundle_model::{Slot, transport};

/// A simulation under test that is not ours.
///
/// States are pose and twist `[x, y, θ, vx, vy, ω]` of the object frame's origin in the world, SI. It must answer the
/// same to the same question.
pub trait Simulator: Sync {
    /// The state after `dt` seconds under `wrench`, `[N, N, N·m]` in object axes about the object origin: it turns with
    /// the object. `values` has one value for each parameter.
    ///
    /// # Errors
    /// Says in words what went wrong; a number that is not finite is an error.
    fn step(
        &self,
        state: &StateVector,
        wrench: &[f64; 3],
        dt: f64,
        values: &[f64],
    ) -> Result<StateVector, String>;
}

/// A simulator with what is believed of its parameters.
pub struct Foreign<'a> {
    /// Whose it is.
    pub simulator: &'a dyn Simulator,
    /// Its parameters: bounds and belief. One that has a value is never fitted.
    pub parameters: Vec<Slot>,
    /// Where the fit of each begins.
    pub start: Vec<f64>,
    /// Whether the starts are the values that the simulation is used with, and so part of what is tested.
    pub given: bool,
}

impl Foreign<'_> {
    /// From a state through the steps of an interval; `extra` is added to the wrench of each.
    pub(crate) fn walk(
        &self,
        episode: &str,
        from: &StateVector,
        interval: &Interval,
        extra: &[f64; 3],
        values: &[f64],
    ) -> Result<StateVector, InferError> {
        let (mut state, mut t) = (*from, interval.t);
        for step in &interval.steps {
            let applied = transport(step.reading, step.frame);
            let wrench = [0, 1, 2].map(|k| applied[k] + extra[k]);
            state = self.step(episode, t, &state, &wrench, step.dt, values)?;
            t += step.dt;
        }
        Ok(state)
    }

    /// One step; an error says where, and with which numbers.
    pub(crate) fn step(
        &self,
        episode: &str,
        t: f64,
        state: &StateVector,
        wrench: &[f64; 3],
        dt: f64,
        values: &[f64],
    ) -> Result<StateVector, InferError> {
        let failed = |reason: String| {
            let named: Vec<String> =
                self.parameters.iter().zip(values).map(|(p, v)| format!("{} = {v}", p.name)).collect();
            let reason = format!(
                "step from state {state:?} under wrench {wrench:?}, dt = {dt}, with {}: {reason}",
                named.join(", ")
            );
            InferError::Step { episode: episode.to_owned(), t, reason }
        };
        let after = self.simulator.step(state, wrench, dt, values).map_err(failed)?;
        if after.iter().all(|v| v.is_finite()) {
            Ok(after)
        } else {
            Err(failed(format!("returned {after:?}")))
        }
    }
}

/// Whether to go on.
pub(crate) fn go_on(watch: &dyn Watch) -> Result<(), InferError> {
    if watch.cancelled() { Err(InferError::Interrupted) } else { Ok(()) }
}
