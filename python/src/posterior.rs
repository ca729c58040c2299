//! Posteriors and their calibration in Python.

use numpy::{PyArray1, PyArray3, PyArray4, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_estimate::{SampleRequest, SampledPosterior, sample_recording};
use trundle_infer::{FitOptions, Stage};
use trundle_posterior::{
    Calibration, Chain, Method, Posterior, Replicate, SampleOptions, predictive, replicates,
};
use trundle_record::Dataset;

use crate::error::{refused, run};
use crate::inputs::{self, PriorText, dataset};
use crate::model::PyModel;
use crate::plain::{parsed, plain};
use crate::watch::{once, watched_request};

/// A search for the modes, then the draws.
const STAGES: [Stage; 2] =
    [Stage { name: "fit", end: 0.3, rounds: 3.0 }, Stage { name: "sample", end: 1.0, rounds: 1.0 }];
const CALIBRATE: [Stage; 1] = once("calibrate");

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyPosterior>()?;
    module.add_function(wrap_pyfunction!(_sample, module)?)?;
    module.add_function(wrap_pyfunction!(_calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(_calibration_table, module)?)
}

/// Draws of a posterior, with its recording.
#[pyclass(name = "_Posterior", module = "trundle", frozen)]
struct PyPosterior {
    inner: SampledPosterior,
    data: Dataset,
}

/// Sample the posterior of a model's free parameters; see `trundle.sample`.
#[pyfunction]
#[pyo3(signature = (recording, model=None, *, prior=None, method="laplace", chains=4, draws=250, warmup=150,
    starts=6, seed=0, progress=None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
fn _sample(
    recording: &Bound<'_, PyAny>,
    model: Option<PyRef<'_, PyModel>>,
    prior: Option<PriorText>,
    method: &str,
    chains: usize,
    draws: usize,
    warmup: usize,
    starts: usize,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<PyPosterior> {
    let (data, model, prior) = (dataset(recording)?, inputs::model(model), inputs::prior(prior)?);
    let fit = FitOptions { starts, seed, ..FitOptions::default() };
    let method = Method::named(method).map_err(refused)?;
    let options = SampleOptions { method, chains, draws, warmup, fit };
    let request = SampleRequest { model: model.as_ref(), prior: prior.as_ref(), options };
    let inner =
        watched_request(recording.py(), progress, &STAGES, |watch| sample_recording(&data, &request, watch))?;
    Ok(PyPosterior { inner, data })
}

impl PyPosterior {
    /// A number of each draw as an array of shape (chain, draw).
    fn each<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        numbers: impl Fn(&Chain) -> Vec<T>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let chains = &self.inner.posterior.chains;
        let flat: Vec<T> = chains.iter().flat_map(numbers).collect();
        let shape = [chains.len(), flat.len() / chains.len().max(1)];
        Ok(PyArray1::from_vec(py, flat).reshape(shape)?.into_any())
    }
}

#[pymethods]
impl PyPosterior {
    /// Settings, parameters, noise and costs of the run.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.inner.summary(&self.data))
    }

    /// Draws, SI units: shape (chain, draw, parameter).
    fn draws<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let Posterior { draws: all, slots, .. } = &self.inner.posterior;
        let flat: Vec<f64> = all.iter().flatten().flatten().copied().collect();
        let shape = [all.len(), all.first().map_or(0, Vec::len), slots.len()];
        PyArray1::from_vec(py, flat).reshape(shape)
    }

    /// Sampler statistics under ArviZ's names: arrays of shape (chain, draw).
    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("lp", self.each(py, |c| c.log_density.clone())?)?;
        dict.set_item("diverging", self.each(py, |c| c.diverging.clone())?)?;
        dict.set_item("n_steps", self.each(py, |c| c.evaluations.clone())?)?;
        Ok(dict)
    }

    /// Names of the training episodes, and the log likelihood of each at each draw: shape (chain, draw, episode), nats.
    fn log_likelihood<'py>(&self, py: Python<'py>) -> PyResult<(Vec<String>, Bound<'py, PyArray3<f64>>)> {
        let found = run(py, || self.inner.log_likelihood(&self.data))?;
        let flat: Vec<f64> = found.chains.iter().flatten().flatten().copied().collect();
        let shape = [found.chains.len(), found.chains.first().map_or(0, Vec::len), found.episodes.len()];
        Ok((found.episodes, PyArray1::from_vec(py, flat).reshape(shape)?))
    }

    /// Posterior predictive poses of every episode, from `draws` evenly spaced draws of each chain. For each episode's
    /// name: whether it is held out, times (s), measured poses, and predicted poses of shape (chain, draw, time, 3).
    fn predictive<'py>(&self, py: Python<'py>, draws: usize, seed: u64) -> PyResult<Bound<'py, PyDict>> {
        let p = &self.inner.posterior;
        let values = p.spaced_values(draws);
        let draws = values.len() / p.chains.len().max(1);
        let dict = PyDict::new(py);
        for (stream, episode) in self.data.episodes().enumerate() {
            let drawn =
                run(py, || predictive(&p.model, &values, &p.channels, episode, (seed, stream as u64)))?;
            let flat: Vec<f64> = drawn.iter().flatten().flatten().copied().collect();
            let shape = [p.chains.len(), draws, episode.pose.len(), 3];
            let poses: Bound<'_, PyArray4<f64>> = PyArray1::from_vec(py, flat).reshape(shape)?;
            let t = PyArray1::from_vec(py, episode.pose.iter().map(|s| s.t).collect::<Vec<f64>>());
            let seen: Vec<f64> = episode.pose.iter().flat_map(|s| s.pose).collect();
            let seen = PyArray1::from_vec(py, seen).reshape([episode.pose.len(), 3])?;
            dict.set_item(&episode.name, (stream >= self.data.training.len(), t, seen, poses))?;
        }
        Ok(dict)
    }
}

/// Rounds of a calibration, one dict each; see `trundle.calibrate`.
#[pyfunction]
#[pyo3(signature = (text, rounds, *, method=None, seed=0, progress=None))]
fn _calibrate(
    py: Python<'_>,
    text: &str,
    rounds: Vec<u64>,
    method: Option<&str>,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Py<PyAny>> {
    let calibration = read(text, method)?;
    let found =
        watched_request(py, progress, &CALIBRATE, |watch| replicates(&calibration, &rounds, seed, watch))?;
    Ok(plain(py, &found)?.unbind())
}

fn read(text: &str, method: Option<&str>) -> PyResult<Calibration> {
    let calibration = Calibration::from_toml(text).map_err(refused)?;
    Ok(match method {
        Some(name) => calibration.with_method(Method::named(name).map_err(refused)?),
        None => calibration,
    })
}

/// Coverage over the rounds of a calibration: `name`, `method`, and a dict for each parameter.
#[pyfunction]
#[pyo3(signature = (text, rounds, *, method=None))]
fn _calibration_table<'py>(
    text: &str,
    rounds: &Bound<'py, PyAny>,
    method: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let calibration = read(text, method)?;
    let found: Vec<Replicate> = parsed(rounds)?;
    plain(rounds.py(), &calibration.table(&found))
}
