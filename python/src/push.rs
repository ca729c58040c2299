//! The pushing tasks in Python: one at a time, and in batches.

use numpy::{PyArray1, PyArray2, PyReadwriteArray2};
use pyo3::exceptions::PyIndexError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use trundle_sim::task::{Autoreset, Costs, OBJECT_SETS, Rows, constants, household_names};
use trundle_sim::{Batch, Options, Outcome, PushTask, ResetOptions, SimError, episode};

use crate::actions::{many_numbers, numbers};
use crate::decision_time::DecisionClock;
use crate::error::{refused, run_here, simulated};
use crate::view::{hidden_values, view};
use crate::{columns, toml_dict};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyPushing>()?;
    module.add_class::<PySnapshot>()?;
    module.add_class::<PyBatch>()?;
    Ok(())
}

/// State of an episode, including random numbers and clock, for `snapshot()` and `restore()`.
///
/// It can be pickled, and restored in any environment with the same options.
#[pyclass(name = "Snapshot", module = "trundle._native", frozen)]
struct PySnapshot {
    options: String,
    task: PushTask,
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
        let Some(outcome) = stepped.map_err(simulated)? else { return Ok(None) };
        let Outcome { reward, terminated, truncated, .. } = outcome;
        Ok(Some((self.observe(py), reward, terminated, truncated, info(py, &outcome)?)))
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
        same(&self.options, &snapshot.options)?;
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
    fn observe<'py>(&mut self, py: Python<'py>) -> Observation<'py> {
        // A buffer of the maximum length avoids an allocation in addition to NumPy's own.
        let mut row = [0.0; MAX_OBSERVATION_LEN];
        let row = &mut row[..self.task.options().observation_len().min(MAX_OBSERVATION_LEN)];
        self.task.observe(row);
        PyArray1::from_slice(py, row)
    }
}

/// Largest number of entries of an observation.
const MAX_OBSERVATION_LEN: usize = 64;

/// Tasks with the same options.
#[pyclass(name = "Batch", module = "trundle._native")]
struct PyBatch {
    options: String,
    autoreset: String,
    batch: Batch,
    outcomes: Vec<Outcome>,
    clock: DecisionClock,
    clips: bool,
}

/// Columns of the table that `Batch.step` fills.
const COLUMNS: [&str; 14] = [
    "reward",
    "terminated",
    "truncated",
    "is_success",
    "lost",
    "touched",
    "distance",
    "heading_error",
    "progress",
    "success_without_touching",
    "contact_time",
    "contact_impulse",
    "action_clipped",
    "duration",
];

#[pymethods]
impl PyBatch {
    #[classattr]
    const COLUMNS: [&str; 14] = COLUMNS;

    #[new]
    fn new(py: Python<'_>, options: &str, count: usize, autoreset: &str) -> PyResult<Self> {
        let mode = match autoreset {
            "NextStep" => Autoreset::NextStep,
            "SameStep" => Autoreset::SameStep,
            "Disabled" => Autoreset::Disabled,
            _ => {
                return Err(refused(format!(
                    "autoreset_mode = {autoreset}: choose NextStep, SameStep or Disabled"
                )));
            }
        };
        let parsed = Options::from_toml(options).map_err(refused)?;
        let (clock, clips) = (DecisionClock::new(&parsed), parsed.clips_actions());
        let batch = run_here(py, || Batch::new(parsed, count, mode))?;
        let (options, autoreset) = (options.to_owned(), autoreset.to_owned());
        Ok(Self { options, autoreset, batch, outcomes: vec![Outcome::default(); count], clock, clips })
    }

    /// Start an episode for each entry of `seeds`: a seed, or None for the next seed of the sequence.
    #[pyo3(signature = (seeds, observations, start = None, goal = None, grasp = None, same_object = false))]
    #[expect(clippy::too_many_arguments, reason = "as Pushing.reset")]
    fn reset(
        &mut self,
        py: Python<'_>,
        seeds: Vec<Option<(Option<u64>,)>>,
        mut observations: PyReadwriteArray2<'_, f64>,
        start: Option<[f64; 3]>,
        goal: Option<[f64; 3]>,
        grasp: Option<[f64; 2]>,
        same_object: bool,
    ) -> PyResult<()> {
        let options = ResetOptions { start, goal, grasp, same_object };
        let options: Vec<_> =
            seeds.into_iter().map(|seed| seed.map(|(seed,)| (seed, options.clone()))).collect();
        let rows = slice(&mut observations)?;
        run_here(py, || self.batch.reset(&options, rows))?;
        self.clock.start();
        Ok(())
    }

