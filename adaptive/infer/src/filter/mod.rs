//! Extended Kalman filter over an episode: the likelihood of poses under wrench noise, exact up to
//! linearisation.
//!
//! The state consists of the pose, the twist and the error of the wrench reading. The error starts with the
//! uncertainty of the tare and may be a random walk. Its smoothed path is the wrench that the model misses.

mod initial_belief;
mod innovation;
mod linear;
mod response;
mod smooth;
mod step;

use crate::covariance::{
    BASE_STATES, Belief, MOTION_STATES, Matrix, POSE_STATES, STATES, Vector, corrected, propagated,
};
use crate::curve::Curve;
use crate::{Channels, InferError, Track, track::Step};
use std::f64::consts::TAU;
use trundle_model::{Dual, InnerState, MAX_INNER_STATES, Model, Plant, Real, State};
use trundle_record::Motion;

pub use innovation::Innovation;
use innovation::PoseInnovation;
pub use response::Response;
pub use smooth::Residual;
use smooth::{Stage, backward};
pub(crate) use step::{advance, applied_wrench};

/// Number of states without the pose.
const NON_POSE_STATES: usize = BASE_STATES - POSE_STATES;

/// Number of starting states that the filter compares, preselected by a simulation.
const MAX_FILTERED_STARTS: usize = 2;

/// Time after the start from which the laws' own starting states are selected, s.
const START_SELECTION_S: f64 = 1.0;

/// Result of filtering an episode.
pub(crate) struct FilterRun {
    /// Innovation of every pose sample, in order.
    pub innovations: Vec<Innovation>,
    /// Starting values of the laws' own states.
    pub inner: [f64; MAX_INNER_STATES],
}

impl FilterRun {
    /// −log density of all pose samples.
    pub fn cost(&self) -> f64 {
        self.innovations.iter().map(|i| i.cost).sum()
    }
}

/// Filters episodes with one plant. Methods return `None` if a number is not finite.
pub(crate) trait EpisodeFilter: Sync {
    /// Innovation of every pose sample.
    fn run(&self, track: &Track) -> Option<FilterRun>;
    /// −log density of all pose samples.
    fn cost(&self, track: &Track) -> Option<f64>;
    /// Wrench error at every step, given the whole episode (Rauch-Tung-Striebel).
    fn smooth(&self, track: &Track) -> Option<Vec<Residual>>;
    /// Prediction of every pose sample from the start of the track alone.
    fn predict_only(&self, track: &Track) -> Option<Vec<Innovation>>;
    /// Predictions of the pose samples in windows of `length` seconds. Each starts from a given motion, which
    /// does not depend on the model, and from the filter's estimate of the laws' own states. A window that is
    /// not finite is `None`.
    fn predict_windows(
        &self,
        track: &Track,
        starts: &[Motion],
        length: f64,
    ) -> Option<Vec<Option<Vec<Innovation>>>>;
    /// The episode as a linear system around this plant.
    fn response(&self, track: &Track) -> Option<Response>;
}

/// Filter for a model at given values.
pub(crate) fn filter(
    model: &Model,
    values: &[f64],
    channels: &Channels,
) -> Result<Box<dyn EpisodeFilter>, InferError> {
    let (plain, inner) = (model.plant(values)?, model.inner());
    // The cost of the laws and of the covariance is proportional to the number of states and derivatives.
    Ok(match (inner.len(), plain.is_pose_invariant()) {
        (0, true) => Box::new(Filter::<BASE_STATES, NON_POSE_STATES>::new(model, values, channels, plain)?),
        (0, false) => Box::new(Filter::<BASE_STATES, BASE_STATES>::new(model, values, channels, plain)?),
        (1, true) => Box::new(Filter::<{ BASE_STATES + 1 }, { NON_POSE_STATES + 1 }>::new(
            model, values, channels, plain,
        )?),
        (1, false) => {
            Box::new(Filter::<{ BASE_STATES + 1 }, { BASE_STATES + 1 }>::new(model, values, channels, plain)?)
        }
        _ => Box::new(Filter::<STATES, STATES>::new(model, values, channels, plain)?),
    })
}

