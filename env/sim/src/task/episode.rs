//! One episode of a task: dynamics, actions, observations and rewards.

mod external;
mod instruments;
mod measurement;
mod observation;
mod scoring;

use std::collections::VecDeque;
use std::sync::Arc;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use trundle_model::{Plant, Rigid, State};

use super::action_mode::ActionMode;
use super::action_model::ActionModel;
use super::command_queue::CommandQueue;
use super::constants::*;
use super::hidden::HiddenEffects;
use super::measurement_delay::MeasurementDelay;
use super::options::{Options, TaskKind};
use super::outcome::Outcome;
use super::scene_layout::{PathProgress, SceneLayout};
use super::sensors::{add_noise, rng_stream, sensor, tracker};
use super::task_objects::TaskObject;
use crate::hybrid_stepper::SavedMotion;
use crate::{HybridStepper, Instruments, Sensor, SimError, Tracker};

/// Streams of random numbers from an episode's seed. Stream 0 draws the object.
const RECORDER_STREAM: u64 = 1;
const OBSERVATION_STREAM: u64 = 2;
const ARM_STREAM: u64 = 5;

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
    /// Commands that have not taken effect yet.
    commands: CommandQueue,
    /// Measurements that have not been observed yet, if the sensors are delayed.
    delayed: Option<MeasurementDelay>,
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
    /// Noise of the commands.
    command_noise: ChaCha8Rng,
    /// Time of contact with obstacles, s.
    contact_time: f64,
    /// Impulse of obstacles, N·s.
    contact_impulse: f64,
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

impl EpisodeState {
    /// The state at the start of an episode, with the error of the tare.
    fn new(options: &Options, sensor: &Sensor, start: [f64; 3], grasp: [f64; 2], seed: u64) -> Self {
        let mut noise = rng_stream(seed, OBSERVATION_STREAM);
        let samples = (sensor.rate * sensor.precontact).sqrt();
        let tare = add_noise([0.0; 3], sensor.noise().map(|sd| sd / samples), &mut noise);
        Self {
            action_model: ActionModel::new(options, grasp, start),
            commands: CommandQueue::with_capacity(queue_length(options)),
            delayed: MeasurementDelay::new(options),
            tick: 0,
            steps: 0,
            wrist_wrench: [0.0; 3],
            delayed_readings: VecDeque::new(),
            tare,
            tracked: start,
            ended: false,
            noise,
            command_noise: rng_stream(seed, ARM_STREAM),
            contact_time: 0.0,
            contact_impulse: 0.0,
            last_wrench: [0.0; 3],
            gripper_velocity: [0.0; 2],
        }
    }
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
        let obstacles = layout.obstacles.clone();
        let mut stepper =
            HybridStepper::with_contacts(model.without_instruments(), obstacles, options.contact_method())?;
        stepper.precompute_step(options.step);
        stepper.set_state(State::at_rest(layout.start).with_inner(hidden.inner));
        let (sensor, tracker) = (sensor(&options), tracker(&options));
        let recorder = recording.then(|| {
            let sensor = Sensor { offset: hidden.offset, ..sensor };
            Instruments::new(sensor, tracker, rng_stream(seed, RECORDER_STREAM))
        });
        let progress = (options.task == TaskKind::Path).then(|| PathProgress::new(layout.path.clone()));
        let state = EpisodeState::new(&options, &sensor, layout.start, grasp, seed);
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
        episode.store_measurement();
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

    /// Apply an action, decided after `thinking` s, until the next observation. The previous command acts meanwhile.
    ///
    /// # Errors
    /// As [`HybridStepper::step`].
    pub fn step(&mut self, target: [f64; MAX_ACTION_WIDTH], thinking: f64) -> Result<Outcome, SimError> {
        let (dt, ticks) = (self.options.step, self.options.substeps_per_action());
        let times = [f64::from(ticks) * dt, dt];
        let thinking_ticks = self.options.steps_in(thinking.clamp(0.0, MAX_DECISION_S));
        let periods = self.periods(thinking_ticks, ticks);
        let target = self.disturbed(target);
        let due = self.state.tick + thinking_ticks + self.options.steps_in(self.options.arm.delay);
        self.state.commands.push(due, target);
        let (mut sums, mut holds) = (StepSums::default(), false);
        for k in 0..periods * ticks {
            let is_discontinuous = self.receive_commands(times);
            if k == 0 {
                holds = self.state.action_model.is_holding();
            }
            let reads = self.instrumented.is_some()
                || self.options.action == ActionMode::Push
                || k + 1 == periods * ticks
                || self.measures_after(self.state.tick + 1);
            self.tick(times, reads, is_discontinuous, &mut sums)?;
        }
        match self.options.action {
            // After the ramp the wrench equals the command exactly.
            ActionMode::Wrench | ActionMode::Regrasp
                if holds
                    && self.instrumented.is_none()
                    && self.options.arm.is_ideal()
                    && thinking_ticks == 0 =>
            {
                self.state.wrist_wrench = [0, 1, 2].map(|k| target[k]);
            }
            // After a push there is no contact, so the observation is the mean over the push.
            ActionMode::Push => {
                self.state.wrist_wrench = sums.wrist.map(|s| s / f64::from(sums.pushing_ticks.max(1)));
            }
            _ => {}
        }
        self.state.steps += periods;
        let outcome = self.outcome(&sums, periods);
        self.state.ended = outcome.terminated || outcome.truncated;
        Ok(outcome)
    }

