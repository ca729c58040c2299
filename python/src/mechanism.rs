//! Diagnosis of recordings of joints in Python.

use std::collections::BTreeMap;

use numpy::ndarray::{ArrayViewD, Axis};
use numpy::{PyArray1, PyArray2, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_diagnose::ErrorMetric;
use trundle_infer::Stage;
use trundle_mechanism::{
    Dynamics, EpisodeDynamics, FittedMechanism, JointOutcome, JointSample, Kind, Motion, SimulatorParameter,
    SimulatorSetup, Spec, catalogue, diagnose_joints, motion,
};

use crate::black_box::{PyParameter, unit};
use crate::error::{refused, run};
use crate::plain::plain;
use crate::record::joint_recording_of;
use crate::watch::watched_request;

/// Stages of a diagnosis of joints.
const STAGES: [Stage; 5] = [
    Stage { name: "the mechanism under test", end: 0.05, rounds: 1.0 },
    Stage { name: "missing effects", end: 0.75, rounds: 1.0 },
    Stage { name: "refinements", end: 0.85, rounds: 1.0 },
    Stage { name: "lack of fit", end: 0.9, rounds: 1.0 },
    Stage { name: "figures", end: 1.0, rounds: 1.0 },
];

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyJointOutcome>()?;
    module.add_function(wrap_pyfunction!(_joint_effects, module)?)?;
    module.add_function(wrap_pyfunction!(_joint_motion, module)?)?;
    module.add_function(wrap_pyfunction!(_diagnose_joints, module)?)
}

/// The catalogue of laws of joints: name, summary, source, parameters with their units for a hinge, and experiment.
#[pyfunction]
fn _joint_effects(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let entry = |spec: &Spec| {
        let params: Vec<_> = spec
            .params
            .iter()
            .map(|p| BTreeMap::from([("name", p.name), ("unit", p.unit.text(true, Default::default()))]))
            .collect();
        serde_json::json!({
            "effect": spec.effect, "summary": spec.summary, "source": spec.source,
            "parameters": params, "experiment": spec.experiment,
        })
    };
    plain(py, &catalogue().into_iter().map(entry).collect::<Vec<_>>())
}

/// The smoothed motion of a recording of joints: joints, bandwidth, and by episode t, (T,), q, v and a, (T, n), and
/// causal_q and causal_v, which the samples up to each one tell.
#[pyfunction]
fn _joint_motion<'py>(recording: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
    let py = recording.py();
    let source = joint_recording_of(recording)?;
    let found = run(py, || motion(&source))?;
    let dict = PyDict::new(py);
    dict.set_item("joints", &found.joints)?;
    dict.set_item("bandwidth", found.bandwidth)?;
    let episodes = PyDict::new(py);
    for episode in &found.episodes {
        let own = PyDict::new(py);
        own.set_item("t", PyArray1::from_vec(py, episode.times()))?;
        for (key, series) in [("q", &episode.q), ("v", &episode.v), ("a", &episode.a)] {
            let rows: Vec<Vec<f64>> =
                (0..episode.times().len()).map(|k| series.iter().map(|joint| joint[k]).collect()).collect();
            own.set_item(key, PyArray2::from_vec2(py, &rows).map_err(refused)?)?;
        }
        for (key, part) in [("causal_q", 0), ("causal_v", 1)] {
            let at = |k: usize| episode.causal.iter().map(|joint| joint[k][part]).collect();
            let rows: Vec<Vec<f64>> = (0..episode.times().len()).map(at).collect();
            own.set_item(key, PyArray2::from_vec2(py, &rows).map_err(refused)?)?;
        }
        episodes.set_item(&episode.name, own)?;
    }
    dict.set_item("episodes", episodes)?;
    Ok(dict)
}