/// Filter with `N` states and derivatives by the last `D` of them: by all states, or by all but the pose for
/// translation- and rotation-invariant motion.
struct Filter<const N: usize, const D: usize> {
    plant: Plant<Dual<D>>,
    /// The same without derivatives, if starting states have to be selected.
    plain: Option<Plant<f64>>,
    dof: [bool; 3],
    inner: Vec<InnerState>,
    /// Variances of a pose sample, zero where a direction is blocked.
    pose_noise: [f64; 3],
    /// Variances of a reading and of the random walk of its error, 1/s; zero where a direction is blocked.
    reading_noise: [f64; 3],
    wander: [f64; 3],
}

impl<const N: usize, const D: usize> EpisodeFilter for Filter<N, D> {
    fn run(&self, track: &Track) -> Option<FilterRun> {
        let inner = self.initial_inner(track)?;
        let mut innovations = Vec::with_capacity(track.observations());
        self.walk(track, &inner, f64::INFINITY, |seen| innovations.push(seen.innovation()))?;
        Some(FilterRun { innovations, inner })
    }

    fn cost(&self, track: &Track) -> Option<f64> {
        let inner = self.initial_inner(track)?;
        let mut cost = 0.0;
        self.walk(track, &inner, f64::INFINITY, |seen| cost += seen.cost)?;
        Some(cost)
    }

    fn smooth(&self, track: &Track) -> Option<Vec<Residual>> {
        let mut stages: Vec<Stage<N>> = Vec::with_capacity(track.steps.len());
        let inner = self.initial_inner(track)?;
        let mut belief = self.initial_belief(track, &inner);
        let mut t = track.start;
        for step in &track.steps {
            let transition = self.predict(&mut belief, step, &track.curve);
            t += step.dt;
            let predicted = belief.clone();
            if let Some(seen) = step.pose {
                let innovation = self.observe(&belief, t, seen, step)?;
                self.update(&mut belief, &innovation);
            }
            stages.push(Stage { transition, predicted, filtered: belief.clone(), frame: step.frame, t });
        }
        Some(backward(stages))
    }

    fn predict_only(&self, track: &Track) -> Option<Vec<Innovation>> {
        let belief = self.initial_belief(track, &self.initial_inner(track)?);
        self.predict_open_loop(&track.steps, &track.curve, belief, track.start)
    }

    fn predict_windows(
        &self,
        track: &Track,
        starts: &[Motion],
        length: f64,
    ) -> Option<Vec<Option<Vec<Innovation>>>> {
        let mut belief = self.initial_belief(track, &self.initial_inner(track)?);
        let (mut t, mut starts, mut found) = (track.start, starts.iter().peekable(), vec![]);
        for (index, step) in track.steps.iter().enumerate() {
            while let Some(start) = starts.next_if(|start| start.t <= t + 1e-9) {
                let mut end = t;
                let within = track.steps[index..].iter().take_while(|step| {
                    end += step.dt;
                    end <= t + length + 1e-9
                });
                let count = within.count();
                let belief = self.restarted_belief(track, start, &belief);
                found.push(self.predict_open_loop(
                    &track.steps[index..index + count],
                    &track.curve,
                    belief,
                    t,
                ));
            }
            self.predict(&mut belief, step, &track.curve);
            t += step.dt;
            if let Some(seen) = step.pose {
                let innovation = self.observe(&belief, t, seen, step)?;
                self.update(&mut belief, &innovation);
            }
        }
        Some(found)
    }

    fn response(&self, track: &Track) -> Option<Response> {
        self.linear(track)
    }
}

