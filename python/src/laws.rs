//! The laws of a model for other simulators.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use trundle_model::{Clock, EmbeddedLaws, EmbeddedStep, MAX_INNER_STATES, State};

use crate::error::refused;
use crate::model::PyModel;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyLaws>()
}

/// The laws of a model that act on the object, one step at a time, for use in another simulator.
///
/// Laws that act on the instruments are left out.
///
/// Parameters
/// ----------
/// model : Model
///     Model with a value for every parameter.
/// parameters : mapping of str to float, optional
///     Values that replace those of the model, by the names of `Model.parameters`.
///
/// Raises
/// ------
/// TrundleError
///     If a name is unknown, a value is out of bounds, or a parameter has no value.
#[pyclass(frozen, name = "Laws", module = "trundle")]
struct PyLaws(EmbeddedLaws);

/// Clock at time `t` of the recording, s. `episode`: index of the episode, infinite after all episodes.
fn clock(t: f64, dt: f64, contact: f64, episode: f64) -> Clock {
    Clock { t, dt, episode, ..Clock::since_contact(t - contact) }
}

/// Push, damping, and the laws' inner states after a step.
type Stepped = ([f64; 3], [f64; 6], Vec<f64>);

#[pymethods]
impl PyLaws {
    #[new]
    #[pyo3(signature = (model, parameters=None))]
    fn new(model: &PyModel, parameters: Option<BTreeMap<String, f64>>) -> PyResult<Self> {
        let values = model.model.values_with(&parameters.unwrap_or_default()).map_err(refused)?;
        let model = model.model.with_values(&values).map_err(refused)?;
        Ok(Self(EmbeddedLaws::new(&model).map_err(refused)?))
    }

    fn __repr__(&self) -> String {
        let body = self.0.body();
        let [x, y] = body.com;
        format!("<trundle.export.Laws: {:.4} kg, mass centre at ({x:.3}, {y:.3}) m>", body.mass)
    }

    /// Mass of the rigid body, kg.
    #[getter]
    fn mass(&self) -> f64 {
        self.0.body().mass
    }

    /// Mass centre in the object frame, m.
    #[getter]
    fn com(&self) -> [f64; 2] {
        self.0.body().com
    }

    /// Inertia about the mass centre, kg·m².
    #[getter]
    fn inertia(&self) -> f64 {
        self.0.body().inertia
    }

    /// Initial values of the laws' inner states, such as the angle of a caster; empty without such laws.
    #[getter]
    fn starts(&self) -> Vec<f64> {
        self.0.initial_inner().to_vec()
    }

    /// Wrench of all laws on the object at a state.
    ///
    /// Parameters
    /// ----------
    /// pose, twist : array_like, shape (3,)
    ///     Pose and twist of the object frame, world axes, [m, m, rad] and [m/s, m/s, rad/s].
    /// t : float
    ///     Time in the recording, s, which determines events.
    /// contact : float
    ///     Time of first contact, s. Some laws act from then on.
    /// episode : float
    ///     Index of the episode in the recording, from 0, which determines events. By default all events have happened.
    /// inner : sequence of float
    ///     Inner states of the laws; their initial values by default.
    ///
    /// Returns
    /// -------
    /// list of float
    ///     Wrench [N, N, N·m], object axes about the object origin.
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
        let state = State::moving(pose, twist).with_inner(self.inner(inner)?);
        Ok(self.0.wrench(&state, clock(t, 0.0, contact, episode)))
    }

    /// Effect of the laws over a step of a simulator that integrates damping implicitly.
    ///
    /// With the damping matrix D and the mass matrix M, a step `M (v' − v)/dt = push − D v' + force` with the same
    /// `force` ends in the velocity of trundle's own step. With another force, the damping answers as the laws would,
    /// to first order.
    ///
    /// Parameters
    /// ----------
    /// pose, twist : array_like, shape (3,)
    ///     Pose and twist of the object frame, world axes, [m, m, rad] and [m/s, m/s, rad/s].
    /// force : array_like, shape (3,)
    ///     Other forces: wrench [N, N, N·m], object axes about the object origin.
    /// dt : float
    ///     Duration of the step, s.
    /// t, contact, episode, inner
    ///     As in `wrench`; `t` at the beginning of the step.
    ///
    /// Returns
    /// -------
    /// push : list of float
    ///     Wrench [N, N, N·m], object axes about the object origin.
    /// damping : list of float
    ///     Lower triangle [xx, xy, yy, xθ, yθ, θθ] of D in the same axes.
    /// inner : list of float
    ///     Inner states of the laws after the step.
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
        let state = State::moving(pose, twist).with_inner(self.inner(inner)?);
        let clock = clock(t + dt / 2.0, dt, contact, episode);
        let EmbeddedStep { push, damping, after } = self.0.step(&state, force, clock, dt);
        Ok((push, damping, after.inner[..self.0.initial_inner().len()].to_vec()))
    }
}

impl PyLaws {
    fn inner(&self, given: Vec<f64>) -> PyResult<[f64; MAX_INNER_STATES]> {
        self.0.inner_with(&given).map_err(refused)
    }
}
