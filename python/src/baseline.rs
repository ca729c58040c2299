//! Transitions, regression baselines and object files in Python.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_control::Dynamics;
use trundle_infer::{
    BodyRegression, Features, Linear, Local, Predictor, Pushes, SigmaReading, StateVector, StepNoise,
    Transition, hold, noisy, r2_of, transitions, transitions_of,
};
use trundle_model::{Clock, State};
use trundle_record::prepare;
use trundle_sim::Object;

use crate::error::{refused, run};
use crate::model::PyModel;
use crate::record::recording_of;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Regression>()?;
    module.add_class::<PyBodyRegression>()?;
    module.add_function(wrap_pyfunction!(_transitions, module)?)?;
    module.add_function(wrap_pyfunction!(_cut, module)?)?;
    module.add_function(wrap_pyfunction!(_noisy, module)?)?;
    module.add_function(wrap_pyfunction!(_noise_sd, module)?)?;
    module.add_function(wrap_pyfunction!(_hold, module)?)?;
    module.add_function(wrap_pyfunction!(_r2, module)?)?;
    module.add_function(wrap_pyfunction!(_object, module)?)
}

type States = Vec<StateVector>;
type Wrenches = Vec<[f64; 3]>;
/// States before (n, 6), wrenches (n, 3), durations (n,), states after (n, 6).
type Columns = (States, Wrenches, Vec<f64>, States);
type Table<'py> = Bound<'py, PyArray2<f64>>;
type Arrays<'py> = (Table<'py>, Table<'py>, Bound<'py, PyArray1<f64>>, Table<'py>);

fn rows((before, wrench, dt, after): Columns) -> Vec<Transition> {
    let columns = before.into_iter().zip(wrench).zip(dt).zip(after);
    columns.map(|(((before, wrench), dt), after)| Transition { before, wrench, dt, after }).collect()
}

fn arrays<'py>(py: Python<'py>, data: &[Transition]) -> PyResult<Arrays<'py>> {
    let dt: Vec<f64> = data.iter().map(|t| t.dt).collect();
    Ok((
        table(py, data.iter().map(|t| t.before))?,
        table(py, data.iter().map(|t| t.wrench))?,
        dt.into_pyarray(py),
        table(py, data.iter().map(|t| t.after))?,
    ))
}

fn table<const N: usize>(
    py: Python<'_>,
    rows: impl ExactSizeIterator<Item = [f64; N]>,
) -> PyResult<Table<'_>> {
    let count = rows.len();
    PyArray1::from_vec(py, rows.flatten().collect()).reshape([count, N])
}

/// A fitted regression.
#[pyclass(frozen, name = "_Regression", module = "trundle._native")]
pub(crate) struct Regression(Kind);

enum Kind {
    Linear(Linear),
    Local(Local),
}

#[pymethods]
impl Regression {
    #[staticmethod]
    fn linear(py: Python<'_>, data: Columns, features: &str) -> PyResult<Self> {
        let features = named(features)?;
        run(py, || Linear::fit(&rows(data), features)).map(|found| Self(Kind::Linear(found)))
    }

    #[staticmethod]
    fn local(py: Python<'_>, data: Columns, features: &str) -> PyResult<Self> {
        let features = named(features)?;
        run(py, || Local::fit(&rows(data), features)).map(|found| Self(Kind::Local(found)))
    }

    fn predict<'py>(
        &self,
        py: Python<'py>,
        before: States,
        wrench: Wrenches,
        dt: Vec<f64>,
    ) -> PyResult<Table<'py>> {
        predicted(py, self.predictor(), &before, &wrench, &dt)
    }

    /// Width of the kernel for each feature, in its unit; `None` for a linear regression.
    #[getter]
    fn widths(&self) -> Option<Vec<f64>> {
        match &self.0 {
            Kind::Linear(_) => None,
            Kind::Local(local) => Some(local.widths()),
        }
    }
}

impl Regression {
    fn predictor(&self) -> &(dyn Predictor + Sync) {
        match &self.0 {
            Kind::Linear(linear) => linear,
            Kind::Local(local) => local,
        }
    }
}

/// Regression of a rigid body on viscous wheels.
#[pyclass(name = "_BodyRegression", module = "trundle._native")]
pub(crate) struct PyBodyRegression(BodyRegression);

#[pymethods]
impl PyBodyRegression {
    /// `model` has the outline and the most probable mass. Noise: standard deviations of twists and mean wrenches.
    #[new]
    fn new(model: PyRef<'_, PyModel>, twist_noise: [f64; 3], wrench_noise: [f64; 3]) -> Self {
        let noise = StepNoise { twist: twist_noise, wrench: wrench_noise };
        Self(BodyRegression::new(model.model.body.clone(), noise))
    }

    /// Estimate from all transitions of an episode so far.
    fn update(&mut self, py: Python<'_>, data: Columns) -> PyResult<()> {
        run(py, || self.0.update(&rows(data)))
    }

    /// The most probable model, with the posterior of its identified parameters.
    fn model(&self) -> PyModel {
        PyModel { model: self.0.model(), posterior: self.0.posterior() }
    }
}

/// A regression in place of the laws, for the planner.
impl Dynamics for Regression {
    fn step(&self, state: &mut State<f64>, applied: &[f64; 3], _: Clock, dt: f64) {
        let ([x, y, theta], [vx, vy, spin]) = (state.pose, state.twist);
        let [x, y, theta, vx, vy, spin] = self.predictor().predict(&[x, y, theta, vx, vy, spin], applied, dt);
        (state.pose, state.twist) = ([x, y, theta], [vx, vy, spin]);
    }
}

