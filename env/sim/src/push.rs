//! One push from beginning to end: an episode.

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use trundle_model::{Axes, Clock, MAX_INNER_STATES, Model, ModelError, NotFinite, State};

use crate::gripper::relative;
use crate::hand::Hand;
use crate::instruments::{Row, Scene};
use crate::{Coupling, Drive, Instruments, Mover, Profile, Sensor, SimError, Tracker};

/// What is done to the object in one episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// Pose at which the object stands at rest, world frame, m and rad.
    #[serde(default)]
    pub start: [f64; 3],
    /// Where the gripper holds it: pose of the gripper in the object frame, m and rad; of a tip, on the rim and
    /// heading into the object.
    pub grasp: [f64; 3],
    /// What the knots mean.
    pub drive: Drive,
    /// The command: knots `[t, x, y, about z]`, t in s from contact on, straight lines between.
    pub knots: Vec<[f64; 4]>,
}

/// Everything but the push that an episode needs.
pub struct Setting<'a> {
    /// The object with its hidden effects.
    pub model: &'a Model,
    /// Simple polygons, world frame, m.
    pub obstacles: &'a [Vec<[f64; 2]>],
    /// Simulation step, s.
    pub step: f64,
    /// Between gripper and object.
    pub coupling: Coupling,
    /// Wrist sensor.
    pub sensor: Sensor,
    /// Pose tracker.
    pub tracker: Tracker,
}

impl Setting<'_> {
    /// Simulate a push, the recording's episode number `episode` from 0, and return what the instruments saw, from
    /// the start of the pre-contact interval to the last knot.
    ///
    /// # Errors
    /// When the model is not complete, the knots make no profile, or the motion is not finite.
    pub fn run(&self, episode: usize, push: &Push, noise: ChaCha8Rng) -> Result<Vec<Row>, SimError> {
        self.run_from(episode, push, [0.0; MAX_INNER_STATES], noise)
    }

    /// The same where the laws' own states, such as a caster's angle, start from `inner`.
    ///
    /// # Errors
    /// As [`Setting::run`].
    pub fn run_from(
        &self,
        episode: usize,
        push: &Push,
        inner: [f64; MAX_INNER_STATES],
        noise: ChaCha8Rng,
    ) -> Result<Vec<Row>, SimError> {
        let profile = Profile::new("push.knots", push.knots.clone())?;
        if self.model.discrepancy.as_ref().is_some_and(|discrepancy| discrepancy.axes == Axes::Reading) {
            let remedy = "only a recording has readings to correct: leave `[unnamed]` out to simulate";
            return Err(SimError::value("unnamed.axes", "reading", remedy));
        }
        let instrumented = self.model.resolved()?;
        let mut world = Mover::new(self.model.clone().without_instruments(), self.obstacles.to_vec())?;
        world.prepare(self.step);
        world.put(State::at_rest(push.start).with_inner(inner));
        let body = &self.model.body;
        let mut hand = Hand::new(push, body, self.coupling)?;
        let mut instruments = Instruments::new(self.sensor, self.tracker, noise);
        let steps = |seconds: f64| (seconds / self.step).round() as u32;
        let contact = steps(self.sensor.precontact);
        let (mut before, mut coming) = ([0.0; 3], [0.0; 2]);
        for tick in 0..=contact + steps(profile.end()) {
            let state = *world.state();
            let since_contact = (f64::from(tick) - f64::from(contact)) * self.step;
            let held_at = hand.pose(state.pose);
            let [x, y, _] = relative(state.pose, held_at);
            let t = f64::from(tick) * self.step;
            let clock = Clock {
                t: t + self.step / 2.0,
                dt: self.step,
                episode: episode as f64,
                grasp: [x, y],
                ..Clock::since_contact(since_contact)
            };
            let wrench = if clock.in_contact() {
                let command = profile.at(since_contact + self.step / 2.0);
                hand.push(command, f64::INFINITY, body, &world.rigid(clock), &state, self.step)
            } else {
                [0.0; 3]
            };
            world.step(wrench, clock, self.step)?;
            if !(world.state().is_finite() && wrench.iter().all(|value| value.is_finite())) {
                return Err(ModelError::NotFinite(NotFinite::of(self.model, t)).into());
            }
            let next = hand.pose(world.state().pose);
            let going = [0, 1].map(|k| (next[k] - held_at[k]) / self.step);
            instruments.observe(&Scene {
                t,
                object: state.pose,
                gripper: held_at,
                // Wrench and acceleration at this instant: between the means of the step before and the step after.
                wrench: [0, 1, 2].map(|k| (before[k] + wrench[k]) / 2.0),
                accel: [0, 1].map(|k| (going[k] - coming[k]) / self.step),
                plant: &instrumented,
                clock,
            });
            (before, coming) = (wrench, going);
        }
        Ok(instruments.finish())
    }
}
