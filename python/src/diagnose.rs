//! Diagnosis in Python.

use std::path::PathBuf;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use trundle_diagnose::{Options, Outcome, Predictions, STAGES, diagnose_recording};
use trundle_model::Model;
use trundle_record::{PrepareOptions, prepare_with};

use crate::error::{refused, run};
use crate::inspect::wrench_pose_of;
use crate::record::recording_of;
use crate::watch::watched;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyOutcome>()?;
    module.add_function(wrap_pyfunction!(_platt, module)?)?;
    module.add_function(wrap_pyfunction!(_sources, module)?)?;
    module.add_function(wrap_pyfunction!(_diagnose, module)?)
}

/// Offset, slope and largest logit from which probabilities are made.
#[pyfunction]
fn _platt() -> [f64; 3] {
    trundle_diagnose::platt()
}

/// Version of the Rust sources, "all" or those that a "diagnosis" depends on: 16 hexadecimal digits, see `build.rs`.
#[pyfunction]
fn _sources(which: &str) -> &'static str {
    if which == "diagnosis" { env!("TRUNDLE_DIAGNOSIS_SOURCES") } else { env!("TRUNDLE_ALL_SOURCES") }
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
#[pyo3(signature = (recording, model=None, *, seed=0, without=vec![], wrench_pose="own_time", progress=None))]
fn _diagnose(
    recording: &Bound<'_, PyAny>,
    model: Option<&str>,
    seed: u64,
    without: Vec<String>,
    wrench_pose: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<PyOutcome> {
    let py = recording.py();
    let prepare = PrepareOptions { wrench_pose: wrench_pose_of(wrench_pose)?, ..PrepareOptions::default() };
    let source = recording_of(recording)?;
    let data = run(py, || prepare_with(&source, prepare))?;
    let model = model.map(Model::from_toml).transpose().map_err(refused)?.map(|(model, _)| model);
    let options = Options { seed, model, without };
    let outcome =
        watched(py, progress, &STAGES, |watch| diagnose_recording(&source, &data, prepare, &options, watch))?;
    PyOutcome::of(outcome)
}