/// Diagnose a recording of joints; see `trundle.diagnose`. `dynamics` is what MuJoCo or the user's simulator computed along
/// the motion.
#[pyfunction]
#[pyo3(signature = (recording, dynamics=None, *, without=vec![], progress=None))]
fn _diagnose_joints(
    recording: &Bound<'_, PyAny>,
    dynamics: Option<&Bound<'_, PyDict>>,
    without: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<PyJointOutcome> {
    let py = recording.py();
    let source = joint_recording_of(recording)?;
    let found = run(py, || motion(&source))?;
    let dynamics = dynamics.map(|dict| dynamics_of(dict, &found)).transpose()?;
    let outcome = watched_request(py, progress, &STAGES, |watch| {
        diagnose_joints(&source, &found, dynamics.as_ref(), &without, watch)
    })?;
    Ok(PyJointOutcome(outcome))
}

/// The result of a diagnosis of joints.
#[pyclass(name = "_JointOutcome", module = "trundle", frozen)]
pub(crate) struct PyJointOutcome(JointOutcome);

#[pymethods]
impl PyJointOutcome {
    /// The content of `diagnosis.json`.
    #[getter]
    fn answer<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.answer)
    }

    /// The fitted mechanisms before and after: nominal values, and effects with their place and values.
    #[getter]
    fn models<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.models.each_ref().map(model))
    }

    /// Open-loop simulations of an axis by held-out episode: t, observed, before, after.
    #[getter]
    fn predictions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (episode, [before, after]) in &self.0.predictions {
            let Some(shape) = before.as_ref().or(after.as_ref()) else { continue };
            let own = PyDict::new(py);
            own.set_item("t", PyArray1::from_slice(py, &shape.t))?;
            own.set_item("observed", PyArray1::from_slice(py, &shape.observed))?;
            for (key, found) in [("before", before), ("after", after)] {
                let values = found.as_ref().map(|path| PyArray1::from_slice(py, &path.simulated));
                own.set_item(key, values)?;
            }
            dict.set_item(episode, own)?;
        }
        Ok(dict)
    }

    /// Warnings about held-out episodes. `metrics` are their errors: name, unit, before and after.
    fn held_out_warnings(&self, metrics: Vec<(String, String, Option<f64>, Option<f64>)>) -> Vec<String> {
        let metric = |(name, unit, before, after)| ErrorMetric { name, unit, before, after };
        self.0.held_out_warnings(&metrics.into_iter().map(metric).collect::<Vec<_>>())
    }

    /// Effort, level of dry friction and added inertia of the laws of every joint at a state of the mechanism "after",
    /// or "before".
    #[pyo3(signature = (which, q, v, drive, external, load))]
    fn terms(
        &self,
        which: &str,
        q: Vec<f64>,
        v: Vec<f64>,
        drive: Vec<f64>,
        external: Vec<f64>,
        load: Vec<Option<f64>>,
    ) -> PyResult<[Vec<f64>; 3]> {
        let mechanism = &self.0.models[usize::from(which == "after")];
        let count = mechanism.joints.len();
        if [v.len(), drive.len(), external.len(), load.len(), q.len()].iter().any(|len| *len != count) {
            return Err(refused(format!("terms: give {count} values, one for each joint")));
        }
        let of = |j: usize| {
            let at = JointSample {
                q: q[j],
                v: v[j],
                a: 0.0,
                drive: (!drive[j].is_nan()).then_some(drive[j]),
                external: external[j],
                load: load[j],
            };
            mechanism.terms(j, &at)
        };
        let all: Vec<[f64; 3]> = (0..count).map(of).collect();
        Ok([0, 1, 2].map(|k| all.iter().map(|terms| terms[k]).collect()))
    }
}

