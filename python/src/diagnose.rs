//! Diagnosis in Python.

use std::fs;
use std::path::PathBuf;

use pyo3::prelude::*;
use trundle_diagnose::{Options, Outcome, STAGES, diagnose_recording};
use trundle_record::{PrepareOptions, prepare_with};

use crate::error::{refused, run};
use crate::inputs;
use crate::inspect::wrench_pose_of;
use crate::model::PyModel;
use crate::plain::plain;
use crate::record::recording_of;
use crate::watch::watched;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyOutcome>()?;
    module.add_function(wrap_pyfunction!(_platt, module)?)?;
    module.add_function(wrap_pyfunction!(_sources, module)?)?;
    module.add_function(wrap_pyfunction!(_diagnose, module)?)
}

/// Offset, slope and largest logit of the calibration of probabilities.
#[pyfunction]
fn _platt() -> [f64; 3] {
    trundle_diagnose::platt()
}

/// Version of the Rust sources, "all" or those that a diagnosis of pushed objects ("planar") or of "joints" depends on:
/// 16 hexadecimal digits, see `build.rs`.
#[pyfunction]
fn _sources(which: &str) -> &'static str {
    match which {
        "planar" => env!("TRUNDLE_PLANAR_SOURCES"),
        "joints" => env!("TRUNDLE_JOINT_SOURCES"),
        _ => env!("TRUNDLE_ALL_SOURCES"),
    }
}

/// The result of a diagnosis.
#[pyclass(name = "_Outcome", module = "trundle", frozen)]
pub(crate) struct PyOutcome(Outcome);

impl PyOutcome {
    pub(crate) fn of(outcome: Outcome) -> PyResult<Self> {
        Ok(Self(outcome))
    }
}

#[pymethods]
impl PyOutcome {
    /// The content of `diagnosis.json`.
    #[getter]
    fn answer<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.answer)
    }

    /// Curves for the report.
    #[getter]
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.series)
    }

    /// The model with the named effects.
    #[getter]
    fn model(&self) -> PyResult<PyModel> {
        PyModel::from_toml(&self.0.model)
    }

    /// Write `diagnosis.json`, `model.toml` and `predictions.parquet` into a folder.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        let answer = serde_json::to_string_pretty(&self.0.answer).map_err(refused)?;
        fs::write(folder.join("diagnosis.json"), answer + "\n")?;
        fs::write(folder.join("model.toml"), &self.0.model)?;
        run(py, || self.0.predictions.write(&folder.join("predictions.parquet")))
    }
}

/// Diagnose a recording; see `trundle.diagnose`.
#[pyfunction]
#[pyo3(signature = (recording, model=None, *, seed=0, without=vec![], wrench_pose="own_time", progress=None))]
fn _diagnose(
    recording: &Bound<'_, PyAny>,
    model: Option<PyRef<'_, PyModel>>,
    seed: u64,
    without: Vec<String>,
    wrench_pose: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<PyOutcome> {
    let py = recording.py();
    let prepare = PrepareOptions { wrench_pose: wrench_pose_of(wrench_pose)?, ..PrepareOptions::default() };
    let source = recording_of(recording)?;
    let data = run(py, || prepare_with(&source, prepare))?;
    let options = Options { seed, model: inputs::model(model), without };
    let outcome =
        watched(py, progress, &STAGES, |watch| diagnose_recording(&source, &data, prepare, &options, watch))?;
    PyOutcome::of(outcome)
}
