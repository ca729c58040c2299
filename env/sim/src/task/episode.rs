//! One episode: the object, the arm on it, and what the agent is told.

use std::collections::VecDeque;
use std::sync::Arc;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use trundle_model::{Clock, Plant, Rigid, State, to_body};

use super::arm::Arm;
use super::hidden::Hidden;
use super::options::{Goal, Mode, Options};
use super::outcome::Outcome;
use super::room::{AHEAD, Progress, Room};
use super::rules::*;
use super::senses::{blur, sensor, stream, tracker};
use super::things::Thing;
use crate::gripper::wrap;
use crate::instruments::Scene;
use crate::mover::Motion;
use crate::sensor::{Felt, at_frame, lateness};
use crate::{Instruments, Mover, Sensor, SimError, Tracker};

/// Streams of random numbers from an episode's seed; the first draws the world.
const RECORDED: u64 = 1;
const OBSERVED: u64 = 2;

/// The episode under way.
#[derive(Clone)]
pub struct Episode {
    options: Arc<Options>,
    thing: Arc<Thing>,
    room: Arc<Room>,
    mover: Mover,
    /// The plant with what only instruments see, where there is any.
    instrumented: Option<Arc<Plant<f64>>>,
    progress: Option<Progress>,
    sensor: Sensor,
    tracker: Tracker,
    recorder: Option<Instruments>,
    now: Now,
}

/// What changes from step to step, but for the object and its progress along a path.
#[derive(Clone, Serialize, Deserialize)]
struct Now {
    arm: Arm,
    tick: u32,
    steps: u32,
    /// What the wrist feels, gripper axes, without noise.
    felt: [f64; 3],
    /// The same a while ago, where readings are late: the last is now.
    past: VecDeque<[f64; 3]>,
    tare: [f64; 3],
    /// The pose as last tracked.
    tracked: [f64; 3],
    ended: bool,
    noise: ChaCha8Rng,
    /// Mean wrench of the last step, object axes; for the recorder alone.
    before: [f64; 3],
    /// Velocity of the gripper in the last step, world axes, m/s.
    going: [f64; 2],
}

/// What of an episode changes.
#[derive(Serialize, Deserialize)]
pub struct Saved {
    motion: Motion,
    done: f64,
    now: Now,
}

impl Episode {
    /// Begin.
    ///
    /// # Errors
    /// When the model cannot be made a world.
    pub fn new(
        options: Arc<Options>,
        thing: Arc<Thing>,
        hidden: &Hidden,
        room: Room,
        grasp: [f64; 2],
        seed: u64,
        recording: bool,
    ) -> Result<Self, SimError> {
        let model = hidden.model(&thing.body);
        let whole = model.resolved()?;
        if whole.has_memory() {
            let remedy = "an environment's state holds no memory of readings: leave sensor_lag, drive_lag and sensor_play out";
            return Err(SimError::value("effects", "an instrument with a memory", remedy));
        }
        let instrumented = model.effects.len() != model.clone().without_instruments().effects.len();
        let mut mover = Mover::new(model.without_instruments(), room.obstacles.clone())?;
        mover.prepare(options.step);
        mover.put(State::at_rest(room.start).with_inner(hidden.inner));
        let (sensor, tracker) = (sensor(&options), tracker(&options));
        let recorder = recording.then(|| {
            let sensor = Sensor { offset: hidden.offset, ..sensor };
            Instruments::new(sensor, tracker, stream(seed, RECORDED))
        });
        let mut noise = stream(seed, OBSERVED);
        let samples = (sensor.rate * sensor.precontact).sqrt();
        let tare = blur([0.0; 3], sensor.noise().map(|sd| sd / samples), &mut noise);
        let progress = (options.task == Goal::Path).then(|| Progress::new(room.path.clone()));
        let now = Now {
            arm: Arm::new(&options, grasp, room.start),
            tick: 0,
            steps: 0,
            felt: [0.0; 3],
            past: VecDeque::new(),
            tare,
            tracked: room.start,
            ended: false,
            noise,
            before: [0.0; 3],
            going: [0.0; 2],
        };
        let mut episode = Self {
            options,
            thing,
            room: Arc::new(room),
            mover,
            instrumented: instrumented.then(|| Arc::new(whole)),
            progress,
            sensor,
            tracker,
            recorder,
            now,
        };
        episode.now.felt = episode.read([0.0; 3], &episode.held(), [0.0; 2], episode.clock(0.0));
        episode.wait_for_contact();
        Ok(episode)
    }

