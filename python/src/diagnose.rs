//! Diagnosis in Python.

use std::path::PathBuf;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use trundle_diagnose::{Options, Outcome, Predictions, diagnose};

use crate::error::run;
use crate::infer::inputs;
use crate::watch::watched;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyOutcome>()?;
    module.add_function(wrap_pyfunction!(_diagnose, module)?)
}

/// What a diagnosis leaves: texts, and a table to be written.
#[pyclass(name = "_Outcome", module = "trundle", frozen)]
pub(crate) struct PyOutcome {
    /// `diagnosis.json`.
    #[pyo3(get)]
    answer: String,
    /// Curves for the report, JSON.
    #[pyo3(get)]
    series: String,
    /// `model.toml`.
    #[pyo3(get)]
    model: String,
    predictions: Predictions,
}

impl PyOutcome {
    pub(crate) fn of(outcome: Outcome) -> PyResult<Self> {
        let json = |error: serde_json::Error| PyRuntimeError::new_err(error.to_string());
        Ok(Self {
            answer: serde_json::to_string_pretty(&outcome.answer).map_err(json)?,
            series: serde_json::to_string(&outcome.series).map_err(json)?,
            model: outcome.model,
            predictions: outcome.predictions,
        })
    }
}

#[pymethods]
impl PyOutcome {
    /// Write `predictions.parquet`.
    fn write_predictions(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        run(py, || self.predictions.write(&path))
    }
}

/// Diagnose a recording; see `trundle.diagnose`.
#[pyfunction]
#[pyo3(signature = (recording, model=None, *, seed=0, without=vec![], progress=None))]
fn _diagnose(
    recording: &Bound<'_, PyAny>,
    model: Option<&str>,
    seed: u64,
    without: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<PyOutcome> {
    let (data, model) = inputs(recording, model)?;
    let options = Options { seed, model, without };
    let outcome = watched(recording.py(), progress, |watch| diagnose(&data, &options, watch))?;
    PyOutcome::of(outcome)
}
