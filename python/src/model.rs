//! Models and the catalogue of effects.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trundle_model::{
    EffectTarget, InnerState, Model, NotFinite, Param, Posterior, Prior, Slot, Spec, State, catalogue,
    rollout,
};
use trundle_posterior::Draws;

use crate::display;
use crate::error::{NotFiniteError, in_file, refused, run_here};

/// One row per sample.
type Table<'py> = Bound<'py, PyArray2<f64>>;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyModel>()?;
    module.add_function(wrap_pyfunction!(_draw, module)?)?;
    module.add_function(wrap_pyfunction!(_ranges, module)?)?;
    module.add_function(wrap_pyfunction!(effects, module)?)
}

/// A rigid body plus a list of effects, as in `model.toml`.
///
/// Examples
/// --------
/// >>> model = trundle.Model.read("model.toml")
/// >>> model.effects
/// ['viscous_wheel', 'coulomb_friction']
/// >>> [parameter["name"] for parameter in model.parameters][:2]
/// ['body.mass', 'viscous_wheel.x']
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
        let text = fs::read_to_string(&path).map_err(|error| in_file(&path, error))?;
        let (model, posterior) = Model::from_toml(&text).map_err(|error| in_file(&path, error))?;
        Ok(Self { model, posterior })
    }

    /// The text of a `model.toml`.
    fn to_toml(&self) -> PyResult<String> {
        self.model.to_toml(self.posterior.as_ref()).map_err(refused)
    }

    /// Write a `model.toml` atomically.
    fn write(&self, path: PathBuf) -> PyResult<()> {
        let text = self.to_toml()?;
        let mut partial = path.clone().into_os_string();
        partial.push(format!(".partial-{}", std::process::id()));
        let written = fs::write(&partial, text).and_then(|()| fs::rename(&partial, &path));
        written.map_err(|error| {
            // Remove the partial file, and report the first error.
            let _ = fs::remove_file(&partial);
            in_file(&path, error)
        })
    }

    /// Names of the effects, in the order of the model, as in the names of the parameters.
    #[getter]
    fn effects(&self) -> Vec<String> {
        self.model.effect_names()
    }

    /// All scalar parameters: dicts with `name`, `unit`, `lower`, `upper` and `value` (None for a free parameter).
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.model.slots().iter().map(|slot| slot_dict(py, slot)).collect()
    }

    /// The same model with the parameters of its posterior set free, for another fit.
    ///
    /// Returns
    /// -------
    /// Model
    ///     Model with the same laws and without a posterior. A model without a posterior is returned unchanged.
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
    ///     The parameters vary according to their covariance, within their bounds. Parameters without a posterior
    ///     keep their values.
    ///
    /// Raises
    /// ------
    /// TrundleError
    ///     If a parameter has no value.
    fn drawn(&self, seed: u64) -> PyResult<Self> {
        let mut values = self.model.values_with(&BTreeMap::new()).map_err(refused)?;
        if let Some(draws) = self.draws()? {
            for (name, value) in draws.draw(&mut ChaCha8Rng::seed_from_u64(seed)) {
                let slots = self.model.slots();
                let named = slots.iter().zip(&mut values).filter(|(slot, _)| slot.name == name);
                named.for_each(|(_, current)| *current = value);
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
    ///     Wrench on the object, [N, N, N·m], object axes about the object origin. It is interpolated linearly
    ///     between samples.
    /// contact : float, optional
    ///     Time of first contact, s; the first time by default. Some laws act from then on.
    /// inner : sequence of float, optional
    ///     Initial values of the laws' inner states, in the order of the model's effects: the angle of a caster in
    ///     rad; the displacement in m and the velocity in m/s of a swinging load, world axes. By default the first
    ///     possible start of each law.
    ///
    /// Returns
    /// -------
    /// poses, twists : ndarray, shape (n, 3)
    ///     At the times `t`.
    ///
    /// Raises
    /// ------
    /// TrundleError
    ///     If a parameter of the model is free, a shape or a number is wrong, or the motion is not finite. In the
    ///     last case, the message names the likely cause.
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
        let inner = self.model.inner_with(&inner.unwrap_or_default()).map_err(refused)?;
        let (t, wrench) = samples(t, wrench)?;
        let contact = contact.unwrap_or(t[0]);
        if !pose0.iter().chain(&twist0).chain([&contact]).all(|value| value.is_finite()) {
            return Err(refused("pose0, twist0 and contact must be finite"));
        }
        let start = State::moving(pose0, twist0).with_inner(inner);
        let motion = run_here(py, || Ok::<_, String>(rollout(&plant, start, &t, &wrench, contact)))?;
        if let Some(k) = motion.iter().position(|state| !state.is_finite()) {
            return Err(NotFiniteError::new_err(NotFinite::of(&self.model, t[k] - t[0]).to_string()));
        }
        let rows = |of: fn(&State<f64>) -> [f64; 3]| {
            let flat = motion.iter().flat_map(of).collect();
            PyArray1::from_vec(py, flat).reshape([motion.len(), 3])
        };
        Ok((rows(|state| state.pose)?, rows(|state| state.twist)?))
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        display::text(slf, "model_card")
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        display::html(slf, "model_card")
    }
}

impl PyModel {
    /// Draws of the posterior; `None` without a posterior.
    fn draws(&self) -> PyResult<Option<Draws>> {
        let draws = self.posterior.as_ref().map(|posterior| Draws::new(&self.model, posterior));
        draws.transpose().map_err(refused)
    }
}

/// A value for every parameter of a model, drawn from its posterior if it has one.
#[pyfunction]
fn _draw<'py>(py: Python<'py>, model: &PyModel, seed: u64) -> PyResult<Bound<'py, PyDict>> {
    let drawn = PyDict::new(py);
    let values = model.model.values_with(&BTreeMap::new()).map_err(refused)?;
    for (slot, value) in model.model.slots().iter().zip(values) {
        drawn.set_item(&slot.name, value)?;
    }
    if let Some(draws) = model.draws()? {
        for (name, value) in draws.draw(&mut ChaCha8Rng::seed_from_u64(seed)) {
            drawn.set_item(name, value)?;
        }
    }
    Ok(drawn)
}

