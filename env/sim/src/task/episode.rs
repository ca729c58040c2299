//! One episode of the task: the world, the gripper on it, and what the agent is told.

use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_model::{Clock, INNER, State};

use super::rules::*;
use super::{Hidden, Outcome};
use crate::gripper::wrap;
use crate::instruments::Scene;
use crate::{Coupling, Drive, Gripper, Instruments, Sensor, SimError, Snapshot, Tracker, World};

/// Streams of random numbers from an episode's seed; the first draws the world.
const RECORDED: u64 = 1;
const OBSERVED: u64 = 2;

/// Everything of an episode that changes or was drawn, but for the hidden wheel and the recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Saved {
    /// What moves.
    pub motion: [f64; 7],
    /// Goal pose.
    pub goal: [f64; 3],
    /// Grasp, object frame.
    pub grasp: [f64; 2],
    /// Wrench at the grasp.
    pub wrench: [f64; 3],
    /// Error of the tare.
    pub tare: [f64; 3],
    /// Simulation steps since contact.
    pub tick: u32,
    /// Whether it is over.
    pub ended: bool,
    /// Seed of the noise,
    pub seed: u64,
    /// and how far it has been used.
    pub used: u128,
}

/// The episode under way.
pub struct Episode {
    world: World,
    goal: [f64; 3],
    grasp: [f64; 2],
    tick: u32,
    wrench: [f64; 3],
    tare: [f64; 3],
    ended: bool,
    seed: u64,
    noise: ChaCha8Rng,
    sensor: Sensor,
    tracker: Tracker,
    twist_noise: [f64; 3],
    recorder: Option<Instruments>,
}

/// What an episode begins with.
pub struct Beginning {
    pub start: [f64; 3],
    pub goal: [f64; 3],
    pub grasp: [f64; 2],
    pub seed: u64,
    pub sensor: Sensor,
    pub tracker: Tracker,
    pub noise: f64,
}

impl Episode {
    pub fn new(hidden: &Hidden, from: Beginning, recording: bool) -> Result<Self, SimError> {
        let Beginning { start, goal, grasp, seed, sensor, tracker, noise: scale } = from;
        let mut world = World::new(&hidden.model()?, &[], DT)?;
        world.place(start);
        let recorder = recording.then(|| {
            let sensor = Sensor { offset: hidden.offset, ..sensor };
            Instruments::new(sensor, tracker, stream(seed, RECORDED))
        });
        let mut noise = stream(seed, OBSERVED);
        let samples = (sensor.rate * sensor.precontact).sqrt();
        let tare = blur([0.0; 3], sensor.noise().map(|sd| sd / samples), &mut noise);
        let (tick, wrench, ended) = (0, [0.0; 3], false);
        let twist_noise = TWIST_NOISE.map(|sd| sd * scale);
        let mut episode = Self {
            world,
            goal,
            grasp,
            tick,
            wrench,
            tare,
            ended,
            seed,
            noise,
            sensor,
            tracker,
            twist_noise,
            recorder,
        };
        episode.wait_for_contact();
        Ok(episode)
    }

    pub fn save(&self) -> Saved {
        Saved {
            motion: self.world.snapshot().0,
            goal: self.goal,
            grasp: self.grasp,
            wrench: self.wrench,
            tare: self.tare,
            tick: self.tick,
            ended: self.ended,
            seed: self.seed,
            used: self.noise.get_word_pos(),
        }
    }

    /// Put everything as it was saved.
    pub fn restore(&mut self, saved: &Saved) {
        self.world.restore(&Snapshot(saved.motion, [0.0; INNER]));
        self.wrench = saved.wrench;
        self.tare = saved.tare;
        self.tick = saved.tick;
        self.ended = saved.ended;
        self.noise.set_word_pos(saved.used);
    }

    pub fn ended(&self) -> bool {
        self.ended
    }

    pub fn recorder(&mut self) -> Option<&mut Instruments> {
        self.recorder.as_mut()
    }

    /// True poses of object, goal and gripper in the world, and the wrench at the grasp.
    pub fn view(&self) -> [[f64; 3]; 4] {
        let object = self.world.state().pose;
        [object, self.goal, self.gripper().pose(object), self.wrench]
    }