    /// All that changes.
    pub fn save(&self) -> Saved {
        let done = self.progress.as_ref().map_or(0.0, |p| p.done);
        Saved { motion: self.mover.save(), done, now: self.now.clone() }
    }

    /// Put everything as it was saved.
    ///
    /// # Errors
    /// As [`Episode::new`].
    pub fn load(&mut self, saved: Saved) -> Result<(), SimError> {
        self.mover.load(saved.motion)?;
        if let Some(progress) = &mut self.progress {
            progress.done = saved.done;
        }
        self.now = saved.now;
        Ok(())
    }

    /// Whether it is over.
    pub fn ended(&self) -> bool {
        self.now.ended
    }

    /// Whether the object's motion and what the wrist feels are finite.
    pub fn is_finite(&self) -> bool {
        self.mover.state().is_finite() && self.now.felt.iter().all(|value| value.is_finite())
    }

    /// Time since its beginning, s.
    pub fn seconds(&self) -> f64 {
        f64::from(self.now.tick) * self.options.step
    }

    /// Record no more.
    pub fn forget(&mut self) {
        self.recorder = None;
    }

    pub fn recorder(&mut self) -> Option<&mut Instruments> {
        self.recorder.as_mut()
    }

    pub fn room(&self) -> &Room {
        &self.room
    }

    pub fn arm(&self) -> &Arm {
        &self.now.arm
    }

    /// True poses of object, goal and gripper in the world, and the wrench at the gripper.
    pub fn view(&self) -> [[f64; 3]; 4] {
        let object = self.mover.state().pose;
        [object, self.target(), self.now.arm.pose(object), self.now.felt]
    }

    /// Act on the object until the next action is due.
    ///
    /// # Errors
    /// Never, as far as is known: see [`Mover::step`].
    pub fn step(&mut self, target: [f64; WIDEST]) -> Result<Outcome, SimError> {
        let (dt, ticks) = (self.options.step, self.options.ticks());
        let whole = f64::from(ticks) * dt;
        let jumps = self.now.arm.command(target, &self.thing, self.mover.state().pose);
        let holds = self.now.arm.holds();
        let (mut touched, mut sum, mut pressed) = (false, [0.0; 3], 0u32);
        for k in 0..ticks {
            let (since_contact, t) = (f64::from(self.now.tick) * dt, f64::from(k) * dt);
            let clock = self.clock(since_contact);
            let rigid = self.mover.rigid(clock);
            let reads = self.instrumented.is_some() || self.options.action == Mode::Push || k + 1 == ticks;
            // Where they are before the push: most steps nobody looks.
            let at = (reads || self.recorder.is_some()).then(|| self.held());
            let wrench = self.now.arm.push([t, whole, dt], &self.thing.body, &rigid, self.mover.state());
            let instant = self.now.arm.instant(t, whole);
            self.mover.step(wrench, clock, dt)?;
            if let Some(at) = at {
                let accel = self.accelerated(&at, jumps && k == 0);
                let shown = instant.unwrap_or([0, 1, 2].map(|k| (self.now.before[k] + wrench[k]) / 2.0));
                self.look(shown, &at, accel, clock);
                self.now.felt = self.read(wrench, &at, accel, clock);
            }
            self.now.before = wrench;
            touched |= self.mover.touching();
            self.now.tick += 1;
            if t < MOVING * whole {
                pressed += 1;
                sum = [0, 1, 2].map(|k| sum[k] + self.now.felt[k]);
            }
        }
        match self.options.action {
            // Once risen, the wrench is what was asked for, to the last bit.
            Mode::Wrench | Mode::Regrasp if holds && self.instrumented.is_none() => {
                self.now.felt = [0, 1, 2].map(|k| target[k]);
            }
            // After a push nothing touches: what is told is the mean of the push.
            Mode::Push => self.now.felt = sum.map(|s| s / f64::from(pressed.max(1))),
            _ => {}
        }
        self.now.steps += 1;
        let outcome = self.judge(touched);
        self.now.ended = outcome.terminated || outcome.truncated;
        Ok(outcome)
    }