    /// Whole periods until the observation after a decision that takes `thinking_ticks`.
    fn periods(&self, thinking_ticks: u32, ticks: u32) -> u32 {
        let needed = thinking_ticks.div_ceil(ticks).max(1);
        match self.options.horizon {
            0 => needed,
            horizon => needed.min(horizon.saturating_sub(self.state.steps).max(1)),
        }
    }

    /// The command that an action becomes: with noise, and saturated.
    fn disturbed(&mut self, mut target: [f64; MAX_ACTION_WIDTH]) -> [f64; MAX_ACTION_WIDTH] {
        let (arm, full) = (&self.options.arm, self.options.action.full_scale());
        for (entry, full) in target.iter_mut().zip(full).take(3) {
            if arm.noise > 0.0 {
                let drawn: f64 = self.state.command_noise.sample(StandardNormal);
                *entry += arm.noise * full * drawn.clamp(-MAX_NOISE_SDS, MAX_NOISE_SDS);
            }
            if !arm.is_ideal() {
                *entry = entry.clamp(-arm.saturation * full, arm.saturation * full);
            }
        }
        target
    }

    /// Pass the commands that take effect now to the arm. Returns whether the velocity of the gripper is discontinuous.
    fn receive_commands(&mut self, times: [f64; 2]) -> bool {
        let mut is_discontinuous = false;
        while let Some(target) = self.state.commands.pop_due(self.state.tick) {
            let object = self.stepper.state();
            let model = &mut self.state.action_model;
            is_discontinuous |= model.set_command(target, times, &self.task_object, object);
        }
        is_discontinuous
    }

    /// Advance by one simulation step.
    fn tick(
        &mut self,
        times: [f64; 2],
        reads: bool,
        is_discontinuous: bool,
        sums: &mut StepSums,
    ) -> Result<(), SimError> {
        let [period, dt] = times;
        let clock = self.clock(f64::from(self.state.tick) * dt);
        let rigid = self.stepper.rigid(clock);
        let is_pushing = self.state.action_model.elapsed(dt) < PUSH_CONTACT_FRACTION * period;
        // Poses before the step, computed only if an instrument reads them.
        let poses = (reads || self.recorder.is_some()).then(|| self.poses());
        let instant = self.state.action_model.instant_wrench(times);
        let wrench =
            self.state.action_model.step(times, &self.task_object.body, &rigid, self.stepper.state());
        self.stepper.step(wrench, clock, dt)?;
        if let Some(poses) = poses {
            let recorded =
                instant.unwrap_or([0, 1, 2].map(|k| (self.state.last_wrench[k] + wrench[k]) / 2.0));
            self.read_instruments(&poses, [recorded, wrench], is_discontinuous, clock);
        }
        let impulse = self.stepper.is_touching().then(|| self.stepper.contact_impulse());
        if is_pushing {
            sums.pushing_ticks += 1;
            sums.wrist = [0, 1, 2].map(|k| sums.wrist[k] + self.state.wrist_wrench[k]);
        }
        self.end_tick(wrench, impulse, sums);
        Ok(())
    }

    /// Add a simulation step to the sums of the action: the mean wrench of the gripper, and the impulse of obstacles in
    /// contact.
    fn end_tick(&mut self, wrench: [f64; 3], impulse: Option<f64>, sums: &mut StepSums) {
        self.state.last_wrench = wrench;
        sums.effort += effort(wrench, self.state.action_model.grasp);
        if let Some(impulse) = impulse {
            // Version 0 counts every step within 2 cm of an obstacle.
            sums.touching_ticks += u32::from(self.options.version == 0 || impulse > 0.0);
            self.state.contact_impulse += impulse;
        }
        self.state.tick += 1;
        self.store_measurement();
    }

    /// Current mass properties.
    pub fn rigid(&self) -> Rigid<f64> {
        self.stepper.rigid(self.clock(f64::from(self.state.tick) * self.options.step))
    }
}

/// Sums over the simulation steps of an action.
#[derive(Default)]
struct StepSums {
    touching_ticks: u32,
    effort: f64,
    /// Readings of the wrist during a push, and their number.
    wrist: [f64; 3],
    pushing_ticks: u32,
}

/// Squared wrench about the grasp as a fraction of the full one. `wrench` is in object axes about the object origin.
fn effort([fx, fy, torque]: [f64; 3], [x, y, _]: [f64; 3]) -> f64 {
    let [full, _, full_torque] = FULL_WRENCH;
    let about_grasp = (torque - (x * fy - y * fx)) / full_torque;
    (fx * fx + fy * fy) / (full * full) + about_grasp * about_grasp
}

/// Largest number of commands on their way.
fn queue_length(options: &Options) -> usize {
    let delay = options.arm.delay + options.decision_time;
    (delay / options.control_period()).ceil() as usize + 2
}
