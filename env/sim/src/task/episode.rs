//! One episode of a task: dynamics, actions, observations and rewards.

mod observation;

use std::collections::VecDeque;
use std::sync::Arc;

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use trundle_model::{Clock, Plant, Rigid, State, to_body};

use super::action_model::ActionModel;
use super::constants::*;
use super::hidden::HiddenEffects;
use super::options::{ActionMode, Options, TaskKind};
use super::outcome::Outcome;
use super::scene_layout::{PATH_LOOKAHEAD_M, PathProgress, SceneLayout};
use super::sensors::{add_noise, rng_stream, sensor, tracker};
use super::task_objects::TaskObject;
use crate::gripper::wrap_angle;
use crate::hybrid_stepper::SavedMotion;
use crate::instruments::GroundTruth;
use crate::sensor::{GripperLoad, reading_delay, wrench_in_frame};
use crate::{HybridStepper, Instruments, Sensor, SimError, Tracker};

/// Streams of random numbers from an episode's seed. Stream 0 draws the object.
const RECORDER_STREAM: u64 = 1;
const OBSERVATION_STREAM: u64 = 2;

/// A running episode.
#[derive(Clone)]
pub struct Episode {
    options: Arc<Options>,
    task_object: Arc<TaskObject>,
    layout: Arc<SceneLayout>,
    stepper: HybridStepper,
    /// Plant with instrument effects, if there are any.
    instrumented: Option<Arc<Plant<f64>>>,
    progress: Option<PathProgress>,
    sensor: Sensor,
    tracker: Tracker,
    recorder: Option<Instruments>,
    state: EpisodeState,
}

/// State of an episode apart from the object's motion and the progress along a path.
#[derive(Clone, Serialize, Deserialize)]
struct EpisodeState {
    action_model: ActionModel,
    tick: u32,
    steps: u32,
    /// Wrench at the wrist without noise, gripper axes.
    wrist_wrench: [f64; 3],
    /// Past readings for a delayed sensor, oldest first.
    delayed_readings: VecDeque<[f64; 3]>,
    tare: [f64; 3],
    /// Last tracked pose.
    tracked: [f64; 3],
    ended: bool,
    noise: ChaCha8Rng,
    /// Mean wrench of the last step, object axes, for the recorder.
    last_wrench: [f64; 3],
    /// Velocity of the gripper in the last step, world axes, m/s.
    gripper_velocity: [f64; 2],
}

/// Saved state of an episode.
#[derive(Serialize, Deserialize)]
pub struct Saved {
    motion: SavedMotion,
    arc_length: f64,
    state: EpisodeState,
}