    /// What the agent is told; entries as the environment's documentation says.
    pub fn observe(&mut self, told: &mut [f64]) {
        let State { pose, twist, .. } = *self.mover.state();
        let seen = self.instrumented.as_ref().map_or(pose, |plant| self.tracker.sees(pose, plant));
        let scale = self.options.noise;
        let pose = blur(seen, self.tracker.noise, &mut self.now.noise);
        if self.options.drop_out == 0.0 || self.now.noise.random::<f64>() >= self.options.drop_out {
            self.now.tracked = pose;
        }
        let [x, y, theta] = self.now.tracked;
        let [vx, vy, spin] = blur(twist, TWIST_NOISE.map(|sd| sd * scale), &mut self.now.noise);
        let [fx, fy, torque] = blur(self.now.felt, self.sensor.noise(), &mut self.now.noise);
        let [bx, by, bz] = self.now.tare;
        let ([gx, gy, gtheta], [px, py, _]) = (self.target(), self.now.arm.grasp);
        let ((sin, cos), (gsin, gcos)) = (theta.sin_cos(), gtheta.sin_cos());
        let common =
            [x, y, cos, sin, vx, vy, spin, gx, gy, gcos, gsin, fx - bx, fy - by, torque - bz, px, py];
        let bounded = common.into_iter().zip(BOUNDS).map(|(v, most)| v.clamp(-most, most));
        let mut entries = told.iter_mut();
        entries.by_ref().zip(bounded).for_each(|(entry, value)| *entry = value);
        self.describe(|value| {
            if let Some(entry) = entries.next() {
                *entry = value.clamp(-ROOM, ROOM);
            }
        });
    }

    /// What can be seen beside: the object's half sides where it may be any, and what the task is set in.
    fn describe(&self, mut tell: impl FnMut(f64)) {
        if self.options.varied() {
            let [low, high] = self.thing.body.bounds();
            tell((high[0] - low[0]) / 2.0);
            tell((high[1] - low[1]) / 2.0);
        }
        match &self.progress {
            Some(path) => {
                for ahead in [2.0 * AHEAD, 3.0 * AHEAD] {
                    let [x, y, _] = path.at(path.done + ahead);
                    tell(x);
                    tell(y);
                }
            }
            None => self.room.seen.iter().copied().for_each(tell),
        }
    }

    /// The pose to be reached now.
    fn target(&self) -> [f64; 3] {
        self.progress.as_ref().map_or(self.room.goal, |path| path.at(path.done + AHEAD))
    }

    fn judge(&mut self, touched: bool) -> Outcome {
        let State { pose, twist: [vx, vy, spin], .. } = *self.mover.state();
        let [x, y, theta] = pose;
        let away = |to: [f64; 3]| ((x - to[0]).hypot(y - to[1]), wrap(theta - to[2]));
        let (to_goal, facing) = away(self.room.goal);
        let (mut distance, mut heading_error, mut gained, mut progress) = (to_goal, facing, 0.0, 0.0);
        if let Some(path) = &mut self.progress {
            let before = path.done;
            distance = path.follow(pose);
            heading_error = wrap(theta - path.at(path.done)[2]);
            (gained, progress) = (path.done - before, path.done / path.length());
        }
        let Options { reach, facing: close, ends, horizon, .. } = *self.options;
        let speed = vx.hypot(vy);
        let inside = x.abs().max(y.abs()) <= ARENA && speed <= TOP_SPEED && spin.abs() <= TOP_SPIN;
        // Not a number is lost too.
        let lost = !inside;
        let success = !lost && to_goal < reach && facing.abs() < close && speed < STANDSTILL;
        let terminated = lost || (success && ends);
        let truncated = horizon > 0 && self.now.steps >= horizon && !terminated;
        let cost = distance + HEADING_COST * heading_error.abs() + if touched { TOUCH_COST } else { 0.0 };
        let reward = gained - self.options.control() * cost - if lost { LOSS } else { 0.0 };
        Outcome { reward, terminated, truncated, success, lost, touched, distance, heading_error, progress }
    }

