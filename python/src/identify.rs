//! Profiles in Python.

use pyo3::prelude::*;
use trundle_estimate::{ProfileRequest, profile_recording};
use trundle_infer::{FitOptions, Stage};

use crate::inputs::{self, PriorText, dataset};
use crate::model::PyModel;
use crate::plain::plain;
use crate::watch::watched_request;

/// A fit of the model, then a fit at each value of the parameter.
const STAGES: [Stage; 2] =
    [Stage { name: "fit", end: 0.3, rounds: 3.0 }, Stage { name: "profile", end: 1.0, rounds: 1.0 }];

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_profile, module)?)
}

/// Profile one free parameter; see `trundle.profile`.
#[pyfunction]
#[pyo3(signature = (recording, parameter, model=None, *, prior=None, grid=None, starts=6, seed=0, progress=None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
fn _profile(
    recording: &Bound<'_, PyAny>,
    parameter: &str,
    model: Option<PyRef<'_, PyModel>>,
    prior: Option<PriorText>,
    grid: Option<Vec<f64>>,
    starts: usize,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Py<PyAny>> {
    let (data, model, prior) = (dataset(recording)?, inputs::model(model), inputs::prior(prior)?);
    let request = ProfileRequest {
        parameter,
        model: model.as_ref(),
        prior: prior.as_ref(),
        grid: grid.as_deref(),
        options: FitOptions { starts, seed, ..FitOptions::default() },
    };
    let py = recording.py();
    let found = watched_request(py, progress, &STAGES, |watch| profile_recording(&data, &request, watch))?;
    Ok(plain(py, &found)?.unbind())
}