impl Episode {
    /// Start an episode.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn new(
        options: Arc<Options>,
        task_object: Arc<TaskObject>,
        hidden: &HiddenEffects,
        layout: SceneLayout,
        grasp: [f64; 2],
        seed: u64,
        recording: bool,
    ) -> Result<Self, SimError> {
        let model = hidden.model(&task_object.body);
        let instrumented_plant = model.resolved()?;
        if instrumented_plant.has_memory() {
            let remedy = "environments do not support instruments with memory: remove sensor_lag, drive_lag and sensor_play";
            return Err(SimError::value("effects", "an instrument with a memory", remedy));
        }
        let is_instrumented = model.effects.len() != model.clone().without_instruments().effects.len();
        let mut stepper = HybridStepper::new(model.without_instruments(), layout.obstacles.clone())?;
        stepper.precompute_step(options.step);
        stepper.set_state(State::at_rest(layout.start).with_inner(hidden.inner));
        let (sensor, tracker) = (sensor(&options), tracker(&options));
        let recorder = recording.then(|| {
            let sensor = Sensor { offset: hidden.offset, ..sensor };
            Instruments::new(sensor, tracker, rng_stream(seed, RECORDER_STREAM))
        });
        let mut noise = rng_stream(seed, OBSERVATION_STREAM);
        let samples = (sensor.rate * sensor.precontact).sqrt();
        let tare = add_noise([0.0; 3], sensor.noise().map(|sd| sd / samples), &mut noise);
        let progress = (options.task == TaskKind::Path).then(|| PathProgress::new(layout.path.clone()));
        let state = EpisodeState {
            action_model: ActionModel::new(&options, grasp, layout.start),
            tick: 0,
            steps: 0,
            wrist_wrench: [0.0; 3],
            delayed_readings: VecDeque::new(),
            tare,
            tracked: layout.start,
            ended: false,
            noise,
            last_wrench: [0.0; 3],
            gripper_velocity: [0.0; 2],
        };
        let mut episode = Self {
            options,
            task_object,
            layout: Arc::new(layout),
            stepper,
            instrumented: is_instrumented.then(|| Arc::new(instrumented_plant)),
            progress,
            sensor,
            tracker,
            recorder,
            state,
        };
        episode.state.wrist_wrench =
            episode.wrist_reading([0.0; 3], &episode.poses(), [0.0; 2], episode.clock(0.0));
        episode.wait_for_contact();
        Ok(episode)
    }

    /// The complete state.
    pub fn save(&self) -> Saved {
        let arc_length = self.progress.as_ref().map_or(0.0, |p| p.arc_length);
        Saved { motion: self.stepper.save(), arc_length, state: self.state.clone() }
    }

    /// Restore a saved state.
    ///
    /// # Errors
    /// As [`Episode::new`].
    pub fn load(&mut self, saved: Saved) -> Result<(), SimError> {
        self.stepper.load(saved.motion)?;
        if let Some(progress) = &mut self.progress {
            progress.arc_length = saved.arc_length;
        }
        self.state = saved.state;
        Ok(())
    }

    /// Whether the episode has ended.
    pub fn ended(&self) -> bool {
        self.state.ended
    }

    /// Whether the object's motion and the wrist wrench are finite.
    pub fn is_finite(&self) -> bool {
        self.stepper.state().is_finite() && self.state.wrist_wrench.iter().all(|value| value.is_finite())
    }

    /// Time since the start, s.
    pub fn seconds(&self) -> f64 {
        f64::from(self.state.tick) * self.options.step
    }

    /// Stop recording.
    pub fn stop_recording(&mut self) {
        self.recorder = None;
    }

    pub fn recorder(&mut self) -> Option<&mut Instruments> {
        self.recorder.as_mut()
    }

    pub fn layout(&self) -> &SceneLayout {
        &self.layout
    }

    pub fn action_model(&self) -> &ActionModel {
        &self.state.action_model
    }

    /// True poses of object, goal and gripper in the world, and the wrench at the gripper.
    pub fn view(&self) -> [[f64; 3]; 4] {
        let object = self.stepper.state().pose;
        [object, self.target(), self.state.action_model.pose(object), self.state.wrist_wrench]
    }

    /// Apply an action until the next one is due.
    ///
    /// # Errors
    /// As [`HybridStepper::step`].
    pub fn step(&mut self, target: [f64; MAX_ACTION_WIDTH]) -> Result<Outcome, SimError> {
        let (dt, ticks) = (self.options.step, self.options.substeps_per_action());
        let period = f64::from(ticks) * dt;
        let is_discontinuous =
            self.state.action_model.set_command(target, &self.task_object, self.stepper.state().pose);
        let holds = self.state.action_model.is_holding();
        let (mut touched, mut sum, mut contact_ticks) = (false, [0.0; 3], 0u32);
        for k in 0..ticks {
            let (since_contact, t) = (f64::from(self.state.tick) * dt, f64::from(k) * dt);
            let clock = self.clock(since_contact);
            let rigid = self.stepper.rigid(clock);
            let reads =
                self.instrumented.is_some() || self.options.action == ActionMode::Push || k + 1 == ticks;
            // Poses before the step, computed only if an instrument reads them.
            let poses = (reads || self.recorder.is_some()).then(|| self.poses());
            let wrench = self.state.action_model.step(
                [t, period, dt],
                &self.task_object.body,
                &rigid,
                self.stepper.state(),
            );
            let instant = self.state.action_model.instant_wrench(t, period);
            self.stepper.step(wrench, clock, dt)?;
            if let Some(poses) = poses {
                let accel = self.gripper_acceleration(&poses, is_discontinuous && k == 0);
                let recorded =
                    instant.unwrap_or([0, 1, 2].map(|k| (self.state.last_wrench[k] + wrench[k]) / 2.0));
                self.record(recorded, &poses, accel, clock);
                self.state.wrist_wrench = self.wrist_reading(wrench, &poses, accel, clock);
            }
            self.state.last_wrench = wrench;
            touched |= self.stepper.is_touching();
            self.state.tick += 1;
            if t < PUSH_CONTACT_FRACTION * period {
                contact_ticks += 1;
                sum = [0, 1, 2].map(|k| sum[k] + self.state.wrist_wrench[k]);
            }
        }
        match self.options.action {
            // After the ramp the wrench equals the command exactly.
            ActionMode::Wrench | ActionMode::Regrasp if holds && self.instrumented.is_none() => {
                self.state.wrist_wrench = [0, 1, 2].map(|k| target[k]);
            }
            // After a push there is no contact, so the observation is the mean over the push.
            ActionMode::Push => self.state.wrist_wrench = sum.map(|s| s / f64::from(contact_ticks.max(1))),
            _ => {}
        }
        self.state.steps += 1;
        let outcome = self.outcome(touched);
        self.state.ended = outcome.terminated || outcome.truncated;
        Ok(outcome)
    }

    /// Current target pose.
    fn target(&self) -> [f64; 3] {
        self.progress
            .as_ref()
            .map_or(self.layout.goal, |path| path.pose_at(path.arc_length + PATH_LOOKAHEAD_M))
    }

    fn outcome(&mut self, touched: bool) -> Outcome {
        let State { pose, twist: [vx, vy, spin], .. } = *self.stepper.state();
        let [x, y, theta] = pose;
        let away = |to: [f64; 3]| ((x - to[0]).hypot(y - to[1]), wrap_angle(theta - to[2]));
        let (goal_distance, facing) = away(self.layout.goal);
        let (mut distance, mut heading_error, mut path_gain, mut progress) =
            (goal_distance, facing, 0.0, 0.0);
        if let Some(path) = &mut self.progress {
            let before = path.arc_length;
            distance = path.advance_to(pose);
            heading_error = wrap_angle(theta - path.pose_at(path.arc_length)[2]);
            (path_gain, progress) = (path.arc_length - before, path.arc_length / path.length());
        }
        let Options { reach, facing: max_heading_error, ends, horizon, .. } = *self.options;
        let speed = vx.hypot(vy);
        let inside = x.abs().max(y.abs()) <= ARENA_HALF_SIDE_M
            && speed <= MAX_SPEED_M_PER_S
            && spin.abs() <= MAX_SPIN_RAD_PER_S;
        // NaN counts as outside.
        let lost = !inside;
        let success = !lost
            && goal_distance < reach
            && facing.abs() < max_heading_error
            && speed < MAX_GOAL_SPEED_M_PER_S;
        let terminated = lost || (success && ends);
        let truncated = horizon > 0 && self.state.steps >= horizon && !terminated;
        let cost = distance
            + HEADING_COST_M_PER_RAD * heading_error.abs()
            + if touched { CONTACT_COST_M } else { 0.0 };
        let reward = path_gain - self.options.control_period() * cost - if lost { FAILURE_COST } else { 0.0 };
        Outcome { reward, terminated, truncated, success, lost, touched, distance, heading_error, progress }
    }

    /// Record the pre-contact interval.
    fn wait_for_contact(&mut self) {
        let dt = self.options.step;
        for tick in 0..(self.sensor.precontact / dt).round() as u32 {
            if self.recorder.is_none() {
                return;
            }
            let clock = self.clock(f64::from(tick) * dt - self.sensor.precontact);
            let poses = self.poses();
            self.record([0.0; 3], &poses, [0.0; 2], clock);
        }
    }

    fn clock(&self, since_contact: f64) -> Clock {
        let dt = self.options.step;
        let [x, y, _] = self.state.action_model.grasp;
        Clock { t: since_contact + dt / 2.0, dt, grasp: [x, y], ..Clock::since_contact(since_contact) }
    }

    /// Current poses of object and gripper.
    fn poses(&self) -> Poses {
        let object = self.stepper.state().pose;
        Poses {
            object,
            gripper: self.state.action_model.pose(object),
            frame: self.state.action_model.frame(object),
        }
    }

    /// Acceleration of the gripper in the step from `poses`, world axes, m/s².
    fn gripper_acceleration(&mut self, poses: &Poses, is_discontinuous: bool) -> [f64; 2] {
        let dt = self.options.step;
        let next = self.state.action_model.pose(self.stepper.state().pose);
        let velocity = [0, 1].map(|k| (next[k] - poses.gripper[k]) / dt);
        let last_velocity = if is_discontinuous { velocity } else { self.state.gripper_velocity };
        self.state.gripper_velocity = velocity;
        [0, 1].map(|k| (velocity[k] - last_velocity[k]) / dt)
    }

    /// Reading of the wrist sensor for a wrench on the object, with instrument effects and delay.
    fn wrist_reading(&mut self, wrench: [f64; 3], poses: &Poses, accel: [f64; 2], clock: Clock) -> [f64; 3] {
        let Some(plant) = &self.instrumented else { return wrench_in_frame(wrench, poses.frame) };
        let [ax, ay, _] = to_body([accel[0], accel[1], 0.0], poses.gripper[2]);
        let load = GripperLoad { wrench, frame: poses.frame, accel: [ax, ay] };
        let sensor = Sensor { offset: [0.0; 3], ..self.sensor };
        let read = sensor.reading(&load, plant, clock);
        let delay_steps = (reading_delay(plant, clock).max(0.0) / self.options.step).round() as usize;
        self.state.delayed_readings.push_back(read);
        while self.state.delayed_readings.len() > delay_steps + 1 {
            self.state.delayed_readings.pop_front();
        }
        self.state.delayed_readings.front().copied().unwrap_or(read)
    }

    fn record(&mut self, wrench: [f64; 3], poses: &Poses, accel: [f64; 2], clock: Clock) {
        let Some(recorder) = &mut self.recorder else { return };
        let plant = self.instrumented.as_deref().unwrap_or(self.stepper.plant());
        recorder.observe(&GroundTruth {
            t: self.sensor.precontact + clock.since_contact,
            object: poses.object,
            gripper: poses.gripper,
            wrench,
            accel,
            plant,
            clock,
        });
    }

    /// Current mass properties.
    pub fn rigid(&self) -> Rigid<f64> {
        self.stepper.rigid(self.clock(f64::from(self.state.tick) * self.options.step))
    }
}

/// Poses of object and gripper at one time.
struct Poses {
    object: [f64; 3],
    gripper: [f64; 3],
    /// Pose of the gripper in the object frame.
    frame: [f64; 3],
}
