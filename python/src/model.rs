//! Models and the catalogue of effects.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trundle_model::{
    Clock, EffectTarget, InnerState, MAX_INNER_STATES, Model, NotFinite, Param, Plant, Posterior, Prior,
    Slot, Spec, State, catalogue,
};

use crate::error::{NotFiniteError, TrundleError, refused, run_here};

/// A row for each sample.
type Table<'py> = Bound<'py, PyArray2<f64>>;

/// Longest step of a rollout, s: between samples the wrench is interpolated.
const LONGEST_STEP: f64 = 2e-3;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyModel>()?;
    module.add_function(wrap_pyfunction!(effects, module)?)
}

/// A rigid body plus a list of effects, as in `model.toml`.
#[pyclass(frozen, name = "Model", module = "trundle")]
pub(crate) struct PyModel {
    pub(crate) model: Model,
    pub(crate) posterior: Option<Posterior>,
}

#[pymethods]
impl PyModel {
    /// Read the text of a `model.toml`.
    #[staticmethod]
    pub(crate) fn from_toml(text: &str) -> PyResult<Self> {
        let (model, posterior) = Model::from_toml(text).map_err(refused)?;
        Ok(Self { model, posterior })
    }

    /// Read a `model.toml`.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        let text = fs::read_to_string(&path).map_err(|error| at(&path, error))?;
        let (model, posterior) = Model::from_toml(&text).map_err(|error| at(&path, error))?;
        Ok(Self { model, posterior })
    }

    /// The text of a `model.toml`.
    fn to_toml(&self) -> PyResult<String> {
        self.model.to_toml(self.posterior.as_ref()).map_err(refused)
    }

    /// Write a `model.toml`; it appears whole or not at all.
    fn write(&self, path: PathBuf) -> PyResult<()> {
        let text = self.to_toml()?;
        let mut partial = path.clone().into_os_string();
        partial.push(format!(".partial-{}", std::process::id()));
        let written = fs::write(&partial, text).and_then(|()| fs::rename(&partial, &path));
        written.map_err(|error| {
            // What is left over is of no use to anyone; the first error is the one to tell.
            let _ = fs::remove_file(&partial);
            at(&path, error)
        })
    }

    /// Every scalar parameter: a list of dicts with `name`, `unit`, `lower`, `upper`, and `value`,
    /// which is None where the parameter is free.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.model.slots().iter().map(|slot| slot_dict(py, slot)).collect()
    }

    /// The same model with what its posterior holds set free, to be fitted again.
    ///
    /// Returns
    /// -------
    /// Model
    ///     Without a posterior; the same laws. A model without a posterior comes back as it is.
    fn freed(&self) -> Self {
        let names = self.posterior.as_ref().map_or(&[][..], |posterior| &posterior.names);
        Self { model: self.model.with_free(names), posterior: None }
    }

    /// A model drawn from the posterior, with all values given.
    ///
    /// Parameters
    /// ----------
    /// seed : int
    ///     The same seed gives the same model.
    ///
    /// Returns
    /// -------
    /// Model
    ///     The parameters vary together, as their covariance says, within their bounds; what the posterior leaves
    ///     out keeps its value.
    ///
    /// Raises
    /// ------
    /// TrundleError
    ///     If a value is free.
    fn drawn(&self, seed: u64) -> PyResult<Self> {
        let mut values = crate::laws::values(&self.model, &BTreeMap::new())?;
        if let Some(draws) = crate::laws::draws(self)? {
            for (name, value) in draws.draw(&mut ChaCha8Rng::seed_from_u64(seed)) {
                let slots = self.model.slots();
                let places = slots.iter().zip(&mut values).filter(|(slot, _)| slot.name == name);
                places.for_each(|(_, place)| *place = value);
            }
        }
        Ok(Self { model: self.model.with_values(&values).map_err(refused)?, posterior: None })
    }

    /// The motion under a wrench on the object.
    ///
    /// Parameters
    /// ----------
    /// pose0 : array_like, shape (3,)
    ///     Pose of the object frame in the world at the first time, [m, m, rad].
    /// twist0 : array_like, shape (3,)
    ///     Velocity of its origin and spin, world axes, [m/s, m/s, rad/s].
    /// t : array_like, shape (n,)
    ///     Increasing times, s.
    /// wrench : array_like, shape (n, 3)
    ///     What truly acts, [N, N, N·m], object axes about the object origin: it turns with the
    ///     object. Linear between samples.
    /// contact : float, optional
    ///     When contact begins, s; the first time by default. Some laws act from then on.
    /// inner : sequence of float, optional
    ///     Where the laws' own states begin, in the order of the model's effects: a caster's angle in rad; of a
    ///     swinging load, displacement in m and velocity in m/s, world axes. By default the first start that
    ///     each law offers.
    ///
    /// Returns
    /// -------
    /// poses, twists : ndarray, shape (n, 3)
    ///     At the times `t`.
    ///
    /// Raises
    /// ------
    /// TrundleError
    ///     If a parameter of the model is free, a shape or number is wrong, or the motion is not finite; the message
    ///     then names the parameter to look at first.
    #[pyo3(signature = (pose0, twist0, t, wrench, *, contact=None, inner=None))]
    #[allow(clippy::too_many_arguments)]
    fn rollout<'py>(
        &self,
        py: Python<'py>,
        pose0: [f64; 3],
        twist0: [f64; 3],
        t: &Bound<'py, PyAny>,
        wrench: &Bound<'py, PyAny>,
        contact: Option<f64>,
        inner: Option<Vec<f64>>,
    ) -> PyResult<(Table<'py>, Table<'py>)> {
        let plant = self.model.resolved().map_err(refused)?;
        let inner = starts(&self.model, inner)?;
        let (t, wrench) = samples(t, wrench)?;
        let contact = contact.unwrap_or(t[0]);
        if !pose0.iter().chain(&twist0).chain([&contact]).all(|value| value.is_finite()) {
            return Err(refused("pose0, twist0 and contact must be finite"));
        }
        let start = State::moving(pose0, twist0).with_inner(inner);
        let motion = run_here(py, || Ok::<_, String>(roll(&plant, start, &t, &wrench, contact)))?;
        if let Some(k) = motion.iter().position(|state| !state.is_finite()) {
            return Err(NotFiniteError::new_err(NotFinite::of(&self.model, t[k] - t[0]).to_string()));
        }
        let rows = |of: fn(&State<f64>) -> [f64; 3]| {
            let flat = motion.iter().flat_map(of).collect();
            PyArray1::from_vec(py, flat).reshape([motion.len(), 3])
        };
        Ok((rows(|state| state.pose)?, rows(|state| state.twist)?))
    }

    fn __repr__(&self) -> String {
        let mass = self.model.mass.map_or("free mass".to_owned(), |mass| format!("{mass} kg"));
        let names = self.model.effect_names().join(", ");
        format!("<trundle.Model: {mass}, {}>", if names.is_empty() { "no effects" } else { &names })
    }
}