impl<const N: usize, const D: usize> Filter<N, D> {
    fn new(
        model: &Model,
        values: &[f64],
        channels: &Channels,
        plain: Plant<f64>,
    ) -> Result<Self, InferError> {
        let inner = model.inner();
        let lifted: Vec<_> = values.iter().map(|&v| Real::lift(v)).collect();
        let dof = model.dof;
        let variances = |sd: [f64; 3]| [0, 1, 2].map(|k| if dof[k] { sd[k] * sd[k] } else { 0.0 });
        let chooses = inner.iter().any(|own| own.starts.len() > 1);
        Ok(Self {
            plant: model.plant(&lifted)?,
            plain: chooses.then_some(plain),
            dof,
            inner,
            pose_noise: variances(channels.pose),
            reading_noise: variances(channels.reading),
            wander: variances(channels.wander),
        })
    }

    /// Filters up to a time and passes each pose sample to `show`.
    fn walk(
        &self,
        track: &Track,
        inner: &[f64; MAX_INNER_STATES],
        until: f64,
        mut show: impl FnMut(&PoseInnovation<N>),
    ) -> Option<()> {
        let mut belief = self.initial_belief(track, inner);
        let mut t = track.start;
        for step in &track.steps {
            self.predict(&mut belief, step, &track.curve);
            t += step.dt;
            if t > until {
                break;
            }
            if let Some(seen) = step.pose {
                let innovation = self.observe(&belief, t, seen, step)?;
                show(&innovation);
                self.update(&mut belief, &innovation);
            }
        }
        Some(())
    }

    /// Open-loop predictions of the pose samples of some steps from a belief at time `t`.
    fn predict_open_loop(
        &self,
        steps: &[Step],
        curve: &Curve,
        mut belief: Belief<N>,
        mut t: f64,
    ) -> Option<Vec<Innovation>> {
        let mut predictions = vec![];
        for step in steps {
            self.predict(&mut belief, step, curve);
            t += step.dt;
            if let Some(seen) = step.pose {
                predictions.push(self.observe(&belief, t, seen, step)?.innovation());
            }
        }
        Some(predictions)
    }