fn predicted<'py>(
    py: Python<'py>,
    predictor: &(dyn Predictor + Sync),
    before: &States,
    wrench: &Wrenches,
    dt: &[f64],
) -> PyResult<Table<'py>> {
    let all = before.iter().zip(wrench).zip(dt);
    let found: States =
        run(py, || Ok::<_, String>(all.map(|((x, u), dt)| predictor.predict(x, u, *dt)).collect()))?;
    table(py, found.into_iter())
}

fn named(features: &str) -> PyResult<Features> {
    match features {
        "world" => Ok(Features::World),
        "recorded" => Ok(Features::Recorded),
        "body" => Ok(Features::Body),
        _ => Err(refused(format!("features = {features:?}: choose \"world\", \"recorded\" or \"body\""))),
    }
}

/// The settings of `trundle.baselines.Transitions.simulated`, from a dict.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Settings {
    dt: f64,
    per_episode: usize,
    speed: f64,
    spin: f64,
    force: f64,
    arena: f64,
    heading: f64,
}

impl From<Settings> for Pushes {
    fn from(Settings { dt, per_episode, speed, spin, force, arena, heading }: Settings) -> Self {
        Self { dt, per_episode, speed, spin, force, arena, heading }
    }
}

/// Simulated pushes of a model; see `trundle.baselines.Transitions.simulated`.
#[pyfunction]
fn _transitions<'py>(
    py: Python<'py>,
    model: &PyModel,
    n: usize,
    seed: u64,
    settings: Settings,
) -> PyResult<Arrays<'py>> {
    arrays(py, &run(py, || transitions(&model.model, n, seed, &settings.into()))?)
}

/// Transitions of a recording; see `trundle.baselines.Transitions.recorded`.
#[pyfunction]
fn _cut<'py>(recording: &Bound<'py, PyAny>, dt: f64, held_out: bool) -> PyResult<Arrays<'py>> {
    if !(dt.is_finite() && dt > 0.0) {
        return Err(refused(format!("dt = {dt}: must be positive (s)")));
    }
    let (py, source) = (recording.py(), recording_of(recording)?);
    let data = run(py, || {
        let dataset = prepare(&source)?;
        let episodes = if held_out { &dataset.held_out } else { &dataset.training };
        let cut = episodes.iter().flat_map(|episode| transitions_of(episode, &dataset.noise, dt));
        Ok::<_, trundle_record::Error>(cut.collect::<Vec<_>>())
    })?;
    arrays(py, &data)
}

/// Noisy states after the pushes; see `trundle.baselines.Transitions.with_noise`.
#[pyfunction]
fn _noisy(py: Python<'_>, data: Columns, sd: StateVector, seed: u64) -> PyResult<Table<'_>> {
    if let Some(bad) = sd.iter().find(|sd| !(sd.is_finite() && **sd >= 0.0)) {
        return Err(refused(format!("sd = {bad}: must not be negative")));
    }
    table(py, noisy(&rows(data), &sd, seed).into_iter().map(|t| t.after))
}

/// Standard deviation of each channel's noise; see `trundle.baselines.noise_sd`.
#[pyfunction]
fn _noise_sd(sigma: f64, reading: &str, data: Columns) -> PyResult<Vec<f64>> {
    let reading = match reading {
        "si" => SigmaReading::Si,
        "cm_deg" => SigmaReading::CentimetreDegree,
        "of_motion" => SigmaReading::OfMotion,
        _ => {
            let known = "choose \"si\", \"cm_deg\" or \"of_motion\"";
            return Err(refused(format!("reading = {reading:?}: {known}")));
        }
    };
    Ok(reading.sd(sigma, &rows(data)).to_vec())
}

/// Next states of a model with all values given; see `trundle.baselines.PhysicalModel`.
#[pyfunction]
fn _hold<'py>(
    py: Python<'py>,
    model: &PyModel,
    before: States,
    wrench: Wrenches,
    dt: Vec<f64>,
) -> PyResult<Table<'py>> {
    let plant = model.model.resolved().map_err(refused)?;
    let all = before.iter().zip(&wrench).zip(&dt);
    let found: States =
        run(py, || Ok::<_, String>(all.map(|((x, u), dt)| hold(&plant, x, u, *dt)).collect()))?;
    table(py, found.into_iter())
}

/// See `trundle.baselines.r2`.
#[pyfunction]
fn _r2(predicted: States, after: States) -> f64 {
    r2_of(&predicted, &after)
}

/// An object file; see `trundle.objects.read`.
#[pyfunction]
fn _object(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let object = run(py, || Object::read(&path))?;
    let (models, sources) = (PyDict::new(py), PyDict::new(py));
    for name in &object.configurations {
        let model = object.model(Some(name)).map_err(refused)?;
        models.set_item(name, PyModel { model, posterior: None })?;
    }
    for value in object.value_names() {
        sources.set_item(&value, object.source(&value))?;
    }
    let dict = PyDict::new(py);
    let bare = object.model(None).map_err(refused)?;
    dict.set_item("name", &object.name)?;
    dict.set_item("radius", object.radius)?;
    dict.set_item("bare", PyModel { model: bare, posterior: None })?;
    dict.set_item("models", models)?;
    dict.set_item("sources", sources)?;
    Ok(dict)
}
