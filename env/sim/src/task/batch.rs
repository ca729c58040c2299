//! Many environments side by side, stepped by all cores.

use rayon::prelude::*;

use super::{Options, Outcome, Pushing, Reset};
use crate::SimError;

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
    autoreset: Autoreset,
}

/// So many environments at least are one thread's, steps being short.
const SHARE: usize = 8;

impl Batch {
    /// So many environments.
    ///
    /// # Errors
    /// When an option makes no sense.
    pub fn new(options: Options, count: usize, autoreset: Autoreset) -> Result<Self, SimError> {
        let entries = options.entries();
        Ok(Self { envs: vec![Pushing::new(options)?; count], entries, autoreset })
    }

    /// The environments.
    pub fn envs(&self) -> &[Pushing] {
        &self.envs
    }

    /// One of them.
    pub fn env(&mut self, index: usize) -> Option<&mut Pushing> {
        self.envs.get_mut(index)
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
        let rows = observations.par_chunks_mut(self.entries);
        let results: Vec<_> = (self.envs.par_iter_mut(), told, rows)
            .into_par_iter()
            .with_min_len(SHARE)
            .map(|(env, told, row)| {
                let Some((seed, told)) = told else { return Ok(()) };
                env.reset(*seed, told)?;
                env.observe(row);
                Ok(())
            })
            .collect();
        results.into_iter().collect()
    }

    /// Whether every environment has an episode under way, or will have without being asked.
    pub fn ready(&self) -> bool {
        let waits = |env: &Pushing| self.autoreset == Autoreset::NextStep && env.room().is_some();
        self.envs.iter().all(|env| env.ready() || waits(env))
    }

    /// Step all; `actions` has three numbers in [−1, 1] for each.
    ///
    /// # Errors
    /// When a new episode cannot begin.
    pub fn step(&mut self, actions: &[f64], rows: Rows<'_>) -> Result<(), SimError> {
        let (entries, autoreset) = (self.entries, self.autoreset);
        let all = (
            self.envs.par_iter_mut(),
            actions.par_chunks(3),
            rows.observations.par_chunks_mut(entries),
            rows.finals.par_chunks_mut(entries),
            rows.outcomes.par_iter_mut(),
        );
        all.into_par_iter().with_min_len(SHARE).try_for_each(|(env, action, row, last, outcome)| {
            *outcome = Outcome::default();
            let action = [0, 1, 2].map(|k| action.get(k).copied().unwrap_or(0.0));
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
        })
    }
}