/// Every effect there is, in the catalogue's order.
///
/// Returns
/// -------
/// list of dict
///     `kind` (name in `model.toml`), `effect` (name in a diagnosis), `summary`, `sentence`, `source`,
///     `acting` ("object" or "instrument"), `dissipative`, `states` (dicts with `name`, `unit` and `starts`: the
///     effect's own states, and where they may begin), and `parameters`: dicts with `name`,
///     `unit`, `lower`, `upper`, `neutral` (value at which the effect vanishes, or None), `default`
///     (value if left out of a file; None: free), `prior`, `on_rail` and `help`.
#[pyfunction]
fn effects(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    catalogue().map(|spec| spec_dict(py, spec)).collect()
}

fn at(path: &Path, error: impl std::fmt::Display) -> PyErr {
    TrundleError::new_err(format!("{}: {error}", path.display()))
}

/// Where the laws' own states begin, checked.
fn starts(model: &Model, given: Option<Vec<f64>>) -> PyResult<[f64; MAX_INNER_STATES]> {
    let own = model.inner();
    let first = || own.iter().map(|inner| inner.starts.first().copied().unwrap_or_default()).collect();
    let values = given.unwrap_or_else(first);
    if values.len() != own.len() || !values.iter().all(|value| value.is_finite()) {
        let names: Vec<&str> = own.iter().map(|inner| inner.name).collect();
        return Err(refused(format!("inner = {values:?}: must be {} finite numbers {names:?}", own.len())));
    }
    Ok(std::array::from_fn(|k| values.get(k).copied().unwrap_or_default()))
}

/// Times and wrenches, checked.
fn samples(t: &Bound<'_, PyAny>, wrench: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, Vec<[f64; 3]>)> {
    let t: Vec<f64> = floats(t)?.extract().map_err(|_| refused("t: must have the shape (n,)"))?;
    let wrench: Vec<[f64; 3]> =
        floats(wrench)?.extract().map_err(|_| refused("wrench: must have the shape (n, 3)"))?;
    if t.is_empty() || t.len() != wrench.len() {
        let (times, rows) = (t.len(), wrench.len());
        return Err(refused(format!(
            "t has {times} values and wrench {rows} rows: both need one for each sample"
        )));
    }
    for (k, (time, row)) in t.iter().zip(&wrench).enumerate() {
        if !time.is_finite() || (k > 0 && t[k - 1] >= *time) {
            return Err(refused(format!("t[{k}] = {time}: times must be finite and increase")));
        }
        if !row.iter().all(|value| value.is_finite()) {
            return Err(refused(format!("wrench[{k}] = {row:?}: must be finite")));
        }
    }
    Ok((t, wrench))
}