    #[getter]
    fn ready(&self) -> bool {
        self.batch.ready()
    }

    /// Step all tasks. Writes observations, final observations and outcomes into the arrays.
    fn step(
        &mut self,
        py: Python<'_>,
        actions: &Bound<'_, PyAny>,
        mut observations: PyReadwriteArray2<'_, f64>,
        mut finals: PyReadwriteArray2<'_, f64>,
        mut table: PyReadwriteArray2<'_, f64>,
    ) -> PyResult<()> {
        let thinking = self.clock.elapsed_s();
        let actions = many_numbers(actions, self.outcomes.len(), self.batch.width(), self.clips)?;
        let (observations, finals) = (slice(&mut observations)?, slice(&mut finals)?);
        let (batch, outcomes) = (&mut self.batch, &mut self.outcomes);
        let rows = Rows { observations, finals, outcomes };
        run_here(py, || Ok::<_, SimError>(batch.step_after(&actions, thinking, rows)))?.map_err(simulated)?;
        for (row, outcome) in slice(&mut table)?.chunks_mut(COLUMNS.len()).zip(&self.outcomes) {
            row.copy_from_slice(&cells(outcome));
        }
        self.clock.start();
        Ok(())
    }

    fn view<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.batch.envs().get(index).map_or(Ok(None), |task| view(py, task))
    }

    fn hidden_values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows: Vec<Vec<f64>> = self.batch.envs().iter().map(|task| hidden_values(task).to_vec()).collect();
        PyArray2::from_vec2(py, &rows).map_err(refused)
    }

    /// Whether each task has been given a seed.
    #[getter]
    fn seeded(&self) -> Vec<bool> {
        self.batch.envs().iter().map(PushTask::seeded).collect()
    }

    /// Whether the episode of a task has ended.
    fn ended(&self, index: usize) -> PyResult<bool> {
        self.batch.envs().get(index).map(|task| !task.ready()).ok_or_else(|| missing(index))
    }

    fn snapshot(&self, index: usize) -> PyResult<PySnapshot> {
        let task = self.batch.envs().get(index).ok_or_else(|| missing(index))?;
        Ok(PySnapshot { options: self.options.clone(), task: task.fork() })
    }

    fn restore(&mut self, index: usize, snapshot: &PySnapshot) -> PyResult<()> {
        same(&self.options, &snapshot.options)?;
        *self.batch.env(index).ok_or_else(|| missing(index))? = snapshot.task.clone();
        Ok(())
    }

    fn __getnewargs__(&self) -> (String, usize, String) {
        (self.options.clone(), self.outcomes.len(), self.autoreset.clone())
    }

    fn __getstate__(&self) -> PyResult<Vec<Vec<u8>>> {
        self.batch.envs().iter().map(|task| task.save().map_err(refused)).collect()
    }

    fn __setstate__(&mut self, py: Python<'_>, states: Vec<Vec<u8>>) -> PyResult<()> {
        run_here(py, || self.batch.load(&states))
    }
}

fn missing(index: usize) -> PyErr {
    PyIndexError::new_err(format!("there is no environment {index}"))
}

fn same(own: &str, other: &str) -> PyResult<()> {
    if own == other {
        return Ok(());
    }
    Err(refused(
        "the snapshot belongs to an environment with other options: create the environment with the same options",
    ))
}

fn slice<'a>(array: &'a mut PyReadwriteArray2<'_, f64>) -> PyResult<&'a mut [f64]> {
    array.as_slice_mut().map_err(refused)
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

fn cells(outcome: &Outcome) -> [f64; 14] {
    let truth = |value: bool| f64::from(u8::from(value));
    [
        outcome.reward,
        truth(outcome.terminated),
        truth(outcome.truncated),
        truth(outcome.success),
        truth(outcome.lost),
        truth(outcome.touched),
        outcome.distance,
        outcome.heading_error,
        outcome.progress,
        truth(outcome.success_without_touching),
        outcome.contact_time,
        outcome.contact_impulse,
        truth(outcome.action_clipped),
        outcome.duration,
    ]
}
