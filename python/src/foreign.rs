//! Diagnosis of a caller's own simulator.

use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, PoisonError};
use trundle_diagnose::STAGES;
use trundle_diagnose::foreign::{Foreign, Simulator as Simulates, diagnose};
use trundle_infer::StateVector;
use trundle_model::{Prior, Slot, catalogue};

use crate::diagnose::PyOutcome;
use crate::error::TrundleError;
use crate::infer::inputs;
use crate::simulator::Simulator;
use crate::watch::watched;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_diagnose_foreign, module)?)
}

/// A parameter of the simulator, as Python describes it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Described {
    name: String,
    start: f64,
    lower: f64,
    upper: f64,
    /// Standard deviation of what is believed, in the parameter's unit; `None` for hardly anything.
    sd: Option<f64>,
    unit: String,
}

impl Described {
    fn slot(&self) -> Slot {
        let Self { start, lower, upper, .. } = *self;
        let prior = match self.sd {
            Some(sd) if lower >= 0.0 => Prior::LogNormal { median: start, sd: sd / start },
            Some(sd) => Prior::Normal { mean: start, sd },
            None if lower.is_finite() && upper.is_finite() => Prior::Uniform,
            None => Prior::LogNormal { median: start, sd: VAGUE },
        };
        Slot {
            name: self.name.clone(),
            unit: unit(&self.unit),
            lower,
            upper,
            prior,
            value: None,
            effect: None,
        }
    }
}

/// Standard deviation of the logarithm of a positive parameter of which only a start is known.
const VAGUE: f64 = 1.5;

/// The unit as the catalogue writes it; none where it has none such.
fn unit(text: &str) -> &'static str {
    let known = catalogue().flat_map(|spec| spec.params).map(|param| param.unit);
    known.chain(["kg", "kg·m²", "N·m·s/rad", "s", "Hz"]).find(|unit| *unit == text).unwrap_or("")
}

/// A Python callable as the diagnosis calls it.
struct Called {
    simulator: Simulator,
    names: Vec<String>,
    /// Held during a call: the callable may keep an engine, and lets others run while that works.
    one_at_a_time: Mutex<()>,
}

impl Simulates for Called {
    fn step(
        &self,
        state: &StateVector,
        wrench: &[f64; 3],
        dt: f64,
        values: &[f64],
    ) -> Result<StateVector, String> {
        let _alone = self.one_at_a_time.lock().unwrap_or_else(PoisonError::into_inner);
        Python::attach(|py| {
            let named = PyDict::new(py);
            for (name, value) in self.names.iter().zip(values) {
                named.set_item(name, value).map_err(|error| error.to_string())?;
            }
            self.simulator.step(py, state, wrench, dt, &named)
        })
    }
}

/// Diagnose a recording that a caller's simulator is to reproduce; see `trundle.diagnose`.
#[pyfunction]
#[pyo3(signature = (recording, step, parameters, *, given=false, seed=0, progress=None))]
fn _diagnose_foreign(
    recording: &Bound<'_, PyAny>,
    step: Py<PyAny>,
    parameters: Vec<Described>,
    given: bool,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<PyOutcome> {
    let py = recording.py();
    let (data, _) = inputs(recording, None)?;
    let called = Called {
        simulator: Simulator::new(step),
        names: parameters.iter().map(|p| p.name.clone()).collect(),
        one_at_a_time: Mutex::new(()),
    };
    let foreign = Foreign {
        simulator: &called,
        parameters: parameters.iter().map(Described::slot).collect(),
        start: parameters.iter().map(|p| p.start).collect(),
        given,
    };
    match watched(py, progress, &STAGES, |watch| diagnose(&data, &foreign, seed, watch)) {
        Ok(outcome) => PyOutcome::of(outcome),
        Err(error) => Err(explained(py, error, called.simulator.raised())),
    }
}

/// An error of the callable as the cause of one that says where; what is no `Exception`, such as Ctrl-C, as it is.
fn explained(py: Python<'_>, error: PyErr, raised: PyResult<()>) -> PyErr {
    match raised {
        Err(cause) if !cause.is_instance_of::<PyException>(py) => cause,
        Err(cause) if error.is_instance_of::<TrundleError>(py) => {
            error.set_cause(py, Some(cause));
            error
        }
        _ => error,
    }
}