/// A fitted mechanism as plain data.
pub(crate) fn model(mechanism: &FittedMechanism) -> serde_json::Value {
    let effect = |effect: &trundle_mechanism::Effect| {
        let params = effect.kind.params();
        let values: BTreeMap<&str, f64> = params
            .iter()
            .zip(&effect.values)
            .filter(|(_, value)| !value.is_nan())
            .map(|(param, value)| (param.name, *value))
            .collect();
        let mut entry = serde_json::json!({"kind": effect.kind.effect(), "values": values});
        match effect.kind {
            Kind::Joint(_, j) | Kind::EncoderOffset(j) => entry["joint"] = mechanism.joints[j].clone().into(),
            Kind::Payload(body) => entry["body"] = mechanism.bodies[body].clone().into(),
            Kind::BaseTilt => {}
        }
        entry
    };
    serde_json::json!({
        "nominal": mechanism.nominal,
        "effects": mechanism.effects.iter().map(effect).collect::<Vec<_>>(),
    })
}

fn item<'py>(dict: &Bound<'py, PyDict>, key: &str) -> PyResult<Bound<'py, PyAny>> {
    dict.get_item(key)?.ok_or_else(|| refused(format!("dynamics: `{key}` is missing")))
}

pub(crate) fn dynamics_of(dict: &Bound<'_, PyDict>, motion: &Motion) -> PyResult<Dynamics> {
    let mut dynamics = Dynamics {
        bodies: item(dict, "bodies")?.extract()?,
        masses: item(dict, "masses")?.extract()?,
        armature: item(dict, "armature")?.extract()?,
        damping: item(dict, "damping")?.extract()?,
        frictionloss: item(dict, "frictionloss")?.extract()?,
        gravity: item(dict, "gravity")?.extract()?,
        is_hinge: item(dict, "is_hinge")?.extract()?,
        simulator: dict
            .get_item("simulator")?
            .map(|dict| simulator_of(dict.cast::<PyDict>()?))
            .transpose()?,
        episodes: vec![],
    };
    let parameters = dynamics.simulator.as_ref().map_or(0, |simulator| simulator.parameters.len());
    let episodes = item(dict, "episodes")?;
    for episode in &motion.episodes {
        let own = episodes.get_item(&episode.name)?;
        let sizes = [motion.joints.len(), dynamics.bodies.len(), parameters];
        dynamics.episodes.push(episode_of(own.cast::<PyDict>()?, sizes)?);
    }
    Ok(dynamics)
}

/// Prior standard deviation of a parameter without `sd` and bounds, as a multiple of its starting value.
const WIDE_SD: f64 = 10.0;

fn simulator_of(dict: &Bound<'_, PyDict>) -> PyResult<SimulatorSetup> {
    let parameters: Vec<PyParameter> = item(dict, "parameters")?.extract()?;
    let references: Vec<f64> = item(dict, "references")?.extract()?;
    if references.len() != parameters.len() {
        return Err(refused("dynamics: `references` needs one value for each parameter".to_owned()));
    }
    let parameter = |(given, reference): (PyParameter, f64)| {
        let range = given.upper - given.lower;
        let wide = if range.is_finite() { range } else { WIDE_SD * given.start.abs() };
        SimulatorParameter {
            unit: unit(&given.unit),
            name: given.name,
            start: given.start,
            reference,
            bounds: [given.lower, given.upper],
            sd: given.sd.unwrap_or(wide),
        }
    };
    let parameters = parameters.into_iter().zip(references).map(parameter).collect();
    Ok(SimulatorSetup { parameters, is_given: item(dict, "is_given")?.extract()? })
}

