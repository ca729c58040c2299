//! Simulations with a foreign simulator and laws, and the figures made of them.

use super::law::{acted, corrected, over_step};
use super::path::Recorded;
use super::simulator::{Foreign, go_on};
use nalgebra::Vector6;
use trundle_infer::{InferError, Score, StateVector, Tally, Watch};
use trundle_model::{Clock, Plant, State, transport};
use trundle_record::{Motion, Noise, Prepared};

/// Longest step, s: as in a fit.
const LONGEST: f64 = 0.008;
/// Length of a window of the figures, s.
const WINDOW: f64 = 1.0;

/// A simulation with laws.
pub(crate) struct Rollout<'a> {
    pub foreign: &'a Foreign<'a>,
    /// Values of its parameters.
    pub values: &'a [f64],
    /// The laws that are added, on the body that they know.
    pub plant: Plant<f64>,
    pub watch: &'a dyn Watch,
}

impl Rollout<'_> {
    /// Poses at the times of the recorded ones from the pose number `first` on, starting in `state`.
    fn poses(
        &self,
        episode: &Prepared,
        first: usize,
        count: usize,
        mut state: State<f64>,
    ) -> Result<Vec<[f64; 3]>, InferError> {
        let recorded = Recorded::new(episode);
        let mut poses = vec![state.pose];
        for pair in episode.pose[first..(first + count).min(episode.pose.len())].windows(2) {
            go_on(self.watch)?;
            let pieces = ((pair[1].t - pair[0].t) / LONGEST).ceil().max(1.0);
            let dt = (pair[1].t - pair[0].t) / pieces;
            for k in 0..pieces as usize {
                let t = pair[0].t + k as f64 * dt;
                self.step(episode, &recorded, t, dt, &mut state)?;
            }
            poses.push(state.pose);
        }
        Ok(poses)
    }

    /// One step. The laws are asked under everything that acts without them, which a first call of the simulator tells.
    fn step(
        &self,
        episode: &Prepared,
        recorded: &Recorded,
        t: f64,
        dt: f64,
        state: &mut State<f64>,
    ) -> Result<(), InferError> {
        let (reading, frame) = recorded.mean(t, t + dt);
        let middle = t + dt / 2.0;
        let grasp = [frame[0], frame[1]];
        let clock = Clock {
            t: middle,
            dt,
            episode: episode.ordinal as f64,
            grasp,
            ..Clock::since_contact(middle - episode.contact)
        };
        let plant = &self.plant;
        let applied = transport(corrected(plant, recorded, t, dt, reading, clock), frame);
        let before = vector(state);
        let ask = |wrench: &[f64; 3]| self.foreign.step(&episode.name, t, &before, wrench, dt, self.values);
        let mut after = ask(&applied)?;
        if !plant.laws.is_empty() {
            let added = over_step(plant, state, acted(plant, &before, &after, dt), clock, dt);
            if added != [0.0; 3] {
                after = ask(&[0, 1, 2].map(|k| applied[k] + added[k]))?;
            }
        }
        let [x, y, theta, vx, vy, spin] = after;
        *state = State { pose: [x, y, theta], twist: [vx, vy, spin], inner: state.inner };
        Ok(())
    }

    /// The whole episode from its first pose, at rest.
    pub fn open_loop(&self, episode: &Prepared) -> Result<Vec<[f64; 3]>, InferError> {
        let Some(first) = episode.pose.first() else { return Ok(vec![]) };
        self.poses(episode, 0, episode.pose.len(), State::at_rest(first.pose))
    }

    /// Seen less predicted pose at the end of a span of time, `known` being the motion by the poses up to each.
    pub fn ahead(
        &self,
        episode: &Prepared,
        known: &[Motion],
        [begin, end]: [f64; 2],
    ) -> Result<Option<[f64; 3]>, InferError> {
        let until = |t: f64| episode.pose.partition_point(|p| p.t <= t + 1e-9);
        let index = until(begin).saturating_sub(1);
        let Some(from) = known.get(index) else { return Ok(None) };
        let count = until(end) - index;
        let poses = self.poses(episode, index, count, State::moving(from.pose, from.twist))?;
        let seen = episode.pose.get(index + poses.len() - 1);
        let last = seen.zip(poses.last());
        Ok(last.map(|(seen, simulated)| [0, 1, 2].map(|k| seen.pose[k] - simulated[k])))
    }

    /// Figures over episodes; those that ask for more than simulated poses are left out.
    pub fn score(
        &self,
        episodes: &[Prepared],
        noise: &Noise,
        dof: [bool; 3],
        gyration: f64,
    ) -> Result<Score, InferError> {
        let mut tally = Tally::default();
        for episode in episodes {
            let rho = if dof[2] { gyration } else { 0.0 };
            tally.open_loop(&self.open_loop(episode)?, episode, rho, 0.0);
            let known = episode.motion_so_far(noise);
            let mut begin = episode.contact.max(episode.pose.first().map_or(0.0, |p| p.t));
            let end = episode.pose.last().map_or(0.0, |p| p.t);
            while begin + WINDOW <= end + 1e-9 {
                let index = episode.pose.partition_point(|p| p.t <= begin + 1e-9).saturating_sub(1);
                let count = episode.pose[index..].partition_point(|p| p.t <= begin + WINDOW + 1e-9);
                if let Some(from) = known.get(index) {
                    let poses = self.poses(episode, index, count, State::moving(from.pose, from.twist))?;
                    for (seen, simulated) in episode.pose[index..].iter().zip(&poses).skip(1) {
                        tally.ahead([0, 1, 2].map(|k| seen.pose[k] - simulated[k]));
                    }
                }
                begin += WINDOW;
            }
        }
        Ok(tally.figures(dof[2]))
    }
}

fn vector(state: &State<f64>) -> StateVector {
    let v = Vector6::from_fn(|k, _| if k < 3 { state.pose[k] } else { state.twist[k - 3] });
    v.into()
}
