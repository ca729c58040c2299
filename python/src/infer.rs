//! Fits and predictions in Python.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_diagnose::{Predictions, for_recording, prediction_scores};
use trundle_estimate::{FitRequest, LikelihoodKind, LikelihoodOptions, combined, fit_recordings, loss_named};
use trundle_infer::{FitOptions, Optimiser, Stage};
use trundle_model::{Model, Stepper};
use trundle_record::Dataset;

use crate::error::{refused, run};
use crate::inputs::{self, PriorText, dataset};
use crate::model::PyModel;
use crate::plain::plain;
use crate::simulator::Simulator;
use crate::watch::watched_request;

/// A search repeats its rounds of starts until some agree.
const STAGES: [Stage; 1] = [Stage { name: "fit", end: 1.0, rounds: 3.0 }];

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_fit, module)?)?;
    module.add_class::<PyPredictions>()?;
    module.add_function(wrap_pyfunction!(_predict, module)?)
}

/// Arguments of `trundle.fit` that choose a likelihood.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Choice {
    likelihood: Option<String>,
    window: f64,
    loss: String,
    obstacles: Option<bool>,
    step: Option<Py<PyAny>>,
}

impl Choice {
    fn options(&self) -> PyResult<LikelihoodOptions> {
        let kind = self.likelihood.as_deref().map(LikelihoodKind::named).transpose().map_err(refused)?;
        let loss = loss_named(&self.loss).map_err(refused)?;
        Ok(LikelihoodOptions { kind, window: self.window, loss, obstacles: self.obstacles })
    }
}

/// Fit the free parameters of a model to the training episodes; see `trundle.fit`.
#[pyfunction]
#[pyo3(signature = (
    recordings, model=None, *, choice, per_episode=vec![], prior=None, start=None, starts=6, seed=0,
    optimiser="lm", progress=None
))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
fn _fit(
    py: Python<'_>,
    recordings: Vec<Bound<'_, PyAny>>,
    model: Option<PyRef<'_, PyModel>>,
    choice: Choice,
    per_episode: Vec<String>,
    prior: Option<PriorText>,
    start: Option<BTreeMap<String, f64>>,
    starts: usize,
    seed: u64,
    optimiser: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Py<PyAny>, PyModel)> {
    let prior = inputs::prior(prior)?;
    let recordings = recordings.iter().map(dataset).collect::<PyResult<_>>()?;
    let recordings = combined(recordings).map_err(refused)?;
    let (model, likelihood, optimiser) =
        (inputs::model(model), choice.options()?, optimiser_named(optimiser)?);
    let simulator = choice.step.map(Simulator::new);
    let request = FitRequest {
        model: model.as_ref(),
        prior: prior.as_ref(),
        start: start.as_ref(),
        likelihood,
        simulator: simulator.as_ref().map(|simulator| simulator as &dyn Stepper),
        options: FitOptions {
            starts,
            seed,
            optimiser,
            per_episode: BTreeSet::from_iter(per_episode),
            ..FitOptions::default()
        },
    };
    let found = watched_request(py, progress, &STAGES, |watch| fit_recordings(&recordings, &request, watch));
    // An exception of the caller's simulator takes precedence over the error that it causes.
    simulator.as_ref().map_or(Ok(()), Simulator::raised)?;
    let report = found?;
    Ok((plain(py, &report.summary)?.unbind(), PyModel { model: report.model, posterior: report.posterior }))
}

fn optimiser_named(name: &str) -> PyResult<Optimiser> {
    match name {
        "lm" => Ok(Optimiser::LevenbergMarquardt),
        "lbfgs" => Ok(Optimiser::Lbfgs),
        other => Err(refused(format!("optimiser: '{other}' is unknown; choose 'lm' or 'lbfgs'"))),
    }
}

/// Open-loop predictions of the episodes of a recording.
#[pyclass(name = "_Predictions", module = "trundle", frozen)]
struct PyPredictions {
    data: Dataset,
    model: Model,
    table: Predictions,
}

/// Simulate every episode in open loop; see `trundle.predict`.
#[pyfunction]
fn _predict(recording: &Bound<'_, PyAny>, model: PyRef<'_, PyModel>) -> PyResult<PyPredictions> {
    let data = dataset(recording)?;
    let model = for_recording(&data, Some(&model.model));
    let table = run(recording.py(), || trundle_diagnose::predict(data.episodes(), &model))?;
    Ok(PyPredictions { data, model, table })
}

#[pymethods]
impl PyPredictions {
    /// Names of the held-out episodes.
    #[getter]
    fn held_out(&self) -> Vec<&str> {
        self.data.held_out.iter().map(|episode| episode.name.as_str()).collect()
    }

    /// Columns by name: `episode` (list of str), `t` (n,), `scored` (n,), and `observed` and `predicted` (n, 3).
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("episode", self.table.episode())?;
        dict.set_item("t", PyArray1::from_slice(py, self.table.t()))?;
        dict.set_item("scored", PyArray1::from_slice(py, self.table.scored()))?;
        for (name, poses) in self.table.groups() {
            let rows: Bound<'_, PyArray2<f64>> =
                PyArray1::from_slice(py, poses.as_flattened()).reshape([poses.len(), 3])?;
            dict.set_item(name, rows)?;
        }
        Ok(dict)
    }

    /// Error metrics of the training and of the held-out episodes, None without episodes.
    fn scores<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let scores = run(py, || prediction_scores(&self.data, &self.model))?;
        plain(py, &scores)
    }

    /// Write the columns as Parquet, with `NAME_x`, `NAME_y` and `NAME_theta` for poses.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        run(py, || self.table.write(&path))
    }
}