    /// The recorder runs while nothing touches the object.
    fn wait_for_contact(&mut self) {
        let dt = self.options.step;
        for tick in 0..(self.sensor.precontact / dt).round() as u32 {
            if self.recorder.is_none() {
                return;
            }
            let clock = self.clock(f64::from(tick) * dt - self.sensor.precontact);
            let at = self.held();
            self.look([0.0; 3], &at, [0.0; 2], clock);
        }
    }

    fn clock(&self, since_contact: f64) -> Clock {
        let dt = self.options.step;
        let [x, y, _] = self.now.arm.grasp;
        Clock { t: since_contact + dt / 2.0, dt, grasp: [x, y], ..Clock::since_contact(since_contact) }
    }

    /// Where object and gripper are.
    fn held(&self) -> Held {
        let object = self.mover.state().pose;
        Held { object, gripper: self.now.arm.pose(object), frame: self.now.arm.frame(object) }
    }

    /// Acceleration of the gripper since it was `at` a place, world axes, m/s².
    fn accelerated(&mut self, at: &Held, jumps: bool) -> [f64; 2] {
        let dt = self.options.step;
        let next = self.now.arm.pose(self.mover.state().pose);
        let going = [0, 1].map(|k| (next[k] - at.gripper[k]) / dt);
        let coming = if jumps { going } else { self.now.going };
        self.now.going = going;
        [0, 1].map(|k| (going[k] - coming[k]) / dt)
    }

    /// What the wrist tells of a wrench on the object: with what its effects make of it, and late where one says so.
    fn read(&mut self, wrench: [f64; 3], at: &Held, accel: [f64; 2], clock: Clock) -> [f64; 3] {
        let Some(plant) = &self.instrumented else { return at_frame(wrench, at.frame) };
        let [ax, ay, _] = to_body([accel[0], accel[1], 0.0], at.gripper[2]);
        let felt = Felt { wrench, frame: at.frame, accel: [ax, ay] };
        let sensor = Sensor { offset: [0.0; 3], ..self.sensor };
        let read = sensor.reading(&felt, plant, clock);
        let late = (lateness(plant, clock).max(0.0) / self.options.step).round() as usize;
        self.now.past.push_back(read);
        while self.now.past.len() > late + 1 {
            self.now.past.pop_front();
        }
        self.now.past.front().copied().unwrap_or(read)
    }

    fn look(&mut self, wrench: [f64; 3], at: &Held, accel: [f64; 2], clock: Clock) {
        let Some(recorder) = &mut self.recorder else { return };
        let plant = self.instrumented.as_deref().unwrap_or(self.mover.plant());
        recorder.observe(&Scene {
            t: self.sensor.precontact + clock.since_contact,
            object: at.object,
            gripper: at.gripper,
            wrench,
            accel,
            plant,
            clock,
        });
    }

    /// What moves as one now.
    pub fn rigid(&self) -> Rigid<f64> {
        self.mover.rigid(self.clock(f64::from(self.now.tick) * self.options.step))
    }
}

/// Where object and gripper are at one time.
struct Held {
    object: [f64; 3],
    gripper: [f64; 3],
    /// Pose of the gripper in the object frame.
    frame: [f64; 3],
}