/// The dynamics of an episode for numbers of joints, bodies and parameters.
pub(crate) fn episode_of(dict: &Bound<'_, PyDict>, [n, b, p]: [usize; 3]) -> PyResult<EpisodeDynamics> {
    let array = |key: &str| -> PyResult<PyReadonlyArrayDyn<'_, f64>> {
        item(dict, key)?.extract().map_err(|_| refused(format!("dynamics: `{key}` is no array of float64")))
    };
    let shaped = |key: &str, shape: &[usize]| -> PyResult<PyReadonlyArrayDyn<'_, f64>> {
        let found = array(key)?;
        let given = found.as_array().shape().to_vec();
        if given.len() != shape.len() + 1 || given[1..] != *shape {
            return Err(refused(format!("dynamics: `{key}` has shape {given:?}, expected (T, {shape:?})")));
        }
        Ok(found)
    };
    let effort = shaped("effort", &[n])?;
    let mass_matrix = shaped("mass_matrix", &[n, n])?;
    let mass = shaped("mass", &[n, b])?;
    let gravity = shaped("gravity", &[n, 3])?;
    let payload = shaped("payload", &[n, b, 10])?;
    let (matrix_mass, own_payload) =
        (shaped("matrix_mass", &[n, b, n])?, shaped("own_payload", &[n, b, 10])?);
    let mass_gravity = shaped("mass_gravity", &[n, b, 3])?;
    let mass_position = shaped("mass_position", &[n, b, n])?;
    let (position, curvature) = (shaped("position", &[n, n])?, shaped("position_curvature", &[n, n])?);
    let velocity = shaped("velocity", &[n, n])?;
    let by_parameter = if p > 0 { Some(shaped("parameter", &[n, p])?) } else { None };
    let (mass, gravity) = (mass.as_array(), gravity.as_array());
    let payload = payload.as_array();
    let by_body = |array: ArrayViewD<'_, f64>| -> Vec<Vec<Vec<f64>>> {
        (0..n).map(|j| (0..b).map(|k| column(array.view(), &[j, k])).collect()).collect()
    };
    let by_two_joints = |array: ArrayViewD<'_, f64>| -> Vec<Vec<Vec<f64>>> {
        (0..n).map(|j| (0..n).map(|k| column(array.view(), &[j, k])).collect()).collect()
    };
    let by_body_and_joint = |array: ArrayViewD<'_, f64>| -> Vec<Vec<Vec<Vec<f64>>>> {
        let of = |j: usize, body: usize| (0..n).map(|k| column(array.view(), &[j, body, k])).collect();
        (0..n).map(|j| (0..b).map(|body| of(j, body)).collect()).collect()
    };
    Ok(EpisodeDynamics {
        effort: (0..n).map(|j| column(effort.as_array(), &[j])).collect(),
        mass_matrix: by_two_joints(mass_matrix.as_array()),
        by_mass: by_body(mass),
        matrix_by_mass: by_body_and_joint(matrix_mass.as_array()),
        by_gravity: (0..n).map(|j| [0, 1, 2].map(|k| column(gravity.view(), &[j, k]))).collect(),
        by_mass_and_gravity: by_component(mass_gravity.as_array(), [n, b]),
        by_payload: by_component(payload, [n, b]),
        inertia_by_payload: by_component(own_payload.as_array(), [n, b]),
        by_offset: (0..n)
            .map(|j| {
                let of = |k: usize| [&position, &curvature].map(|array| column(array.as_array(), &[j, k]));
                (0..n).map(of).collect()
            })
            .collect(),
        by_velocity: by_two_joints(velocity.as_array()),
        by_mass_and_offset: by_body_and_joint(mass_position.as_array()),
        by_parameter: by_parameter.map_or(vec![], |parameter| {
            (0..n).map(|j| (0..p).map(|k| column(parameter.as_array(), &[j, k])).collect()).collect()
        }),
    })
}

/// The values over time by joint, by body, and by component.
fn by_component<const K: usize>(array: ArrayViewD<'_, f64>, [n, b]: [usize; 2]) -> Vec<Vec<[Vec<f64>; K]>> {
    let of = |j: usize, body: usize| std::array::from_fn(|k| column(array.view(), &[j, body, k]));
    (0..n).map(|j| (0..b).map(|body| of(j, body)).collect()).collect()
}

/// The values over time at fixed later indices.
fn column(array: ArrayViewD<'_, f64>, at: &[usize]) -> Vec<f64> {
    let mut view = array;
    for index in at {
        view = view.index_axis_move(Axis(1), *index);
    }
    view.iter().copied().collect()
}
