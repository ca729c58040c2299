//! A pushing task in Python, and snapshots of it.

use numpy::{PyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use trundle_sim::task::{Costs, ExternalStep, OBJECT_SETS, constants, household_names};
use trundle_sim::{Options, Outcome, PushTask, ResetOptions, SimError, episode};

use crate::actions::numbers;
use crate::decision_time::DecisionClock;
use crate::error::{refused, run_here, simulated};
use crate::view::{hidden_values, view};
use crate::{columns, toml_dict};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyPushing>()?;
    module.add_class::<PySnapshot>()?;
    Ok(())
}

/// State of an episode, including random numbers and clock, for `snapshot()` and `restore()`.
///
/// It can be pickled, and restored in any environment with the same options.
#[pyclass(name = "Snapshot", module = "trundle._native", frozen)]
pub(crate) struct PySnapshot {
    pub options: String,
    pub task: PushTask,
}

#[pymethods]
impl PySnapshot {
    #[new]
    fn new(py: Python<'_>, options: &str, state: &[u8]) -> PyResult<Self> {
        let task = run_here(py, || {
            let mut task = PushTask::new(Options::from_toml(options)?)?;
            task.load(state)?;
            Ok::<_, SimError>(task)
        })?;
        Ok(Self { options: options.to_owned(), task })
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(String, Bound<'py, PyBytes>)> {
        Ok((self.options.clone(), PyBytes::new(py, &self.task.save().map_err(refused)?)))
    }
}

/// A pushing task, the native part of `trundle.envs.Push`.
#[pyclass(name = "Pushing", module = "trundle._native")]
struct PyPushing {
    options: String,
    task: PushTask,
    clock: DecisionClock,
}

/// Row of the table of object sets.
type ObjectSetRow = (String, String, Vec<String>, (f64, f64), Vec<String>, (f64, f64));
type Observation<'py> = Bound<'py, PyArray1<f64>>;
type Stepped<'py> = (Observation<'py>, f64, bool, bool, Bound<'py, PyDict>);

#[pymethods]
impl PyPushing {
    /// Half the side of the arena, m.
    #[classattr]
    const ARENA: f64 = constants::ARENA_HALF_SIDE_M;
    /// Duration of a regrasp, s.
    #[classattr]
    const REGRASP: f64 = constants::REGRASP_S;
    /// Largest speed of the object's origin, m/s; an episode ends above it.
    #[classattr]
    const TOP_SPEED: f64 = constants::MAX_SPEED_M_PER_S;
    /// Largest spin, rad/s; an episode ends above it.
    #[classattr]
    const TOP_SPIN: f64 = constants::MAX_SPIN_RAD_PER_S;
    /// Names of the household objects.
    #[classattr]
    #[pyo3(name = "HOUSEHOLD")]
    fn household() -> Vec<&'static str> {
        household_names().collect()
    }

    /// Sets of objects: level, split, outlines, mass range (kg), wheel layouts, friction range (N s/m).
    #[classattr]
    #[pyo3(name = "OBJECT_SETS")]
    fn object_sets() -> Vec<ObjectSetRow> {
        let names = |values: &[&dyn std::fmt::Debug]| {
            values.iter().map(|v| format!("{v:?}").to_lowercase()).collect()
        };
        OBJECT_SETS
            .iter()
            .map(|set| {
                let outlines: Vec<&dyn std::fmt::Debug> = set.outlines.iter().map(|one| one as _).collect();
                let wheels: Vec<&dyn std::fmt::Debug> = set.wheels.iter().map(|one| one as _).collect();
                let (level, split) = (format!("{:?}", set.level), format!("{:?}", set.split));
                let (level, split) = (level.to_lowercase(), split.to_lowercase());
                (level, split, names(&outlines), set.mass, names(&wheels), set.friction)
            })
            .collect()
    }

    /// Default costs per second of a version: time, effort, touch.
    #[staticmethod]
    fn default_costs(version: u32) -> (f64, f64, f64) {
        let costs = Costs::of_version(version);
        (costs.time, costs.effort, costs.touch)
    }

    #[new]
    fn new(options: &str) -> PyResult<Self> {
        let parsed = Options::from_toml(options).map_err(refused)?;
        let clock = DecisionClock::new(&parsed);
        Ok(Self { options: options.to_owned(), task: PushTask::new(parsed).map_err(refused)?, clock })
    }

    /// Wrench or velocity of an action of one.
    #[getter]
    fn full(&self) -> Vec<f64> {
        self.task.options().action.full_scale().to_vec()
    }

    /// Whether the object can differ between episodes. Observations then include its size.
    #[getter]
    fn varied(&self) -> bool {
        self.task.options().has_varied_objects()
    }

    /// Largest magnitude of each entry of an observation.
    #[getter]
    fn bounds(&self) -> Vec<f64> {
        self.task.options().observation_bounds()
    }

    /// Number of steps after which an episode is truncated; 0 for no truncation.
    #[getter]
    fn horizon(&self) -> u32 {
        self.task.options().horizon
    }

    /// Time between two actions, s.
    #[getter]
    fn control(&self) -> f64 {
        self.task.options().control_period()
    }