    /// Bring the wrench to `target` and hold it there for the rest of [`CONTROL`].
    pub fn push(&mut self, target: [f64; 3]) -> Outcome {
        let from = self.wrench;
        let at = |t: f64| {
            let share = (t / RISE).min(1.0);
            [0, 1, 2].map(|k| from[k] + share * (target[k] - from[k]))
        };
        for step in 0..STEPS {
            let (since_contact, t) = (f64::from(self.tick) * DT, f64::from(step) * DT);
            self.look(at(t), since_contact);
            let (mut gripper, state) = (self.gripper(), self.world.state());
            let mean = gripper.push(at(t + DT / 2.0), &state, self.world.rigid(), DT);
            self.world.step(mean, Clock::since_contact(since_contact));
            self.tick += 1;
        }
        self.wrench = target;
        let outcome = self.judge();
        self.ended = outcome.terminated;
        outcome
    }

    /// What the agent is told; entries as [`OBSERVATION`] says.
    pub fn observe(&mut self) -> [f64; OBSERVATION] {
        let State { pose, twist, .. } = self.world.state();
        let [x, y, theta] = blur(pose, self.tracker.noise, &mut self.noise);
        let [vx, vy, spin] = blur(twist, self.twist_noise, &mut self.noise);
        let [fx, fy, torque] = blur(self.wrench, self.sensor.noise(), &mut self.noise);
        let [bx, by, bz] = self.tare;
        let ([gx, gy, gtheta], [px, py]) = (self.goal, self.grasp);
        let ((sin, cos), (gsin, gcos)) = (theta.sin_cos(), gtheta.sin_cos());
        [x, y, cos, sin, vx, vy, spin, gx, gy, gcos, gsin, fx - bx, fy - by, torque - bz, px, py]
    }

    fn judge(&self) -> Outcome {
        let State { pose: [x, y, theta], twist: [vx, vy, spin], .. } = self.world.state();
        let [gx, gy, gtheta] = self.goal;
        let (distance, heading_error) = ((x - gx).hypot(y - gy), wrap(theta - gtheta));
        let speed = vx.hypot(vy);
        let lost = x.abs().max(y.abs()) > ARENA || speed > TOP_SPEED || spin.abs() > TOP_SPIN;
        let there = distance < REACH && heading_error.abs() < FACING && speed < STANDSTILL;
        let penalty = if lost { LOSS } else { 0.0 };
        let reward = -CONTROL * (distance + HEADING_COST * heading_error.abs()) - penalty;
        Outcome { reward, terminated: lost || there, success: there && !lost, distance, heading_error }
    }

    /// The recorder runs while nothing touches the object.
    fn wait_for_contact(&mut self) {
        let precontact = self.sensor.precontact;
        for tick in 0..(precontact / DT).round() as u32 {
            self.look([0.0; 3], f64::from(tick) * DT - precontact);
        }
    }

    fn look(&mut self, wrench: [f64; 3], since_contact: f64) {
        let Some(recorder) = &mut self.recorder else { return };
        let state = self.world.state();
        let mut gripper = hold(self.grasp, state.pose);
        recorder.observe(&Scene {
            t: self.sensor.precontact + since_contact,
            object: state.pose,
            gripper: gripper.pose(state.pose),
            wrench: gripper.push(wrench, &state, self.world.rigid(), DT),
            // Nothing that an agent meets reads the gripper's own inertia.
            accel: [0.0; 2],
            plant: self.world.plant(),
            clock: Clock::since_contact(since_contact),
        });
    }

    fn gripper(&self) -> Gripper {
        hold(self.grasp, self.world.state().pose)
    }
}

/// A gripper whose axes are the object's.
fn hold([x, y]: [f64; 2], object: [f64; 3]) -> Gripper {
    Gripper::new([x, y, 0.0], object, Drive::Force, Coupling::default())
}

fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number);
    random
}

fn blur(value: [f64; 3], sd: [f64; 3], random: &mut ChaCha8Rng) -> [f64; 3] {
    [0, 1, 2].map(|k| value[k] + sd[k] * random.sample::<f64, _>(StandardNormal).clamp(-CUT, CUT))
}
