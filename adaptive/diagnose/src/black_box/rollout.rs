//! Simulations of a black-box simulator with laws, and their error metrics.

use super::initial_states::estimate_initial_state;
use super::law_states::{default_states, states_along};
use super::law_wrench::{has_laws, law_wrench_over_step, wrench_from_motion};
use super::simulator::{BlackBox, check_cancelled};
use nalgebra::Vector6;
use trundle_infer::{
    ErrorMetrics, InferError, PREDICTION_WINDOW_S, Readings, Score, StateVector, Step, Watch,
};
use trundle_model::{MAX_INNER_STATES, Plant, State};
use trundle_record::{Dataset, Motion, Prepared};

/// A simulator with laws and parameter values.
pub(crate) struct Rollout<'a> {
    pub simulator: &'a BlackBox<'a>,
    /// Values of the simulator's parameters.
    pub values: &'a [f64],
    /// The added laws, on the rigid body without laws.
    pub plant: Plant<f64>,
    pub data: &'a Dataset,
    pub watch: &'a dyn Watch,
}

/// An episode with the estimated states at each of its poses.
pub(crate) struct EpisodeStates<'e> {
    episode: &'e Prepared,
    readings: Readings,
    /// Motion at each pose, estimated from the poses up to it.
    filtered_motion: Vec<Motion>,
    /// Internal states of the laws along that motion.
    law_states: Vec<[f64; MAX_INNER_STATES]>,
}

