//! The simulated world in Python: scenarios, and the locked wheel's task.

use std::path::PathBuf;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_sim::task::{Hidden, Saved, rules};
use trundle_sim::{LockedWheel, Outcome, Reset, Scenario, SimError, episode};

use crate::error::{refused, run};
use crate::record::PyRecording;
use crate::{columns, toml_dict};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyLockedWheel>()?;
    module.add_function(wrap_pyfunction!(simulate, module)?)
}

/// Simulate a scenario and record it.
///
/// Parameters
/// ----------
/// scenario : str or os.PathLike
///     A scenario file, as those in ``configs/experiments``.
/// seed : int
///     Seed of everything random.
///
/// Returns
/// -------
/// Recording
///     The same for the same scenario and seed.
///
/// Raises
/// ------
/// TrundleError
///     If the scenario is not sound; the message names file, key, value and remedy.
#[pyfunction]
#[pyo3(signature = (scenario, seed = 0))]
fn simulate(py: Python<'_>, scenario: PathBuf, seed: u64) -> PyResult<PyRecording> {
    run(py, || {
        let (scenario, model) = Scenario::read(&scenario)?;
        trundle_sim::simulate(&scenario, &model, seed)
    })
    .map(PyRecording::wrap)
}

/// The native half of `trundle.envs.LockedWheel`.
#[pyclass(name = "LockedWheel", module = "trundle._native")]
struct PyLockedWheel {
    noise: f64,
    task: LockedWheel,
}

type Observation<'py> = Bound<'py, PyArray1<f64>>;
type HiddenState = ([f64; 5], [f64; 3]);
type EpisodeState = ([f64; 7], [f64; 3], [f64; 2], [f64; 3], [f64; 3], u32, bool, u64, u128);
type State = (u64, Option<HiddenState>, Option<EpisodeState>);

#[pymethods]
impl PyLockedWheel {
    /// Wrench of a full action, N, N, N m.
    #[classattr]
    const FULL: [f64; 3] = rules::FULL;
    /// Largest magnitude of each entry of an observation.
    #[classattr]
    const BOUNDS: [f64; rules::OBSERVATION] = rules::BOUNDS;
    /// Half the side of the arena, m.
    #[classattr]
    const ARENA: f64 = rules::ARENA;
    /// Time between two actions, s.
    #[classattr]
    const CONTROL: f64 = rules::CONTROL;
    /// Half the sides of the table, m.
    #[classattr]
    const HALF: [f64; 2] = rules::HALF;
    /// The table's wheels, object frame, m.
    #[classattr]
    const WHEELS: [[f64; 2]; 4] = rules::WHEELS;

    #[new]
    fn new(noise: f64) -> PyResult<Self> {
        Ok(Self { noise, task: LockedWheel::new(noise).map_err(refused)? })
    }

    #[pyo3(signature = (seed, start = None, goal = None, grasp = None, same_object = false))]
    fn reset<'py>(
        &mut self,
        py: Python<'py>,
        seed: u64,
        start: Option<[f64; 3]>,
        goal: Option<[f64; 3]>,
        grasp: Option<[f64; 2]>,
        same_object: bool,
    ) -> PyResult<Observation<'py>> {
        let told = Reset { start, goal, grasp, same_object };
        run(py, || self.task.reset(seed, &told)).map(|o| PyArray1::from_slice(py, &o))
    }

    /// Observation, reward, terminated, success, distance, heading error; None without an episode.
    #[expect(clippy::type_complexity, reason = "a tuple is what Python unpacks at no cost")]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        wrench: [f64; 3],
    ) -> PyResult<Option<(Observation<'py>, f64, bool, bool, f64, f64)>> {
        let stepped = run(py, || Ok::<_, SimError>(self.task.step(wrench)))?;
        Ok(stepped.map(|(observation, outcome)| {
            let Outcome { reward, terminated, success, distance, heading_error } = outcome;
            (PyArray1::from_slice(py, &observation), reward, terminated, success, distance, heading_error)
        }))
    }

    #[getter]
    fn ready(&self) -> bool {
        self.task.ready()
    }

    #[getter]
    fn objects(&self) -> u64 {
        self.task.objects()
    }

    /// True poses of object, goal and gripper in the world, and the wrench at the grasp.
    fn view(&self) -> Option<[[f64; 3]; 4]> {
        self.task.view()
    }

    fn record(&mut self) {
        self.task.record();
    }

    /// What the instruments saw since the last time, by column.
    fn take_rows<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        columns::to_dict(py, &episode(String::new(), &self.task.take_rows()))
    }

    fn metadata<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyDict>> {
        let metadata = self.task.metadata(name).map_err(refused)?;
        toml_dict::to_dict(py, &metadata.to_table().map_err(refused)?)
    }

    fn __getnewargs__(&self) -> (f64,) {
        (self.noise,)
    }

    fn __getstate__(&self) -> State {
        let (objects, hidden, saved) = self.task.save();
        let hidden = hidden.map(|Hidden { wheel, offset }| (wheel, offset));
        let saved = saved.map(|Saved { motion, goal, grasp, wrench, tare, tick, ended, seed, used }| {
            (motion, goal, grasp, wrench, tare, tick, ended, seed, used)
        });
        (objects, hidden, saved)
    }

    fn __setstate__(&mut self, py: Python<'_>, state: State) -> PyResult<()> {
        let (objects, hidden, saved) = state;
        let hidden = hidden.map(|(wheel, offset)| Hidden { wheel, offset });
        let saved = saved.map(|(motion, goal, grasp, wrench, tare, tick, ended, seed, used)| Saved {
            motion,
            goal,
            grasp,
            wrench,
            tare,
            tick,
            ended,
            seed,
            used,
        });
        run(py, || self.task.restore(objects, hidden, saved.as_ref()))
    }
}
