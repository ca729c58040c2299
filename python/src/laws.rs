//! A model's laws for another simulator: what they do in one of its steps; and draws of its posterior.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trundle_model::{Clock, Model, Plant, State, to_body};
use trundle_posterior::Draws;

use crate::error::refused;
use crate::model::PyModel;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyLaws>()?;
    module.add_function(wrap_pyfunction!(_draw, module)?)?;
    module.add_function(wrap_pyfunction!(_ranges, module)?)
}

/// The laws of a model whose values are all given, one step at a time.
///
/// Parameters
/// ----------
/// model : Model
///     With a value for every parameter.
/// parameters : mapping of str to float, optional
///     Values in the place of the model's, by the names of `Model.parameters`.
///
/// Raises
/// ------
/// TrundleError
///     If a name is unknown, a value out of bounds, or a parameter has none.
#[pyclass(frozen, name = "Laws", module = "trundle")]
struct PyLaws {
    plant: Plant<f64>,
}

#[pymethods]
impl PyLaws {
    #[new]
    #[pyo3(signature = (model, parameters=None))]
    fn new(model: &PyModel, parameters: Option<BTreeMap<String, f64>>) -> PyResult<Self> {
        let values = values(&model.model, &parameters.unwrap_or_default())?;
        Ok(Self { plant: model.model.plant(&values).map_err(refused)? })
    }

    /// Mass, kg.
    #[getter]
    fn mass(&self) -> f64 {
        self.plant.mass
    }

    /// Mass centre in the object frame, m.
    #[getter]
    fn com(&self) -> [f64; 2] {
        self.plant.com
    }

    /// Inertia about the mass centre, kg·m².
    #[getter]
    fn inertia(&self) -> f64 {
        self.plant.inertia
    }

    /// What all laws do to the object at a state.
    ///
    /// Parameters
    /// ----------
    /// pose, twist : array_like, shape (3,)
    ///     Of the object frame, world axes, [m, m, rad] and [m/s, m/s, rad/s].
    /// since_contact : float
    ///     Time since contact began, s; negative before.
    ///
    /// Returns
    /// -------
    /// list of float
    ///     Wrench [N, N, N·m] in the object's axes about its origin.
    #[pyo3(signature = (pose, twist, since_contact=0.0))]
    fn wrench(&self, pose: [f64; 3], twist: [f64; 3], since_contact: f64) -> [f64; 3] {
        let state = State::moving(pose, twist);
        self.plant.action(&state, Clock::since_contact(since_contact)).wrench(to_body(twist, pose[2]))
    }

    /// What the laws do over one step of a simulator that takes damping implicitly.
    ///
    /// With D the matrix of the dampers and M that of the masses, a step `M (v' − v)/dt = push − D v' + force` under a
    /// `force` that does not change ends in the velocity of trundle's own step; under another force the dampers
    /// answer as the laws would, to first order.
    ///
    /// Parameters
    /// ----------
    /// pose, twist : array_like, shape (3,)
    ///     Of the object frame, world axes, [m, m, rad] and [m/s, m/s, rad/s].
    /// force : array_like, shape (3,)
    ///     What else acts: wrench [N, N, N·m] in the object's axes about its origin.
    /// dt : float
    ///     Length of the step, s.
    /// since_contact : float
    ///     Time since contact began, s; negative before.
    ///
    /// Returns
    /// -------
    /// push : list of float
    ///     Wrench [N, N, N·m] in the object's axes about its origin.
    /// damping : list of float
    ///     Lower triangle [xx, xy, yy, xθ, yθ, θθ] of D in the same axes.
    #[pyo3(signature = (pose, twist, force, dt, since_contact=0.0))]
    fn step(
        &self,
        pose: [f64; 3],
        twist: [f64; 3],
        force: [f64; 3],
        dt: f64,
        since_contact: f64,
    ) -> ([f64; 3], [f64; 6]) {
        let (state, clock) = (State::moving(pose, twist), Clock::since_contact(since_contact));
        let after = self.plant.step(&state, force, clock, dt);
        let drag = self.plant.action(&after, clock).drag;
        let (before, after) = (to_body(twist, pose[2]), to_body(after.twist, pose[2]));
        let gained = self.momentum([0, 1, 2].map(|k| (after[k] - before[k]) / dt), before[2]);
        let braked = multiplied(drag, after);
        ([0, 1, 2].map(|k| gained[k] + braked[k] - force[k]), drag)
    }
}

impl PyLaws {
    /// Wrench about the origin, object axes, that gives the origin the acceleration `[x, y, spin]`.
    fn momentum(&self, [ax, ay, alpha]: [f64; 3], spin: f64) -> [f64; 3] {
        let (Plant { mass, inertia, .. }, [x, y]) = (&self.plant, self.plant.com);
        let fx = mass * (ax - alpha * y - spin * spin * x);
        let fy = mass * (ay + alpha * x - spin * spin * y);
        [fx, fy, inertia * alpha + x * fy - y * fx]
    }
}

/// `D v`.
fn multiplied([xx, xy, yy, tx, ty, tt]: [f64; 6], [vx, vy, spin]: [f64; 3]) -> [f64; 3] {
    [xx * vx + xy * vy + tx * spin, xy * vx + yy * vy + ty * spin, tx * vx + ty * vy + tt * spin]
}

/// A value for each slot: the caller's, else the model's.
fn values(model: &Model, given: &BTreeMap<String, f64>) -> PyResult<Vec<f64>> {
    let slots = model.slots();
    if let Some(name) = given.keys().find(|name| slots.iter().all(|s| s.name != **name)) {
        let known: Vec<&str> = slots.iter().map(|s| s.name.as_str()).collect();
        return Err(refused(format!("parameters: there is no `{name}`; the model has {}", known.join(", "))));
    }
    slots
        .iter()
        .map(|slot| match given.get(&slot.name).copied().or(slot.value) {
            Some(value) if (slot.lower..=slot.upper).contains(&value) => Ok(value),
            Some(value) => Err(refused(format!(
                "parameters: {} = {value}: must lie in [{}, {}] {}",
                slot.name, slot.lower, slot.upper, slot.unit
            ))),
            None => Err(refused(format!("{} has no value: give one, or fit the model first", slot.name))),
        })
        .collect()
}

fn draws(model: &PyModel) -> PyResult<Option<Draws>> {
    model.posterior.as_ref().map(|posterior| Draws::new(&model.model, posterior)).transpose().map_err(refused)
}

/// A value for every parameter of a model: drawn from its posterior, where it has one.
#[pyfunction]
fn _draw<'py>(py: Python<'py>, model: &PyModel, seed: u64) -> PyResult<Bound<'py, PyDict>> {
    let drawn = PyDict::new(py);
    for (slot, value) in model.model.slots().iter().zip(values(&model.model, &BTreeMap::new())?) {
        drawn.set_item(&slot.name, value)?;
    }
    if let Some(draws) = draws(model)? {
        for (name, value) in draws.draw(&mut ChaCha8Rng::seed_from_u64(seed)) {
            drawn.set_item(name, value)?;
        }
    }
    Ok(drawn)
}

/// Name, unit, mean, 95 % interval.
type Told = (String, &'static str, f64, [f64; 2]);

/// Name, unit, mean and 95 % interval of every parameter that a model's posterior holds.
#[pyfunction]
fn _ranges(model: &PyModel) -> PyResult<Vec<Told>> {
    let ranges = draws(model)?.map_or(vec![], |draws| draws.ranges());
    Ok(ranges.into_iter().map(|r| (r.name, r.unit, r.mean, r.interval)).collect())
}
