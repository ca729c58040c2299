//! Design of discriminating experiments.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use trundle_diagnose::design::{DesignedExperiment, Limits, PushedObject, design_experiment};
use trundle_infer::Stage;
use trundle_model::{Body, Model};
use trundle_record::{Noise, prepare};

use crate::error::{refused, run};
use crate::model::PyModel;
use crate::plain::plain;
use crate::record::recording_of;
use crate::watch::watched;

/// Stages of the progress: fits of both models, then the search for pushes.
const STAGES: [Stage; 2] =
    [Stage { name: "fit", end: 0.6, rounds: 6.0 }, Stage { name: "designing pushes", end: 1.0, rounds: 1.0 }];

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_design, module)?)
}

/// Design pushes that discriminate between two models, see `trundle.design`. Returns
/// the experiment as a dict, and both models with their values.
#[pyfunction]
#[pyo3(signature = (first, second, *, recording=None, body=None, noise, limits, count=1, progress=None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
fn _design(
    py: Python<'_>,
    first: PyRef<'_, PyModel>,
    second: PyRef<'_, PyModel>,
    recording: Option<&Bound<'_, PyAny>>,
    body: Option<PyRef<'_, PyModel>>,
    noise: [f64; 4],
    limits: BTreeMap<String, f64>,
    count: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Py<PyAny>, PyModel, PyModel)> {
    let models = [&first, &second].map(|given| (given.model.clone(), given.posterior.clone()));
    let data = match recording {
        Some(recording) => {
            let source = recording_of(recording)?;
            Some(run(py, || prepare(&source))?)
        }
        None => None,
    };
    let limits = with_limits(data.as_ref().map_or_else(Limits::default, Limits::from_recording), &limits)?;
    let object = match &data {
        Some(data) => PushedObject::Recorded(data),
        None => PushedObject::New(body_of(body, &models[0].0)?, noise_from(noise)?),
    };
    let DesignedExperiment { experiment, models } = watched(py, progress, &STAGES, |watch| {
        design_experiment([&models[0], &models[1]], &object, limits, count, watch)
    })?;
    let [first, second] = models.map(|model| PyModel { model, posterior: None });
    Ok((plain(py, &experiment)?.unbind(), first, second))
}

/// The body of the object; `None` if that of the first model applies.
fn body_of(body: Option<PyRef<'_, PyModel>>, model: &Model) -> PyResult<Option<Body>> {
    match body {
        Some(given) => Ok(Some(given.model.body.clone())),
        None if model.body.fixtures.is_empty() => {
            Err(refused("the first model has no footprint: pass `object` or `recording`"))
        }
        None => Ok(None),
    }
}

fn noise_from([position, heading, force, torque]: [f64; 4]) -> PyResult<Noise> {
    if let Some(value) = [position, heading, force, torque].iter().find(|v| !(v.is_finite() && **v > 0.0)) {
        return Err(refused(format!(
            "noise: {value} is not a standard deviation; each must be a positive number"
        )));
    }
    Ok(Noise { pose: [position, position, heading], force, torque, time: 0.0, stated: true })
}

fn with_limits(mut limits: Limits, given: &BTreeMap<String, f64>) -> PyResult<Limits> {
    for (name, &value) in given {
        *match name.as_str() {
            "force" => &mut limits.force,
            "torque" => &mut limits.torque,
            "duration" => &mut limits.duration,
            "speed" => &mut limits.speed,
            "spin" => &mut limits.spin,
            "distance" => &mut limits.distance,
            other => {
                return Err(refused(format!(
                    "limits: unknown limit '{other}'; use force, torque, duration, speed, spin or distance"
                )));
            }
        } = value;
    }
    match limits.first_invalid() {
        Some((name, value)) => Err(refused(format!("{name} = {value}: a limit must be a positive number"))),
        None => Ok(limits),
    }
}