fn floats<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    value.py().import("numpy")?.getattr("asarray")?.call1((value, "float64"))
}

fn roll(
    plant: &Plant<f64>,
    start: State<f64>,
    t: &[f64],
    wrench: &[[f64; 3]],
    contact: f64,
) -> Vec<State<f64>> {
    let mut motion = vec![start];
    let mut state = start;
    for (times, ends) in t.windows(2).zip(wrench.windows(2)) {
        let span = times[1] - times[0];
        let steps = (span / LONGEST_STEP).ceil().max(1.0);
        let dt = span / steps;
        for step in 0..steps as usize {
            let middle = (step as f64 + 0.5) / steps;
            let mean = [0, 1, 2].map(|k| ends[0][k] + middle * (ends[1][k] - ends[0][k]));
            let begin = times[0] + step as f64 * dt;
            let clock = Clock { t: begin + dt / 2.0, dt, ..Clock::since_contact(begin - contact) };
            state = plant.step(&state, mean, clock, dt);
        }
        motion.push(state);
    }
    motion
}

fn slot_dict<'py>(py: Python<'py>, slot: &Slot) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("name", &slot.name)?;
    dict.set_item("unit", slot.unit)?;
    dict.set_item("lower", slot.lower)?;
    dict.set_item("upper", slot.upper)?;
    dict.set_item("value", slot.value)?;
    Ok(dict)
}

fn spec_dict<'py>(py: Python<'py>, spec: &Spec) -> PyResult<Bound<'py, PyDict>> {
    let acting = match spec.target {
        EffectTarget::Object => "object",
        EffectTarget::Instrument => "instrument",
    };
    let dict = PyDict::new(py);
    for (key, text) in [
        ("kind", spec.kind),
        ("effect", spec.effect),
        ("summary", spec.summary),
        ("sentence", spec.sentence),
        ("source", spec.source),
        ("acting", acting),
    ] {
        dict.set_item(key, text)?;
    }
    dict.set_item("dissipative", spec.is_dissipative)?;
    let states = spec.inner_states.iter().map(|inner| state_dict(py, inner));
    dict.set_item("states", states.collect::<PyResult<Vec<_>>>()?)?;
    let params = spec.params.iter().map(|param| param_dict(py, spec, param));
    dict.set_item("parameters", params.collect::<PyResult<Vec<_>>>()?)?;
    Ok(dict)
}

fn state_dict<'py>(py: Python<'py>, inner: &InnerState) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("name", inner.name)?;
    dict.set_item("unit", inner.unit)?;
    dict.set_item("starts", inner.starts)?;
    Ok(dict)
}

fn param_dict<'py>(py: Python<'py>, spec: &Spec, param: &Param) -> PyResult<Bound<'py, PyDict>> {
    let neutral = spec.neutral.iter().find(|(name, _)| *name == param.name).map(|(_, value)| *value);
    // The body's own value, which is another for each, is not a number.
    let neutral = neutral.filter(|value| value.is_finite());
    let dict = PyDict::new(py);
    dict.set_item("name", param.name)?;
    dict.set_item("unit", param.unit)?;
    dict.set_item("lower", param.lower)?;
    dict.set_item("upper", param.upper)?;
    dict.set_item("neutral", neutral)?;
    dict.set_item("default", param.refinement)?;
    dict.set_item("prior", prior_dict(py, param.prior)?)?;
    dict.set_item("on_rail", param.on_rail)?;
    dict.set_item("help", param.help)?;
    Ok(dict)
}

fn prior_dict(py: Python<'_>, prior: Prior) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    let is = |name: &str| dict.set_item("distribution", name);
    match prior {
        Prior::Normal { mean, sd } => {
            is("normal")?;
            dict.set_item("mean", mean)?;
            dict.set_item("sd", sd)?;
        }
        Prior::LogNormal { median, sd } => {
            is("log_normal")?;
            dict.set_item("median", median)?;
            dict.set_item("sd", sd)?;
        }
        Prior::Uniform => is("uniform")?,
        Prior::OnBody(axis) => {
            is("on_body")?;
            dict.set_item("axis", ["x", "y"].get(axis))?;
        }
        Prior::Angle(period) => {
            is("angle")?;
            dict.set_item("period", period)?;
        }
    }
    Ok(dict)
}
