//! Discriminating trajectories of mechanisms in Python.

use std::collections::BTreeMap;

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_diagnose::MIN_EFFECT_PROBABILITY;
use trundle_diagnose::design::{needed_repeats, success_probability};
use trundle_mechanism::{AxisLoad, JointDesigner, Plan, Problem, motion};

use crate::error::{refused, run};
use crate::mechanism::{dynamics_of, episode_of, model};
use crate::plain::plain;
use crate::record::joint_recording_of;
use crate::watch::{once, watched_request};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyJointDesigner>()?;
    module.add_function(wrap_pyfunction!(_joint_designer, module)?)
}

/// An effect's name with starting values of its parameters.
type GivenEffect = (String, BTreeMap<String, f64>);

/// Fit two explanations of a recording of joints; see `trundle.design`.
#[pyfunction]
#[pyo3(signature = (recording, dynamics, first, second, progress=None))]
fn _joint_designer(
    recording: &Bound<'_, PyAny>,
    dynamics: Option<&Bound<'_, PyDict>>,
    first: Vec<GivenEffect>,
    second: Vec<GivenEffect>,
    progress: Option<Py<PyAny>>,
) -> PyResult<PyJointDesigner> {
    let py = recording.py();
    let source = joint_recording_of(recording)?;
    let found = run(py, || motion(&source))?;
    let dynamics = dynamics.map(|dict| dynamics_of(dict, &found)).transpose()?;
    let [first, second] = [first, second].map(|effects| {
        effects.into_iter().map(|(name, values)| (name, values.into_iter().collect())).collect::<Vec<_>>()
    });
    let bodies = dynamics.as_ref().map_or(vec![], |dynamics| dynamics.bodies.clone());
    let designer = watched_request(py, progress, const { &once("fit") }, |watch| {
        let problem = Problem::new(&source, &found, dynamics.as_ref())?;
        JointDesigner::new(problem, &found, [&first, &second], watch)
    })?;
    Ok(PyJointDesigner { designer, bodies })
}

/// Two explanations of a recording of joints.
#[pyclass(name = "_JointDesigner", module = "trundle", frozen)]
pub(crate) struct PyJointDesigner {
    designer: JointDesigner,
    bodies: Vec<String>,
}

#[pymethods]
impl PyJointDesigner {
    /// Names of the effects of both models.
    #[getter]
    fn names(&self) -> [Vec<String>; 2] {
        self.designer.names()
    }

    /// For each effect that only one model has: which motion or rig identifies it best.
    #[getter]
    fn advice(&self) -> Vec<String> {
        self.designer.advice()
    }

    /// Log-likelihood ratio of the recording in favour of the first model, nats.
    #[getter]
    fn recorded(&self) -> f64 {
        self.designer.recorded()
    }

    /// Whether neither model explains the recording.
    #[getter]
    fn is_unexplained(&self) -> bool {
        self.designer.is_unexplained()
    }

    /// The fitted models.
    #[getter]
    fn models<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.designer.fitted().each_ref().map(model))
    }

    /// Range, largest speed, acceleration and effort of each joint in the training episodes.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.designer.limits())
    }

    /// Time between the samples of a plan, s.
    #[getter]
    fn dt(&self) -> f64 {
        self.designer.dt()
    }

    /// Standard deviation of an independent sample of each joint's effort.
    #[getter]
    fn noise(&self) -> Vec<f64> {
        self.designer.noise().to_vec()
    }

    /// Unit of the efforts of each joint.
    #[getter]
    fn effort_units(&self) -> Vec<&'static str> {
        self.designer.effort_units()
    }

    /// Mean log-likelihood ratio at which a model reaches a probability of 0.95, nats.
    #[getter]
    fn decisive_nats(&self) -> f64 {
        (MIN_EFFECT_PROBABILITY / (1.0 - MIN_EFFECT_PROBABILITY)).ln()
    }

    /// Probability that the true model reaches a probability of 0.95, and the repetitions for which that is likely.
    fn success(&self, separation: [f64; 2]) -> (f64, Option<u32>) {
        let recorded = self.designer.recorded();
        (success_probability(separation, recorded, 1), needed_repeats(separation, recorded))
    }

    /// Separation of the models by a planned motion, (T, n) each.
    #[pyo3(signature = (q, v, a, *, dynamics=None, load=None, covariates=vec![], other_encoder=false))]
    #[allow(clippy::too_many_arguments)]
    fn separation<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'_, f64>,
        v: PyReadonlyArray2<'_, f64>,
        a: PyReadonlyArray2<'_, f64>,
        dynamics: Option<&Bound<'_, PyDict>>,
        load: Option<BTreeMap<String, f64>>,
        covariates: Vec<Option<f64>>,
        other_encoder: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let [q, v, a] = [q, v, a].map(|array| columns(&array));
        let dynamics = dynamics.map(|dict| episode_of(dict, [q.len(), self.bodies.len(), 0])).transpose()?;
        let load = load.map_or(Ok(AxisLoad::default()), |values| axis_load(&values))?;
        let plan = Plan { q, v, a, dynamics, load, covariates, other_encoder };
        plain(py, &run(py, || self.designer.separation(&plan))?)
    }
}

fn columns(array: &PyReadonlyArray2<'_, f64>) -> Vec<Vec<f64>> {
    array.as_array().columns().into_iter().map(|column| column.to_vec()).collect()
}

fn axis_load(values: &BTreeMap<String, f64>) -> PyResult<AxisLoad> {
    let mut load = AxisLoad::default();
    for (key, value) in values {
        match key.as_str() {
            "gravity_factor" => load.gravity_factor = *value,
            "inertia_factor" => load.inertia_factor = *value,
            "gravity_torque" => load.gravity_torque = *value,
            "inertia" => load.inertia = *value,
            "effort" => load.effort = *value,
            _ => return Err(refused(format!("load: unknown key {key}"))),
        }
    }
    Ok(load)
}
