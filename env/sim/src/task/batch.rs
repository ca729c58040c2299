//! Batches of environments that are stepped in parallel.

use rayon::prelude::*;

#[cfg(doc)]
use super::ActionMode;
use super::memory;
use super::options::Options;
use super::outcome::Outcome;
use super::push_task::PushTask;
use super::scene_layout::ResetOptions;
use crate::{SimError, thread_pool};

/// Autoreset mode, as in Gymnasium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Autoreset {
    /// The next step ignores its action and starts a new episode.
    NextStep,
    /// The same step starts a new episode and returns the final observation separately.
    SameStep,
    /// The caller resets.
    Disabled,
}

/// Output buffers of a step. Every slice has one row per environment.
pub struct Rows<'a> {
    /// Observations, [`Options::observation_len`] numbers each.
    pub observations: &'a mut [f64],
    /// Final observations of episodes that ended in a same-step reset.
    pub finals: &'a mut [f64],
    /// Outcomes.
    pub outcomes: &'a mut [Outcome],
}

/// Environments with the same options.
pub struct Batch {
    envs: Vec<PushTask>,
    entries: usize,
    width: usize,
    autoreset: Autoreset,
}

/// Upper bound on the memory of an environment, bytes, reached with the engine and obstacles (`tests/allocation.rs`
/// measures it).
const MAX_ENVIRONMENT_BYTES: u64 = 64 << 10;

/// Smallest number of environments per thread. Steps are short, so smaller shares do not pay off.
const MIN_ENVS_PER_THREAD: usize = 8;

impl Batch {
    /// Create `count` environments.
    ///
    /// # Errors
    /// If an option is out of range, or the environments do not fit into memory.
    pub fn new(options: Options, count: usize, autoreset: Autoreset) -> Result<Self, SimError> {
        let free = memory::available_bytes();
        let max_count = (free / MAX_ENVIRONMENT_BYTES) as usize;
        if count > max_count {
            return Err(SimError::TooManyEnvironments {
                count,
                each_kib: MAX_ENVIRONMENT_BYTES >> 10,
                free_mib: free >> 20,
                max_count,
            });
        }
        let (entries, width) = (options.observation_len(), options.action.width());
        Ok(Self { envs: vec![PushTask::new(options)?; count], entries, width, autoreset })
    }

    /// The environments.
    pub fn envs(&self) -> &[PushTask] {
        &self.envs
    }

    /// An environment by index.
    pub fn env(&mut self, index: usize) -> Option<&mut PushTask> {
        self.envs.get_mut(index)
    }

    /// Restore the saved states of all environments.
    ///
    /// # Errors
    /// If one of them is not a saved state of this task.
    pub fn load(&mut self, states: &[Vec<u8>]) -> Result<(), SimError> {
        self.envs.iter_mut().zip(states).try_for_each(|(env, state)| env.load(state))
    }

    /// Start episodes in the environments that have an entry in `resets`, with its seed and options.
    ///
    /// # Errors
    /// If a reset fails. The error is that of the environment with the lowest index.
    pub fn reset(
        &mut self,
        resets: &[Option<(Option<u64>, ResetOptions)>],
        observations: &mut [f64],
    ) -> Result<(), SimError> {
        let entries = self.entries;
        let begin = |env: &mut PushTask, resets: &Option<(Option<u64>, ResetOptions)>, row: &mut [f64]| {
            let Some((seed, resets)) = resets else { return Ok(()) };
            env.reset(*seed, resets)?;
            env.observe(row);
            Ok(())
        };
        let envs = &mut self.envs;
        let results: Vec<_> = if envs.len() <= MIN_ENVS_PER_THREAD {
            let all = envs.iter_mut().zip(resets).zip(observations.chunks_mut(entries));
            all.map(|((env, resets), row)| begin(env, resets, row)).collect()
        } else {
            on_threads(|| {
                let all = (envs.par_iter_mut(), resets, observations.par_chunks_mut(entries)).into_par_iter();
                all.with_min_len(MIN_ENVS_PER_THREAD)
                    .map(|(env, resets, row)| begin(env, resets, row))
                    .collect()
            })?
        };
        let named = |(index, result): (usize, Result<(), SimError>)| {
            result.map_err(|error| SimError::Environment(index, Box::new(error)))
        };
        results.into_iter().enumerate().try_for_each(named)
    }

    /// Number of entries of an environment's action.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Whether every environment has a running episode, or resets itself in the next step.
    pub fn ready(&self) -> bool {
        let waits = |env: &PushTask| self.autoreset == Autoreset::NextStep && env.layout().is_some();
        self.envs.iter().all(|env| env.ready() || waits(env))
    }

    /// Step all environments. `actions` has [`ActionMode::width`] numbers for each, which are clipped to [−1, 1].
    ///
    /// # Errors
    /// If a motion is not finite or a new episode cannot start.
    pub fn step(&mut self, actions: &[f64], rows: Rows<'_>) -> Result<(), SimError> {
        let thinking = self.envs.first().map_or(0.0, |env| env.options().decision_time);
        self.step_after(actions, thinking, rows)
    }

    /// As [`Batch::step`], after a decision that took `thinking` s.
    ///
    /// # Errors
    /// As [`Batch::step`].
    pub fn step_after(&mut self, actions: &[f64], thinking: f64, rows: Rows<'_>) -> Result<(), SimError> {
        let Self { entries, width, autoreset, .. } = *self;
        let Rows { observations, finals, outcomes } = rows;
        let envs = &mut self.envs;
        if envs.len() <= MIN_ENVS_PER_THREAD {
            let rows = observations.chunks_mut(entries).zip(finals.chunks_mut(entries)).zip(outcomes);
            let all = envs.iter_mut().zip(actions.chunks(width)).zip(rows);
            return all.into_iter().try_for_each(|((env, action), ((row, last), outcome))| {
                step_one(autoreset, env, (action, thinking), row, last, outcome)
            });
        }
        on_threads(|| {
            let rows = (observations.par_chunks_mut(entries), finals.par_chunks_mut(entries), outcomes);
            let (observations, finals, outcomes) = rows;
            let all = (
                envs.par_iter_mut(),
                actions.par_chunks(width),
                observations,
                finals,
                outcomes.par_iter_mut(),
            );
            all.into_par_iter().with_min_len(MIN_ENVS_PER_THREAD).try_for_each(
                |(env, action, row, last, outcome)| {
                    step_one(autoreset, env, (action, thinking), row, last, outcome)
                },
            )
        })?
    }
}

/// Step one environment, or start its next episode.
fn step_one(
    autoreset: Autoreset,
    env: &mut PushTask,
    (action, thinking): (&[f64], f64),
    row: &mut [f64],
    last: &mut [f64],
    outcome: &mut Outcome,
) -> Result<(), SimError> {
    *outcome = Outcome::default();
    match env.step_after(action, thinking)? {
        Some(result) => *outcome = result,
        None => env.reset(None, &ResetOptions::default())?,
    }
    env.observe(row);
    if autoreset == Autoreset::SameStep && !env.ready() {
        last.copy_from_slice(row);
        env.reset(None, &ResetOptions::default())?;
        env.observe(row);
    }
    Ok(())
}

/// Run on the caller's thread pool, or else on that of the process.
fn on_threads<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, SimError> {
    match rayon::current_thread_index() {
        Some(_) => Ok(work()),
        None => Ok(thread_pool()?.install(work)),
    }
}
