//! Simulations with a foreign simulator and laws, and the figures made of them.

use super::law::{acted, corrected, over_step};
use super::path::Recorded;
use super::simulator::{Foreign, go_on};
use nalgebra::Vector6;
use trundle_infer::{InferError, Score, StateVector, Watch};
use trundle_model::{Clock, Plant, State, transport};
use trundle_record::{Noise, Prepared};

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
            since_contact: middle - episode.contact,
            t: middle,
            dt,
            episode: episode.ordinal as f64,
            grasp,
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

    /// Figures over episodes; those that ask for more than simulated poses are left out.
    pub fn score(
        &self,
        episodes: &[Prepared],
        noise: &Noise,
        dof: [bool; 3],
        gyration: f64,
    ) -> Result<Score, InferError> {
        let mut sums = Sums::default();
        for episode in episodes {
            let rho = if dof[2] { gyration } else { 0.0 };
            sums.open(&self.open_loop(episode)?, episode, rho);
            let known = episode.motion_so_far(noise);
            let mut begin = episode.contact.max(episode.pose.first().map_or(0.0, |p| p.t));
            let end = episode.pose.last().map_or(0.0, |p| p.t);
            while begin + WINDOW <= end + 1e-9 {
                let index = episode.pose.partition_point(|p| p.t <= begin + 1e-9).saturating_sub(1);
                let count = episode.pose[index..].partition_point(|p| p.t <= begin + WINDOW + 1e-9);
                if let Some(from) = known.get(index) {
                    let poses = self.poses(episode, index, count, State::moving(from.pose, from.twist))?;
                    sums.window(&poses, &episode.pose[index..]);
                }
                begin += WINDOW;
            }
        }
        Ok(sums.figures(dof[2]))
    }
}

fn vector(state: &State<f64>) -> StateVector {
    let v = Vector6::from_fn(|k, _| if k < 3 { state.pose[k] } else { state.twist[k - 3] });
    v.into()
}

#[derive(Default)]
struct Sums {
    open: [f64; 2],
    count: f64,
    last: [f64; 2],
    episodes: f64,
    unexplained: f64,
    variance: f64,
    window: [f64; 2],
    window_count: f64,
}

fn error(a: [f64; 3], b: [f64; 3]) -> [f64; 2] {
    let turn = (a[2] - b[2]) / std::f64::consts::TAU;
    let turn = (turn - turn.round()) * std::f64::consts::TAU;
    [(a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2), turn * turn]
}

impl Sums {
    fn open(&mut self, simulated: &[[f64; 3]], episode: &Prepared, rho: f64) {
        let n = episode.pose.len().max(1) as f64;
        let center = [0, 1, 2].map(|k| episode.pose.iter().map(|p| p.pose[k]).sum::<f64>() / n);
        for (seen, simulated) in episode.pose.iter().zip(simulated) {
            let [position, heading] = error(seen.pose, *simulated);
            self.open = [self.open[0] + position, self.open[1] + heading];
            self.unexplained += position + rho * rho * heading;
            let d = [0, 1, 2].map(|k| seen.pose[k] - center[k]);
            self.variance += d[0] * d[0] + d[1] * d[1] + (rho * d[2]).powi(2);
        }
        if let (Some(seen), Some(simulated)) = (episode.pose.last(), simulated.last()) {
            let [position, heading] = error(seen.pose, *simulated);
            self.last = [self.last[0] + position.sqrt(), self.last[1] + heading.sqrt()];
        }
        self.count += n;
        self.episodes += 1.0;
    }

    fn window(&mut self, simulated: &[[f64; 3]], seen: &[trundle_record::PoseSample]) {
        for (seen, simulated) in seen.iter().zip(simulated).skip(1) {
            let [position, heading] = error(seen.pose, *simulated);
            self.window = [self.window[0] + position, self.window[1] + heading];
            self.window_count += 1.0;
        }
    }

    fn figures(&self, turns: bool) -> Score {
        let root = |sum: f64, count: f64| (count > 0.0).then(|| (sum / count).sqrt());
        let turning = |value: Option<f64>| value.filter(|_| turns);
        let mean = |sum: f64| (self.episodes > 0.0).then(|| sum / self.episodes);
        Score {
            position_rmse: root(self.open[0], self.count),
            heading_rmse: turning(root(self.open[1], self.count)),
            final_position_error: mean(self.last[0]),
            final_heading_error: turning(mean(self.last[1])),
            r2: (self.variance > 0.0).then(|| 1.0 - self.unexplained / self.variance),
            window_position_rmse: root(self.window[0], self.window_count),
            window_heading_rmse: turning(root(self.window[1], self.window_count)),
            ..Score::default()
        }
    }
}
