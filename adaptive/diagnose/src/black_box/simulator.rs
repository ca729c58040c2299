//! Black-box simulators and their parameters.

use super::path::Interval;
use trundle_infer::{InferError, StateVector, Watch};
use trundle_model::{Slot, transport};

/// A simulator that a diagnosis can only call.
///
/// States are pose and twist `[x, y, θ, vx, vy, ω]` of the origin of the object frame in the world, SI units.
/// Equal inputs must give equal outputs.
pub trait Simulator: Sync {
    /// Returns the state after `dt` seconds under `wrench`, `[N, N, N·m]` in object axes about the object origin. The
    /// wrench rotates with the object. `values` has one value for each parameter.
    ///
    /// # Errors
    /// A description of the failure. The caller reports results that are not finite.
    fn step(
        &self,
        state: &StateVector,
        wrench: &[f64; 3],
        dt: f64,
        values: &[f64],
    ) -> Result<StateVector, String>;
}

/// A black-box simulator with priors of its parameters.
pub struct BlackBox<'a> {
    /// The simulator.
    pub simulator: &'a dyn Simulator,
    /// Bounds and priors of its parameters. A parameter with a value is not fitted.
    pub parameters: Vec<Slot>,
    /// Initial value of each parameter for the fit.
    pub start: Vec<f64>,
    /// Whether `start` holds the values with which the simulator is used, which are then part of the test.
    pub given: bool,
}

impl BlackBox<'_> {
    /// Steps through an interval from a state; `extra` is added to the wrench of each step.
    pub(crate) fn step_interval(
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

    /// Makes one step. An error reports the episode, the time and all inputs.
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

/// Returns an error if the user has cancelled.
pub(crate) fn check_cancelled(watch: &dyn Watch) -> Result<(), InferError> {
    if watch.cancelled() { Err(InferError::Interrupted) } else { Ok(()) }
}