    /// Starting values of the laws' own states, of all combinations that the laws offer, that fit the start
    /// of the episode best. An open-loop simulation preselects candidates, and the filter chooses between
    /// them.
    fn initial_inner(&self, track: &Track) -> Option<[f64; MAX_INNER_STATES]> {
        let mut combinations = vec![[0.0; MAX_INNER_STATES]];
        for (k, inner) in self.inner.iter().enumerate() {
            let with = |combination: &[f64; MAX_INNER_STATES], start: f64| {
                let mut combination = *combination;
                combination[k] = start;
                combination
            };
            combinations =
                combinations.iter().flat_map(|o| inner.starts.iter().map(move |&s| with(o, s))).collect();
        }
        let Some(plain) = &self.plain else { return combinations.first().copied() };
        let contact = track.steps.first().map_or(0.0, |s| s.clock.t - s.clock.since_contact);
        let until = contact.max(track.start) + START_SELECTION_S;
        let mut ranked: Vec<_> = combinations
            .into_iter()
            .map(|combination| (self.open_loop_misfit(plain, track, &combination, until), combination))
            .collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let cost = |combination: &[f64; MAX_INNER_STATES]| {
            let mut cost = 0.0;
            let walked = self.walk(track, combination, until, |seen| cost += seen.cost);
            walked.map_or(f64::INFINITY, |()| cost)
        };
        let filtered = ranked
            .into_iter()
            .take(MAX_FILTERED_STARTS)
            .map(|(_, combination)| (cost(&combination), combination));
        filtered.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, combination)| combination)
    }

    /// Sum of squared pose errors of an open-loop simulation up to a time, in units of their noise.
    fn open_loop_misfit(
        &self,
        plain: &Plant<f64>,
        track: &Track,
        inner: &[f64; MAX_INNER_STATES],
        until: f64,
    ) -> f64 {
        let mut state = State { pose: track.pose.0, twist: track.twist.0, inner: *inner };
        let (mut t, mut sum) = (track.start, 0.0);
        for step in &track.steps {
            advance(plain, &mut state, &[0.0; 3], step, &track.curve);
            t += step.dt;
            if t > until {
                break;
            }
            let Some(seen) = step.pose else { continue };
            for k in (0..3).filter(|&k| self.pose_noise[k] > 0.0) {
                let error = seen[k] - state.pose[k];
                let error = if k == 2 { error - TAU * (error / TAU).round() } else { error };
                sum += error * error / self.pose_noise[k];
            }
        }
        if sum.is_finite() { sum } else { f64::INFINITY }
    }

    /// Propagates a belief by one step and returns the derivatives of the new state by the old one.
    fn predict(&self, belief: &mut Belief<N>, step: &Step, curve: &Curve) -> Matrix<N> {
        let variable = |k: usize| {
            // If the pose is not a variable, its index is outside the derivatives.
            Dual::<D>::variable(belief.mean[k], (k + D).wrapping_sub(N))
        };
        let mut state = State {
            pose: [variable(0), variable(1), variable(2)],
            twist: [variable(3), variable(4), variable(5)],
            inner: [Dual::zero(); MAX_INNER_STATES],
        };
        for (k, own) in state.inner.iter_mut().take(N - BASE_STATES).enumerate() {
            *own = variable(BASE_STATES + k);
        }
        let error = [variable(6), variable(7), variable(8)];
        advance(&self.plant, &mut state, &error, step, curve);
        let mut transition = Matrix::<N>::identity();
        let before = belief.mean;
        let rows = (0..MOTION_STATES).chain(BASE_STATES..N);
        for (row, value) in rows.zip(state.pose.iter().chain(&state.twist).chain(&state.inner)) {
            belief.mean[row] = value.re;
            for (column, slope) in transition.data.0[N - D..].iter_mut().zip(value.eps) {
                column[row] = slope;
            }
        }
        let noise = [0, 1, 2].map(|k| match self.dof[k] {
            true => self.reading_noise[k] * step.thinning + step.spread[k],
            false => 0.0,
        });
        if D < N {
            set_pose_derivatives(&mut transition, &before, &belief.mean);
            belief.covariance = propagated::<N, true>(&transition, &belief.covariance, noise);
        } else {
            belief.covariance = propagated::<N, false>(&transition, &belief.covariance, noise);
        }
        for (k, wander) in self.wander.iter().enumerate() {
            belief.covariance[(k + MOTION_STATES, k + MOTION_STATES)] += wander * step.dt;
        }
        transition
    }

    /// Innovation of the pose measured at the end of a step.
    fn observe(&self, belief: &Belief<N>, t: f64, seen: [f64; 3], step: &Step) -> Option<PoseInnovation<N>> {
        let timing = |k: usize| if self.dof[k] { step.timing_variance[k] } else { 0.0 };
        let noise = [0, 1, 2].map(|k| self.pose_noise[k] + timing(k));
        PoseInnovation::new(belief, t, seen, self.dof, noise)
    }

    fn update(&self, belief: &mut Belief<N>, seen: &PoseInnovation<N>) {
        belief.mean += seen.gain * seen.error;
        belief.covariance = corrected(&belief.covariance, &seen.gain, seen.noise);
    }
}

/// Sets the derivatives of a step by the pose for invariant motion. A translation of the start translates the
/// end. A rotation of the start with its velocity rotates the result: with `J` a quarter turn, `∂f/∂θ + ∂f/∂v
/// J v = J (f − p)`. The laws' own states do not rotate.
fn set_pose_derivatives<const N: usize>(transition: &mut Matrix<N>, before: &Vector<N>, after: &Vector<N>) {
    const HEADING: usize = 2;
    let (dx, dy) = (after[0] - before[0], after[1] - before[1]);
    let turn = [-dy, dx, 1.0, -after[4], after[3]];
    let columns = &mut transition.data.0;
    let (along_x, along_y) = (columns[3], columns[4]);
    for (row, slope) in
        columns[HEADING].iter_mut().enumerate().filter(|(row, _)| !(MOTION_STATES..BASE_STATES).contains(row))
    {
        let with = turn.get(row).copied().unwrap_or(0.0);
        *slope = with + along_x[row] * before[4] - along_y[row] * before[3];
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