/// Name, unit, mean and 95 % interval of a parameter.
type RangeRow = (String, &'static str, f64, [f64; 2]);

/// Ranges of the parameters in a model's posterior.
#[pyfunction]
fn _ranges(model: &PyModel) -> PyResult<Vec<RangeRow>> {
    let ranges = model.draws()?.map_or(vec![], |draws| draws.ranges());
    Ok(ranges.into_iter().map(|r| (r.name, r.unit, r.mean, r.interval)).collect())
}

/// All effects, in the order of the catalogue.
///
/// Returns
/// -------
/// list of dict
///     `kind` (name in `model.toml`), `effect` (name in a diagnosis), `summary`, `sentence`, `source`,
///     `acting` ("object" or "instrument"), `dissipative`, `states` (inner states: dicts with `name`, `unit` and
///     possible `starts`), and `parameters`: dicts with `name`, `unit`, `lower`, `upper`, `neutral` (value at which
///     the effect vanishes, or None), `default` (value if a file omits it; None for a free parameter), `prior`,
///     `on_rail` and `help`.
///
/// Examples
/// --------
/// >>> [effect["kind"] for effect in trundle.effects()][:2]
/// ['viscous_wheel', 'coulomb_friction']
#[pyfunction]
fn effects(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    catalogue().map(|spec| spec_dict(py, spec)).collect()
}

/// Times and wrenches, checked.
fn samples(t: &Bound<'_, PyAny>, wrench: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, Vec<[f64; 3]>)> {
    let t: Vec<f64> = floats(t)?.extract().map_err(|_| refused("t: must have the shape (n,)"))?;
    let wrench: Vec<[f64; 3]> =
        floats(wrench)?.extract().map_err(|_| refused("wrench: must have the shape (n, 3)"))?;
    if t.is_empty() || t.len() != wrench.len() {
        let (times, rows) = (t.len(), wrench.len());
        return Err(refused(format!(
            "t has {times} values and wrench {rows} rows: give one of each per sample"
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
    // A property of the body is NaN in the catalogue, because it differs between bodies.
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
