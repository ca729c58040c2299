//! Experiments of the paper in Python.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_infer::Stage;
use trundle_paper::{
    Learner, LearningCurves, ModelError, ObservationNoise, OpenLoopTrial, PaperError, PathTask, PbrSettings,
    learning_curves,
};

use crate::error::refused;
use crate::model::PyModel;
use crate::plain::plain;
use crate::toml_dict;
use crate::watch::{once, watched_request};

/// Many fits, each of which reports its own progress.
const STAGES: [Stage; 1] = once("fit");

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_learning_curves, module)?)?;
    module.add_function(wrap_pyfunction!(_open_loop, module)?)
}

/// Scores after numbers of noisy pushes; see `trundle.experiments.paper`.
///
/// `truth` is the model of the object, `form` the model to fit. Returns r² of each
/// learner after each count, and r² of the prediction of a constant velocity.
#[pyfunction]
#[pyo3(signature = (truth, form, learners, counts, noise, seed, *, tested=200, starts=8, progress=None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
fn _learning_curves(
    py: Python<'_>,
    truth: PyRef<'_, PyModel>,
    form: PyRef<'_, PyModel>,
    learners: Vec<String>,
    counts: Vec<usize>,
    noise: (String, f64),
    seed: u64,
    tested: usize,
    starts: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Vec<Vec<f64>>, f64)> {
    let (object, model) = (truth.model.clone(), form.model.clone());
    let learners = learners.iter().map(|name| Learner::named(name)).collect::<Result<Vec<_>, _>>();
    let (learners, noise) = (learners.map_err(refused)?, observation_noise(&noise)?);
    let settings = PbrSettings { model: &model, starts, seed };
    let LearningCurves { r2, baseline } = watched_request(py, progress, &STAGES, |watch| {
        learning_curves(&object, &learners, &counts, (noise, tested), &settings, watch)
    })?;
    Ok((r2, baseline))
}

/// Open-loop trials with perturbed models of the given sizes, then with models fitted to the given numbers of pushes. Each
/// result is a dict; see `trundle.experiments.paper`.
#[pyfunction]
#[pyo3(signature = (truth, form, course, sizes, counts, noise, seed, *, tested=200, starts=8, progress=None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
fn _open_loop<'py>(
    py: Python<'py>,
    truth: PyRef<'_, PyModel>,
    form: PyRef<'_, PyModel>,
    course: &Bound<'py, PyDict>,
    sizes: Vec<f64>,
    counts: Vec<usize>,
    noise: (String, f64),
    seed: u64,
    tested: usize,
    starts: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (object, model, noise) = (truth.model.clone(), form.model.clone(), observation_noise(&noise)?);
    let task: PathTask = toml_dict::from_dict(course, "course")?
        .try_into()
        .map_err(|error: toml::de::Error| refused(format!("course: {}", error.message())))?;
    let settings = PbrSettings { model: &model, starts, seed };
    let trial = OpenLoopTrial { object: &object, task: &task, test_count: tested, settings };
    let perturbed = sizes.into_iter().map(ModelError::Perturbed);
    let errors: Vec<_> = perturbed.chain(counts.into_iter().map(|n| ModelError::Fitted(n, noise))).collect();
    let found = watched_request(py, progress, &STAGES, |watch| {
        errors.iter().map(|&error| trial.run(error, watch)).collect::<Result<Vec<_>, PaperError>>()
    })?;
    plain(py, &found)
}

fn observation_noise((reading, sigma): &(String, f64)) -> PyResult<ObservationNoise> {
    ObservationNoise::named(reading, *sigma).map_err(refused)
}
