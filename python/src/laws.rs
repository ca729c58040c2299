//! A model's laws for other simulators, and draws of its posterior.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trundle_model::{Clock, MAX_INNER_STATES, Model, Plant, Rigid, State, to_body};
use trundle_posterior::Draws;

use crate::error::refused;
use crate::model::PyModel;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyLaws>()?;
    module.add_function(wrap_pyfunction!(_draw, module)?)?;
    module.add_function(wrap_pyfunction!(_ranges, module)?)
}

/// The laws of a model whose values are all given, one step at a time: those that act on the object, not those of the
/// instruments.
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
    /// What moves when every event has happened: the body that the other simulator has.
    home: Rigid<f64>,
    /// Of the laws' own states: where each starts.
    starts: Vec<f64>,
}

/// When a law is asked: `t` is that of the table, `episode` the number of the recording's, infinite after all of them.
fn clock(t: f64, dt: f64, contact: f64, episode: f64) -> Clock {
    Clock { t, dt, episode, ..Clock::since_contact(t - contact) }
}

#[pymethods]
impl PyLaws {
    #[new]
    #[pyo3(signature = (model, parameters=None))]
    fn new(model: &PyModel, parameters: Option<BTreeMap<String, f64>>) -> PyResult<Self> {
        let values = values(&model.model, &parameters.unwrap_or_default())?;
        let physics = model.model.with_values(&values).map_err(refused)?.without_instruments();
        let plant = physics.resolved().map_err(refused)?;
        let home = plant.rigid(clock(0.0, 0.0, 0.0, f64::INFINITY));
        let starts = starts(&physics);
        Ok(Self { plant, home, starts })
    }

    /// Mass, kg.
    #[getter]
    fn mass(&self) -> f64 {
        self.home.mass
    }

    /// Mass centre in the object frame, m.
    #[getter]
    fn com(&self) -> [f64; 2] {
        self.home.com
    }

    /// Inertia about the mass centre, kg·m².
    #[getter]
    fn inertia(&self) -> f64 {
        self.home.inertia
    }

    /// Where the laws' own states start (the angle of a caster, …); empty where they have none.
    #[getter]
    fn starts(&self) -> Vec<f64> {
        self.starts.clone()
    }

    /// What all laws do to the object at a state.
    ///
    /// Parameters
    /// ----------
    /// pose, twist : array_like, shape (3,)
    ///     Of the object frame, world axes, [m, m, rad] and [m/s, m/s, rad/s].
    /// t : float
    ///     Time, s: that of the recording's table, for events.
    /// contact : float
    ///     When contact begins, s: some laws act from then on.
    /// episode : float
    ///     Number of the recording's episode, from 0, for events; after all of them by default.
    /// inner : sequence of float
    ///     The laws' own states.
    ///
    /// Returns
    /// -------
    /// list of float
    ///     Wrench [N, N, N·m] in the object's axes about its origin.
    #[pyo3(signature = (pose, twist, t=0.0, *, contact=0.0, episode=f64::INFINITY, inner=vec![]))]
    fn wrench(
        &self,
        pose: [f64; 3],
        twist: [f64; 3],
        t: f64,
        contact: f64,
        episode: f64,
        inner: Vec<f64>,
    ) -> PyResult<[f64; 3]> {
        let state = State::moving(pose, twist).with_inner(own(&self.starts, &inner)?);
        Ok(self
            .plant
            .generalised_force(&state, clock(t, 0.0, contact, episode))
            .wrench(to_body(twist, pose[2])))
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
    /// t, contact, episode, inner
    ///     As in `wrench`; `t` where the step begins.
    ///
    /// Returns
    /// -------
    /// push : list of float
    ///     Wrench [N, N, N·m] in the object's axes about its origin.
    /// damping : list of float
    ///     Lower triangle [xx, xy, yy, xθ, yθ, θθ] of D in the same axes.
    /// inner : list of float
    ///     The laws' own states after the step.
    #[pyo3(signature = (pose, twist, force, dt, t=0.0, *, contact=0.0, episode=f64::INFINITY, inner=vec![]))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
    fn step(
        &self,
        pose: [f64; 3],
        twist: [f64; 3],
        force: [f64; 3],
        dt: f64,
        t: f64,
        contact: f64,
        episode: f64,
        inner: Vec<f64>,
    ) -> PyResult<Stepped> {
        let state = State::moving(pose, twist).with_inner(own(&self.starts, &inner)?);
        let clock = clock(t + dt / 2.0, dt, contact, episode);
        let after = self.plant.step(&state, force, clock, dt);
        let inner = after.inner[..self.starts.len()].to_vec();
        let drag = self.plant.generalised_force(&after, clock).damping;
        let (before, after) = (to_body(twist, pose[2]), to_body(after.twist, pose[2]));
        let gained = self.momentum([0, 1, 2].map(|k| (after[k] - before[k]) / dt), before[2]);
        let braked = multiplied(drag, after);
        Ok(([0, 1, 2].map(|k| gained[k] + braked[k] - force[k]), drag, inner))
    }
}

impl PyLaws {
    /// Wrench about the origin, object axes, that gives the origin the acceleration `[x, y, spin]`.
    fn momentum(&self, [ax, ay, alpha]: [f64; 3], spin: f64) -> [f64; 3] {
        let Rigid { mass, inertia, com: [x, y] } = self.home;
        let fx = mass * (ax - alpha * y - spin * spin * x);
        let fy = mass * (ay + alpha * x - spin * spin * y);
        [fx, fy, inertia * alpha + x * fy - y * fx]
    }
}

/// Push, damping, and the laws' own states after a step.
type Stepped = ([f64; 3], [f64; 6], Vec<f64>);

/// Where the laws' own states start.
pub(crate) fn starts(model: &Model) -> Vec<f64> {
    model.inner().iter().map(|own| own.starts.first().copied().unwrap_or(0.0)).collect()
}

/// The laws' own states: those that are given, else where they start.
pub(crate) fn own(starts: &[f64], given: &[f64]) -> PyResult<[f64; MAX_INNER_STATES]> {
    if !given.is_empty() && given.len() != starts.len() {
        let (got, expected) = (given.len(), starts.len());
        return Err(refused(format!("inner has {got} values: the laws have {expected} states of their own")));
    }
    let given = if given.is_empty() { starts } else { given };
    Ok(std::array::from_fn(|k| given.get(k).copied().unwrap_or(0.0)))
}

/// `D v`.
fn multiplied([xx, xy, yy, tx, ty, tt]: [f64; 6], [vx, vy, spin]: [f64; 3]) -> [f64; 3] {
    [xx * vx + xy * vy + tx * spin, xy * vx + yy * vy + ty * spin, tx * vx + ty * vy + tt * spin]
}

/// A value for each slot: the caller's, else the model's.
pub(crate) fn values(model: &Model, given: &BTreeMap<String, f64>) -> PyResult<Vec<f64>> {
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

pub(crate) fn draws(model: &PyModel) -> PyResult<Option<Draws>> {
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
