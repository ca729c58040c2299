//! Diagnosis of a black-box simulator that is a Python function.

use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, PoisonError};
use trundle_diagnose::STAGES;
use trundle_diagnose::black_box::{BlackBox, Simulator as BlackBoxSimulator, diagnose};
use trundle_infer::StateVector;
use trundle_model::{Prior, Slot, catalogue};

use crate::diagnose::PyOutcome;
use crate::error::TrundleError;
use crate::inputs::dataset;
use crate::simulator::Simulator;
use crate::watch::watched;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_diagnose_foreign, module)?)
}

/// A parameter of the simulator as a Python dictionary.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct PyParameter {
    pub name: String,
    pub start: f64,
    pub lower: f64,
    pub upper: f64,
    /// Prior standard deviation in the unit of the parameter; `None` for a wide prior.
    pub sd: Option<f64>,
    pub unit: String,
}

impl PyParameter {
    fn slot(&self) -> Slot {
        let Self { start, lower, upper, .. } = *self;
        let prior = match self.sd {
            Some(sd) if lower >= 0.0 => Prior::LogNormal { median: start, sd: sd / start },
            Some(sd) => Prior::Normal { mean: start, sd },
            None if lower.is_finite() && upper.is_finite() => Prior::Uniform,
            None => Prior::LogNormal { median: start, sd: WIDE_LOG_SD },
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

/// Prior standard deviation of the logarithm of a positive parameter without `sd` and bounds.
const WIDE_LOG_SD: f64 = 1.5;

/// Units of parameters that the catalogue does not use.
const OTHER_UNITS: &str = "kg kg·m kg·m² N N·m N·s/m N·m·s/rad N/m N·m/rad m m/s² rad s Hz";

/// The unit as a static string of the catalogue; empty if it is not known.
pub(crate) fn unit(text: &str) -> &'static str {
    let known = catalogue().flat_map(|spec| spec.params).map(|param| param.unit);
    known.chain(OTHER_UNITS.split(' ')).find(|unit| *unit == text).unwrap_or("")
}

/// A Python callable as a black-box simulator.
struct PyBlackBox {
    simulator: Simulator,
    names: Vec<String>,
    /// Serialises the calls: the callable may own a simulation engine and may release the GIL.
    lock: Mutex<()>,
}

impl BlackBoxSimulator for PyBlackBox {
    fn step(
        &self,
        state: &StateVector,
        wrench: &[f64; 3],
        dt: f64,
        values: &[f64],
    ) -> Result<StateVector, String> {
        let _guard = self.lock.lock().unwrap_or_else(PoisonError::into_inner);
        Python::attach(|py| {
            let named = PyDict::new(py);
            for (name, value) in self.names.iter().zip(values) {
                named.set_item(name, value).map_err(|error| error.to_string())?;
            }
            self.simulator.step(py, state, wrench, dt, &named)
        })
    }
}

/// Diagnose a recording with a black-box simulator; see `trundle.diagnose`.
#[pyfunction]
#[pyo3(signature = (recording, step, parameters, *, given=false, seed=0, progress=None))]
fn _diagnose_foreign(
    recording: &Bound<'_, PyAny>,
    step: Py<PyAny>,
    parameters: Vec<PyParameter>,
    given: bool,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<PyOutcome> {
    let py = recording.py();
    let data = dataset(recording)?;
    let callable = PyBlackBox {
        simulator: Simulator::new(step),
        names: parameters.iter().map(|p| p.name.clone()).collect(),
        lock: Mutex::new(()),
    };
    let black_box = BlackBox {
        simulator: &callable,
        parameters: parameters.iter().map(PyParameter::slot).collect(),
        start: parameters.iter().map(|p| p.start).collect(),
        given,
    };
    match watched(py, progress, &STAGES, |watch| diagnose(&data, &black_box, seed, watch)) {
        Ok(outcome) => PyOutcome::of(outcome),
        Err(error) => Err(with_cause(py, error, callable.simulator.raised())),
    }
}

/// Chains the exception of the callable to the error that locates it. Exceptions such as `KeyboardInterrupt`, which do not
/// derive from `Exception`, are returned unchanged.
fn with_cause(py: Python<'_>, error: PyErr, raised: PyResult<()>) -> PyErr {
    match raised {
        Err(cause) if !cause.is_instance_of::<PyException>(py) => cause,
        Err(cause) if error.is_instance_of::<TrundleError>(py) => {
            error.set_cause(py, Some(cause));
            error
        }
        _ => error,
    }
}