impl Rollout<'_> {
    /// Estimates the states of an episode, including the internal states of the laws.
    pub fn episode_states<'e>(&self, episode: &'e Prepared) -> Result<EpisodeStates<'e>, InferError> {
        let noise = &self.data.noise;
        let laws = (&self.plant, self.values);
        let start =
            estimate_initial_state(self.simulator, laws, episode, (noise, self.data.dof), self.watch)?;
        let filtered_motion = episode.filtered_motion(noise);
        let law_states = states_along(&self.plant, episode, &filtered_motion, start);
        Ok(EpisodeStates { episode, readings: Readings::new(episode), filtered_motion, law_states })
    }

    /// States of an episode of which only the first pose is known; internal states have their defaults.
    pub fn without_poses<'e>(&self, episode: &'e Prepared) -> EpisodeStates<'e> {
        let law_states = vec![default_states(&self.plant)];
        EpisodeStates { episode, readings: Readings::new(episode), filtered_motion: vec![], law_states }
    }

    /// Simulated poses at the times of `count` recorded ones, from the pose `first` on, starting in `state`.
    fn poses(
        &self,
        states: &EpisodeStates<'_>,
        first: usize,
        count: usize,
        mut state: State<f64>,
    ) -> Result<Vec<[f64; 3]>, InferError> {
        let all = &states.episode.pose;
        let mut poses = vec![state.pose];
        for pair in all[first..(first + count).min(all.len())].windows(2) {
            check_cancelled(self.watch)?;
            for step in states.readings.steps(pair[0].t, &pair[1]) {
                self.step(states, &step, &mut state)?;
            }
            poses.push(state.pose);
        }
        Ok(poses)
    }

    /// Makes one step. A first call of the simulator gives the total wrench without laws, under which the laws are
    /// evaluated.
    fn step(
        &self,
        states: &EpisodeStates<'_>,
        step: &Step,
        state: &mut State<f64>,
    ) -> Result<(), InferError> {
        let (plant, dt) = (&self.plant, step.dt);
        let (applied, clock) = states.readings.applied_wrench(plant, step);
        let (before, t) = (vector(state), step.clock.t - dt / 2.0);
        let call = |wrench: &[f64; 3]| {
            self.simulator.step(&states.episode.name, t, &before, wrench, dt, self.values)
        };
        let mut after = call(&applied)?;
        if has_laws(plant) {
            let added =
                law_wrench_over_step(plant, state, wrench_from_motion(plant, &before, &after, dt), clock, dt);
            if added != [0.0; 3] {
                after = call(&[0, 1, 2].map(|k| applied[k] + added[k]))?;
            }
        }
        let [x, y, theta, vx, vy, spin] = after;
        *state = State { pose: [x, y, theta], twist: [vx, vy, spin], inner: state.inner };
        Ok(())
    }

    /// Simulates a whole episode from its first pose.
    pub fn open_loop(&self, states: &EpisodeStates<'_>) -> Result<Vec<[f64; 3]>, InferError> {
        let Some(first) = states.episode.pose.first() else { return Ok(vec![]) };
        let law_states = states.law_states.first().copied().unwrap_or_default();
        let start = State::moving(first.pose, states.episode.first_twist).with_inner(law_states);
        self.poses(states, 0, states.episode.pose.len(), start)
    }

    /// Simulated poses from the pose `index` on, starting from the motion estimated there; empty without an estimate.
    fn poses_from(
        &self,
        states: &EpisodeStates<'_>,
        index: usize,
        count: usize,
    ) -> Result<Vec<[f64; 3]>, InferError> {
        let Some(from) = states.filtered_motion.get(index) else { return Ok(vec![]) };
        let law_states = states.law_states.get(index).copied().unwrap_or_default();
        self.poses(states, index, count, State::moving(from.pose, from.twist).with_inner(law_states))
    }

    /// Measured minus predicted pose at the end of a span of time.
    pub fn error_ahead(
        &self,
        states: &EpisodeStates<'_>,
        [begin, end]: [f64; 2],
    ) -> Result<Option<[f64; 3]>, InferError> {
        let all = &states.episode.pose;
        let until = |t: f64| all.partition_point(|p| p.t <= t + 1e-9);
        let index = until(begin).saturating_sub(1);
        let poses = self.poses_from(states, index, until(end).saturating_sub(index))?;
        let reached = (index + poses.len()).checked_sub(1).and_then(|k| all.get(k));
        let last = reached.zip(poses.last());
        Ok(last.map(|(measured, simulated)| [0, 1, 2].map(|k| measured.pose[k] - simulated[k])))
    }

    /// Error metrics of some episodes. Samples less than `unjudged` seconds after contact do not count. Metrics that
    /// need more than simulated poses are omitted.
    pub fn score(&self, episodes: &[Prepared], unjudged: f64) -> Result<Score, InferError> {
        let mut metrics = ErrorMetrics::default();
        let turns = self.data.dof[2];
        for episode in episodes {
            let states = self.episode_states(episode)?;
            let rho = if turns { self.data.body.gyration } else { 0.0 };
            metrics.add_open_loop(&self.open_loop(&states)?, episode, rho, unjudged);
            let mut begin = episode.contact.max(episode.pose.first().map_or(0.0, |p| p.t));
            let end = episode.pose.last().map_or(0.0, |p| p.t);
            while begin + PREDICTION_WINDOW_S <= end + 1e-9 {
                let index = episode.pose.partition_point(|p| p.t <= begin + 1e-9).saturating_sub(1);
                let count =
                    episode.pose[index..].partition_point(|p| p.t <= begin + PREDICTION_WINDOW_S + 1e-9);
                let poses = self.poses_from(&states, index, count)?;
                let pairs = episode.pose[index..].iter().zip(&poses).skip(1);
                for (pose, simulated) in pairs.filter(|(p, _)| p.t > episode.contact + unjudged) {
                    metrics.add_window([0, 1, 2].map(|k| pose.pose[k] - simulated[k]));
                }
                begin += PREDICTION_WINDOW_S;
            }
        }
        Ok(metrics.score(turns))
    }
}

fn vector(state: &State<f64>) -> StateVector {
    let v = Vector6::from_fn(|k, _| if k < 3 { state.pose[k] } else { state.twist[k - 3] });
    v.into()
}
