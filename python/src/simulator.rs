//! A user's simulator in place of the laws.

use std::sync::Mutex;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_model::{ModelInstance, State, StepError, StepInput, Stepper};

/// A simulator that calls `callable(state, wrench, dt, values)`. It runs one rollout at a time, because the callable may
/// have a state.
pub(crate) struct Simulator {
    callable: Py<PyAny>,
    turn: Mutex<()>,
    raised: Mutex<Option<PyErr>>,
}

impl Simulator {
    pub fn new(callable: Py<PyAny>) -> Self {
        Self { callable, turn: Mutex::new(()), raised: Mutex::new(None) }
    }

    /// The exception that the callable raised, if it did.
    pub fn raised(&self) -> PyResult<()> {
        self.raised.lock().ok().and_then(|mut raised| raised.take()).map_or(Ok(()), Err)
    }

    /// Keeps the first exception and returns its description.
    fn keep(&self, error: PyErr) -> String {
        let reason = format!("the simulator raised {error}");
        if let Ok(mut raised) = self.raised.lock() {
            raised.get_or_insert(error);
        }
        reason
    }

    /// One step. An error describes the problem.
    pub fn step(
        &self,
        py: Python<'_>,
        state: &[f64; 6],
        wrench: &[f64; 3],
        dt: f64,
        values: &Bound<'_, PyDict>,
    ) -> Result<[f64; 6], String> {
        let arguments = (PyArray1::from_slice(py, state), PyArray1::from_slice(py, wrench), dt, values);
        let after = self.callable.bind(py).call1(arguments).map_err(|e| self.keep(e))?;
        let wrong = || {
            let shown = after.repr().map_or_else(|_| "an object".to_owned(), |text| text.to_string());
            format!("the simulator returned {shown}: return six finite numbers (pose and twist, SI)")
        };
        let array = py.import("numpy").and_then(|numpy| numpy.call_method1("asarray", (&after, "float64")));
        let array = array.ok().and_then(|array| array.extract::<PyReadonlyArray1<'_, f64>>().ok());
        let numbers: Option<[f64; 6]> = array.and_then(|a| a.as_array().to_vec().try_into().ok());
        numbers.filter(|all| all.iter().all(|v| v.is_finite())).ok_or_else(wrong)
    }
}

impl Stepper for Simulator {
    fn rollout(
        &self,
        at: &ModelInstance<'_>,
        start: &State<f64>,
        inputs: &[StepInput],
    ) -> Result<Vec<State<f64>>, StepError> {
        // Lock before attaching to the interpreter, so that a waiting thread does not block the interpreter.
        let _turn = self.turn.lock();
        Python::attach(|py| {
            let values = PyDict::new(py);
            for (slot, value) in at.model.slots().iter().zip(at.values) {
                let set = values.set_item(&slot.name, value);
                set.map_err(|e| StepError { step: 0, reason: self.keep(e) })?;
            }
            let ([x, y, theta], [vx, vy, spin]) = (start.pose, start.twist);
            let mut state = [x, y, theta, vx, vy, spin];
            let mut states = Vec::with_capacity(inputs.len());
            for (step, drive) in inputs.iter().enumerate() {
                let after = self.step(py, &state, &drive.applied, drive.dt, &values);
                state = after.map_err(|reason| StepError { step, reason })?;
                let [x, y, theta, vx, vy, spin] = state;
                states.push(State::moving([x, y, theta], [vx, vy, spin]));
            }
            Ok(states)
        })
    }
}
