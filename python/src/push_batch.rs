//! Batches of pushing tasks in Python.

use numpy::{PyArray2, PyReadwriteArray2};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_sim::task::{Autoreset, Rows};
use trundle_sim::{Batch, Options, Outcome, PushTask, ResetOptions, SimError};

use crate::actions::many_numbers;
use crate::decision_time::DecisionClock;
use crate::error::{refused, run_here, simulated};
use crate::push::{PySnapshot, require_same_options};
use crate::view::{hidden_values, view};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyBatch>()
}

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
        require_same_options(&self.options, &snapshot.options)?;
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

fn slice<'a>(array: &'a mut PyReadwriteArray2<'_, f64>) -> PyResult<&'a mut [f64]> {
    array.as_slice_mut().map_err(refused)
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
