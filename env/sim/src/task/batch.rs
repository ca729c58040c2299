//! Many environments side by side, stepped by all cores.

use rayon::prelude::*;

#[cfg(doc)]
use super::Mode;
use super::{Options, Outcome, Pushing, Reset, memory};
use crate::{SimError, thread_pool};

/// What happens after an episode's end, as in Gymnasium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Autoreset {
    /// The next step begins a new episode, whatever the action.
    NextStep,
    /// The same step does; the last observation is kept apart.
    SameStep,
    /// Whoever steps resets.
    Disabled,
}

/// Where a batch writes; every slice has one row for each environment.
pub struct Rows<'a> {
    /// Observations, [`Options::entries`] numbers each.
    pub observations: &'a mut [f64],
    /// Last observations of episodes that ended in a same-step reset.
    pub finals: &'a mut [f64],
    /// Outcomes.
    pub outcomes: &'a mut [Outcome],
}

/// Environments of the same options.
pub struct Batch {
    envs: Vec<Pushing>,
    entries: usize,
    width: usize,
    autoreset: Autoreset,
}

/// Memory that an environment may take, bytes: where the engine has the object among obstacles it takes most, and then
/// no more than this (`tests/allocation.rs` measures it).
const ENVIRONMENT_BYTES: u64 = 64 << 10;

/// So many environments at least are one thread's, steps being short.
const SHARE: usize = 8;

impl Batch {
    /// So many environments.
    ///
    /// # Errors
    /// When an option makes no sense, or so many do not fit into memory.
    pub fn new(options: Options, count: usize, autoreset: Autoreset) -> Result<Self, SimError> {
        let free = memory::available();
        let most = (free / ENVIRONMENT_BYTES) as usize;
        if count > most {
            return Err(SimError::TooMany { count, each: ENVIRONMENT_BYTES >> 10, free: free >> 20, most });
        }
        let (entries, width) = (options.entries(), options.action.width());
        Ok(Self { envs: vec![Pushing::new(options)?; count], entries, width, autoreset })
    }

    /// The environments.
    pub fn envs(&self) -> &[Pushing] {
        &self.envs
    }

    /// One of them.
    pub fn env(&mut self, index: usize) -> Option<&mut Pushing> {
        self.envs.get_mut(index)
    }

    /// Go on from what each of another batch has saved.
    ///
    /// # Errors
    /// When one is no saved state of such a task.
    pub fn load(&mut self, states: &[Vec<u8>]) -> Result<(), SimError> {
        self.envs.iter_mut().zip(states).try_for_each(|(env, state)| env.load(state))
    }

    /// Begin episodes where `told` has one: its seed, and what it is told.
    ///
    /// # Errors
    /// The first environment's that cannot, whatever the order in which they are reset.
    pub fn reset(
        &mut self,
        told: &[Option<(Option<u64>, Reset)>],
        observations: &mut [f64],
    ) -> Result<(), SimError> {
        let entries = self.entries;
        let begin = |env: &mut Pushing, told: &Option<(Option<u64>, Reset)>, row: &mut [f64]| {
            let Some((seed, told)) = told else { return Ok(()) };
            env.reset(*seed, told)?;
            env.observe(row);
            Ok(())
        };
        let envs = &mut self.envs;
        let results: Vec<_> = if envs.len() <= SHARE {
            let all = envs.iter_mut().zip(told).zip(observations.chunks_mut(entries));
            all.map(|((env, told), row)| begin(env, told, row)).collect()
        } else {
            on_threads(|| {
                let all = (envs.par_iter_mut(), told, observations.par_chunks_mut(entries)).into_par_iter();
                all.with_min_len(SHARE).map(|(env, told, row)| begin(env, told, row)).collect()
            })?
        };
        let named = |(index, result): (usize, Result<(), SimError>)| {
            result.map_err(|error| SimError::Environment(index, Box::new(error)))
        };
        results.into_iter().enumerate().try_for_each(named)
    }

    /// Entries of each environment's action.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Whether every environment has an episode under way, or will have without being asked.
    pub fn ready(&self) -> bool {
        let waits = |env: &Pushing| self.autoreset == Autoreset::NextStep && env.room().is_some();
        self.envs.iter().all(|env| env.ready() || waits(env))
    }

    /// Step all; `actions` has [`Mode::width`] numbers in [−1, 1] for each.
    ///
    /// # Errors
    /// When a new episode cannot begin.
    pub fn step(&mut self, actions: &[f64], rows: Rows<'_>) -> Result<(), SimError> {
        let Self { entries, width, autoreset, .. } = *self;
        let Rows { observations, finals, outcomes } = rows;
        let envs = &mut self.envs;
        if envs.len() <= SHARE {
            let rows = observations.chunks_mut(entries).zip(finals.chunks_mut(entries)).zip(outcomes);
            let all = envs.iter_mut().zip(actions.chunks(width)).zip(rows);
            return all.into_iter().try_for_each(|((env, action), ((row, last), outcome))| {
                one(autoreset, env, action, row, last, outcome)
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
            all.into_par_iter().with_min_len(SHARE).try_for_each(|(env, action, row, last, outcome)| {
                one(autoreset, env, action, row, last, outcome)
            })
        })?
    }
}

/// Step one environment, or begin its next episode.
fn one(
    autoreset: Autoreset,
    env: &mut Pushing,
    action: &[f64],
    row: &mut [f64],
    last: &mut [f64],
    outcome: &mut Outcome,
) -> Result<(), SimError> {
    *outcome = Outcome::default();
    match env.step(action)? {
        Some(result) => *outcome = result,
        None => env.reset(None, &Reset::default())?,
    }
    env.observe(row);
    if autoreset == Autoreset::SameStep && !env.ready() {
        last.copy_from_slice(row);
        env.reset(None, &Reset::default())?;
        env.observe(row);
    }
    Ok(())
}

/// Run on the threads that the caller is one of, else on this process's.
fn on_threads<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, SimError> {
    match rayon::current_thread_index() {
        Some(_) => Ok(work()),
        None => Ok(thread_pool()?.install(work)),
    }
}
