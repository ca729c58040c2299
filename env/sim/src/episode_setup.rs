//! Simulation of one push, which is an episode of a recording.

use rand_chacha::ChaCha8Rng;
use trundle_model::{Axes, Clock, MAX_INNER_STATES, Model, ModelError, NotFinite, State};

use crate::end_effector::EndEffector;
use crate::gripper::relative;
use crate::instruments::{GroundTruth, Row};
use crate::{Coupling, HybridStepper, Instruments, Profile, Push, Sensor, SimError, Tracker};

/// Object, scene and instruments of an episode.
pub struct EpisodeSetup<'a> {
    /// The object with its hidden effects.
    pub model: &'a Model,
    /// Obstacles: simple polygons, world frame, m.
    pub obstacles: &'a [Vec<[f64; 2]>],
    /// Simulation step, s.
    pub step: f64,
    /// Coupling between gripper and object.
    pub coupling: Coupling,
    /// Wrist sensor.
    pub sensor: Sensor,
    /// Pose tracker.
    pub tracker: Tracker,
}

impl EpisodeSetup<'_> {
    /// Simulate a push as episode number `episode` (from 0) of a recording. Returns the samples of the instruments from the
    /// start of the pre-contact interval to the last knot.
    ///
    /// # Errors
    /// If the model is incomplete, the knots are invalid, or the motion is not finite.
    pub fn run(&self, episode: usize, push: &Push, noise: ChaCha8Rng) -> Result<Vec<Row>, SimError> {
        self.run_from(episode, push, [0.0; MAX_INNER_STATES], noise)
    }

    /// [`EpisodeSetup::run`] with initial values `inner` of the laws' internal states, such as a caster's angle.
    ///
    /// # Errors
    /// As [`EpisodeSetup::run`].
    pub fn run_from(
        &self,
        episode: usize,
        push: &Push,
        inner: [f64; MAX_INNER_STATES],
        noise: ChaCha8Rng,
    ) -> Result<Vec<Row>, SimError> {
        let profile = Profile::new("push.knots", push.knots.clone())?;
        self.require_simulated_discrepancy()?;
        let instrumented = self.model.resolved()?;
        let mut stepper = self.resting_stepper(push, inner)?;
        let body = &self.model.body;
        let mut end_effector = EndEffector::new(push, body, self.coupling)?;
        let mut instruments = Instruments::new(self.sensor, self.tracker, noise);
        let steps = |seconds: f64| (seconds / self.step).round() as u32;
        let contact = steps(self.sensor.precontact);
        let (mut last_wrench, mut last_velocity) = ([0.0; 3], [0.0; 2]);
        for tick in 0..=contact + steps(profile.end()) {
            let state = *stepper.state();
            let since_contact = (f64::from(tick) - f64::from(contact)) * self.step;
            let gripper_pose = end_effector.pose(state.pose);
            let [x, y, _] = relative(state.pose, gripper_pose);
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
                end_effector.step(command, f64::INFINITY, body, &stepper.rigid(clock), &state, self.step)
            } else {
                [0.0; 3]
            };
            stepper.step(wrench, clock, self.step)?;
            self.require_finite(stepper.state(), wrench, t)?;
            let next = end_effector.pose(stepper.state().pose);
            let velocity = [0, 1].map(|k| (next[k] - gripper_pose[k]) / self.step);
            instruments.observe(&GroundTruth {
                t,
                object: state.pose,
                gripper: gripper_pose,
                // Wrench and acceleration at this instant: averages over the previous and the next step.
                wrench: [0, 1, 2].map(|k| (last_wrench[k] + wrench[k]) / 2.0),
                accel: [0, 1].map(|k| (velocity[k] - last_velocity[k]) / self.step),
                plant: &instrumented,
                clock,
            });
            (last_wrench, last_velocity) = (wrench, velocity);
        }
        Ok(instruments.finish())
    }

    /// Refuse a model discrepancy that corrects readings.
    fn require_simulated_discrepancy(&self) -> Result<(), SimError> {
        if self.model.discrepancy.as_ref().is_some_and(|discrepancy| discrepancy.axes == Axes::Reading) {
            let remedy = "a simulation has no readings to correct: remove `[unnamed]`";
            return Err(SimError::value("unnamed.axes", "reading", remedy));
        }
        Ok(())
    }

    /// The stepper with the object at rest at the start of a push.
    fn resting_stepper(
        &self,
        push: &Push,
        inner: [f64; MAX_INNER_STATES],
    ) -> Result<HybridStepper, SimError> {
        let model = self.model.clone().without_instruments();
        let mut stepper = HybridStepper::new(model, self.obstacles.to_vec())?;
        stepper.precompute_step(self.step);
        stepper.set_state(State::at_rest(push.start).with_inner(inner));
        Ok(stepper)
    }

    /// Refuse a motion that is not finite, at time `t`.
    fn require_finite(&self, state: &State<f64>, wrench: [f64; 3], t: f64) -> Result<(), SimError> {
        if state.is_finite() && wrench.iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        Err(ModelError::NotFinite(NotFinite::of(self.model, t)).into())
    }
}
