//! Simulations with a foreign simulator and laws, and the figures made of them.

use super::law::{acted, acts, over_step};
use super::own_states::{beginning, followed, on_offer};
use super::simulator::{Foreign, go_on};
use nalgebra::Vector6;
use trundle_infer::{ErrorMetrics, InferError, Readings, Score, StateVector, Step, Watch};
use trundle_model::{INNER, Plant, State};
use trundle_record::{Dataset, Motion, Prepared};

/// Length of a window of the figures, s.
const WINDOW: f64 = 1.0;

/// A simulation with laws.
pub(crate) struct Rollout<'a> {
    pub foreign: &'a Foreign<'a>,
    /// Values of its parameters.
    pub values: &'a [f64],
    /// The laws that are added, on the body that they know.
    pub plant: Plant<f64>,
    pub data: &'a Dataset,
    pub watch: &'a dyn Watch,
}

/// An episode that is simulated, with what is known of it at each pose.
pub(crate) struct Seen<'e> {
    episode: &'e Prepared,
    readings: Readings,
    /// The motion by the poses up to each.
    known: Vec<Motion>,
    /// The laws' own states along that motion.
    inner: Vec<[f64; INNER]>,
}

impl Rollout<'_> {
    /// An episode with where the laws' own states are along it.
    pub fn seen<'e>(&self, episode: &'e Prepared) -> Result<Seen<'e>, InferError> {
        let noise = &self.data.noise;
        let laws = (&self.plant, self.values);
        let start = beginning(self.foreign, laws, episode, (noise, self.data.dof), self.watch)?;
        let known = episode.motion_so_far(noise);
        let inner = followed(&self.plant, episode, &known, start);
        Ok(Seen { episode, readings: Readings::new(episode), known, inner })
    }

    /// An episode of which no pose is known but the first, laws' own states beginning as they may.
    pub fn unseen<'e>(&self, episode: &'e Prepared) -> Seen<'e> {
        let inner = vec![on_offer(&self.plant)];
        Seen { episode, readings: Readings::new(episode), known: vec![], inner }
    }

    /// Poses at the times of `count` recorded ones from the pose number `first` on, starting in `state`.
    fn poses(
        &self,
        seen: &Seen<'_>,
        first: usize,
        count: usize,
        mut state: State<f64>,
    ) -> Result<Vec<[f64; 3]>, InferError> {
        let all = &seen.episode.pose;
        let mut poses = vec![state.pose];
        for pair in all[first..(first + count).min(all.len())].windows(2) {
            go_on(self.watch)?;
            for step in seen.readings.steps(pair[0].t, &pair[1]) {
                self.step(seen, &step, &mut state)?;
            }
            poses.push(state.pose);
        }
        Ok(poses)
    }

    /// One step. The laws are asked under everything that acts without them, which a first call of the simulator tells.
    fn step(&self, seen: &Seen<'_>, step: &Step, state: &mut State<f64>) -> Result<(), InferError> {
        let (plant, dt) = (&self.plant, step.dt);
        let (applied, clock) = seen.readings.applied_wrench(plant, step);
        let (before, t) = (vector(state), step.clock.t - dt / 2.0);
        let ask =
            |wrench: &[f64; 3]| self.foreign.step(&seen.episode.name, t, &before, wrench, dt, self.values);
        let mut after = ask(&applied)?;
        if acts(plant) {
            let added = over_step(plant, state, acted(plant, &before, &after, dt), clock, dt);
            if added != [0.0; 3] {
                after = ask(&[0, 1, 2].map(|k| applied[k] + added[k]))?;
            }
        }
        let [x, y, theta, vx, vy, spin] = after;
        *state = State { pose: [x, y, theta], twist: [vx, vy, spin], inner: state.inner };
        Ok(())
    }

    /// The whole episode from its first pose.
    pub fn open_loop(&self, seen: &Seen<'_>) -> Result<Vec<[f64; 3]>, InferError> {
        let Some(first) = seen.episode.pose.first() else { return Ok(vec![]) };
        let inner = seen.inner.first().copied().unwrap_or_default();
        let start = State::moving(first.pose, seen.episode.first_twist).with_inner(inner);
        self.poses(seen, 0, seen.episode.pose.len(), start)
    }

    /// Poses from one number on, from what the poses up to it tell of the motion; empty where they tell nothing.
    fn from(&self, seen: &Seen<'_>, index: usize, count: usize) -> Result<Vec<[f64; 3]>, InferError> {
        let Some(from) = seen.known.get(index) else { return Ok(vec![]) };
        let inner = seen.inner.get(index).copied().unwrap_or_default();
        self.poses(seen, index, count, State::moving(from.pose, from.twist).with_inner(inner))
    }

    /// Seen less predicted pose at the end of a span of time.
    pub fn ahead(&self, seen: &Seen<'_>, [begin, end]: [f64; 2]) -> Result<Option<[f64; 3]>, InferError> {
        let all = &seen.episode.pose;
        let until = |t: f64| all.partition_point(|p| p.t <= t + 1e-9);
        let index = until(begin).saturating_sub(1);
        let poses = self.from(seen, index, until(end).saturating_sub(index))?;
        let reached = (index + poses.len()).checked_sub(1).and_then(|k| all.get(k));
        let last = reached.zip(poses.last());
        Ok(last.map(|(seen, simulated)| [0, 1, 2].map(|k| seen.pose[k] - simulated[k])))
    }

    /// Figures over episodes, of which `unjudged` seconds after contact do not count; those that ask for more than simulated
    /// poses are left out.
    pub fn score(&self, episodes: &[Prepared], unjudged: f64) -> Result<Score, InferError> {
        let mut tally = ErrorMetrics::default();
        let turns = self.data.dof[2];
        for episode in episodes {
            let seen = self.seen(episode)?;
            let rho = if turns { self.data.body.gyration } else { 0.0 };
            tally.add_open_loop(&self.open_loop(&seen)?, episode, rho, unjudged);
            let mut begin = episode.contact.max(episode.pose.first().map_or(0.0, |p| p.t));
            let end = episode.pose.last().map_or(0.0, |p| p.t);
            while begin + WINDOW <= end + 1e-9 {
                let index = episode.pose.partition_point(|p| p.t <= begin + 1e-9).saturating_sub(1);
                let count = episode.pose[index..].partition_point(|p| p.t <= begin + WINDOW + 1e-9);
                let poses = self.from(&seen, index, count)?;
                let pairs = episode.pose[index..].iter().zip(&poses).skip(1);
                for (pose, simulated) in pairs.filter(|(p, _)| p.t > episode.contact + unjudged) {
                    tally.add_window([0, 1, 2].map(|k| pose.pose[k] - simulated[k]));
                }
                begin += WINDOW;
            }
        }
        Ok(tally.score(turns))
    }
}

fn vector(state: &State<f64>) -> StateVector {
    let v = Vector6::from_fn(|k, _| if k < 3 { state.pose[k] } else { state.twist[k - 3] });
    v.into()
}