    #[pyo3(signature = (seed, start = None, goal = None, grasp = None, same_object = false))]
    fn reset<'py>(
        &mut self,
        py: Python<'py>,
        seed: Option<u64>,
        start: Option<[f64; 3]>,
        goal: Option<[f64; 3]>,
        grasp: Option<[f64; 2]>,
        same_object: bool,
    ) -> PyResult<Observation<'py>> {
        let options = ResetOptions { start, goal, grasp, same_object };
        run_here(py, || self.task.reset(seed, &options))?;
        self.clock.start();
        Ok(self.observe(py))
    }

    /// The result of `gymnasium.Env.step`; None if no episode is running.
    fn step<'py>(&mut self, py: Python<'py>, action: &Bound<'py, PyAny>) -> PyResult<Option<Stepped<'py>>> {
        let thinking = self.clock.elapsed_s();
        let options = self.task.options();
        let (width, clips) = (options.action.width(), options.clips_actions());
        let action = numbers(action, width, clips)?;
        let action = &action[..width];
        let stepped = run_here(py, || Ok::<_, SimError>(self.task.step_after(action, thinking)))?;
        self.clock.start();
        self.stepped(py, stepped.map_err(simulated)?)
    }

    /// The result of `gymnasium.Env.step` along a motion from another simulator; None if no episode is running. A row has
    /// the ten numbers of `ExternalStep`.
    fn follow<'py>(
        &mut self,
        py: Python<'py>,
        motion: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Option<Stepped<'py>>> {
        let (steps, rest) = motion.as_slice()?.as_chunks::<10>();
        if motion.shape()[1] != 10 || !rest.is_empty() {
            return Err(refused("motion must have 10 columns"));
        }
        let steps: Vec<ExternalStep> = steps.iter().map(external_step).collect();
        let outcome = run_here(py, || self.task.follow(&steps))?;
        self.clock.start();
        self.stepped(py, outcome)
    }

    #[getter]
    fn ready(&self) -> bool {
        self.task.ready()
    }

    #[getter]
    fn seeded(&self) -> bool {
        self.task.seeded()
    }

    #[getter]
    fn objects(&self) -> u64 {
        self.task.object_count()
    }

    fn view<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        view(py, &self.task)
    }

    fn hidden<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(model) = self.task.model() else { return Ok(None) };
        let text = model.to_toml(None).map_err(refused)?;
        toml_dict::to_dict(py, &text.parse().map_err(refused)?).map(Some)
    }

    fn hidden_values<'py>(&self, py: Python<'py>) -> Observation<'py> {
        PyArray1::from_slice(py, &hidden_values(&self.task))
    }

    fn record(&mut self) {
        self.task.record();
    }

    /// Samples of the instruments since the last call, by column.
    fn take_rows<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        columns::to_dict(py, &episode(String::new(), &self.task.take_rows()))
    }

    fn metadata<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyDict>> {
        let metadata = self.task.metadata(name).map_err(refused)?;
        toml_dict::to_dict(py, &metadata.to_table().map_err(refused)?)
    }

    fn snapshot(&self) -> PySnapshot {
        PySnapshot { options: self.options.clone(), task: self.task.fork() }
    }

    fn restore(&mut self, snapshot: &PySnapshot) -> PyResult<()> {
        require_same_options(&self.options, &snapshot.options)?;
        if self.task.recording() {
            return Err(refused("a recorded episode cannot be replaced: restore without trundle.Record"));
        }
        self.task = snapshot.task.clone();
        Ok(())
    }

    fn __getnewargs__(&self) -> (String,) {
        (self.options.clone(),)
    }

    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.task.save().map_err(refused)?))
    }

    fn __setstate__(&mut self, py: Python<'_>, state: &[u8]) -> PyResult<()> {
        run_here(py, || self.task.load(state))
    }
}

impl PyPushing {
    fn stepped<'py>(&mut self, py: Python<'py>, outcome: Option<Outcome>) -> PyResult<Option<Stepped<'py>>> {
        let Some(outcome) = outcome else { return Ok(None) };
        let Outcome { reward, terminated, truncated, .. } = outcome;
        Ok(Some((self.observe(py), reward, terminated, truncated, info(py, &outcome)?)))
    }

    fn observe<'py>(&mut self, py: Python<'py>) -> Observation<'py> {
        // A buffer of the maximum length avoids an allocation in addition to NumPy's own.
        let mut row = [0.0; MAX_OBSERVATION_LEN];
        let row = &mut row[..self.task.options().observation_len().min(MAX_OBSERVATION_LEN)];
        self.task.observe(row);
        PyArray1::from_slice(py, row)
    }
}

/// Pose, twist, wrench and impulse of a row.
fn external_step(&[x, y, theta, vx, vy, spin, fx, fy, torque, impulse]: &[f64; 10]) -> ExternalStep {
    ExternalStep { pose: [x, y, theta], twist: [vx, vy, spin], wrench: [fx, fy, torque], impulse }
}

/// Largest number of entries of an observation.
const MAX_OBSERVATION_LEN: usize = 64;

/// Refuse a snapshot of an environment with other options.
pub(crate) fn require_same_options(own: &str, other: &str) -> PyResult<()> {
    if own == other {
        return Ok(());
    }
    Err(refused(
        "the snapshot belongs to an environment with other options: create the environment with the same options",
    ))
}

fn info<'py>(py: Python<'py>, outcome: &Outcome) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item(intern!(py, "is_success"), outcome.success)?;
    dict.set_item(intern!(py, "distance"), outcome.distance)?;
    dict.set_item(intern!(py, "heading_error"), outcome.heading_error)?;
    dict.set_item(intern!(py, "lost"), outcome.lost)?;
    dict.set_item(intern!(py, "touched"), outcome.touched)?;
    dict.set_item(intern!(py, "progress"), outcome.progress)?;
    dict.set_item(intern!(py, "success_without_touching"), outcome.success_without_touching)?;
    dict.set_item(intern!(py, "contact_time"), outcome.contact_time)?;
    dict.set_item(intern!(py, "contact_impulse"), outcome.contact_impulse)?;
    dict.set_item(intern!(py, "action_clipped"), outcome.action_clipped)?;
    dict.set_item(intern!(py, "duration"), outcome.duration)?;
    Ok(dict)
}
