//! Sensor and tracker together, each on its own clock, filling the rows of an episode.

use std::collections::BTreeMap;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_model::{Clock, Plant, to_body};
use trundle_record::Episode;

use crate::gripper::{relative, wrap};
use crate::sensor::{Felt, Line, Memory, lateness};
use crate::{Sensor, Tracker};

/// Samples are due on the step's grid; this forgives the rounding of a rate that is not.
const EARLY: f64 = 1e-9;

/// What is true at one time, for the instruments to look at.
pub struct Scene<'a> {
    /// Time of the recording, s.
    pub t: f64,
    /// Pose of the object frame in the world.
    pub object: [f64; 3],
    /// Pose of the gripper frame in the world.
    pub gripper: [f64; 3],
    /// Wrench on the object, object axes about the object origin.
    pub wrench: [f64; 3],
    /// Acceleration of the gripper's origin, world axes, m/s².
    pub accel: [f64; 2],
    /// The plant, whose instrument effects distort what is read and tracked.
    pub plant: &'a Plant<f64>,
    /// Time since contact.
    pub clock: Clock,
}

/// One row of an episode table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Time, s.
    pub t: f64,
    /// Pose of object and gripper in the world.
    pub poses: Option<[f64; 6]>,
    /// Reading, gripper axes.
    pub reading: Option<[f64; 3]>,
    /// What the other three axes of the sensor read: `force_z`, `torque_x`, `torque_y`.
    pub rest: Option<[f64; 3]>,
}

/// Sensor and tracker at work.
#[derive(Clone, Debug)]
pub struct Instruments {
    sensor: Sensor,
    tracker: Tracker,
    noise: ChaCha8Rng,
    readings: u32,
    poses: u32,
    line: Line,
    memory: Memory,
    rows: Vec<Row>,
}

impl Instruments {
    /// Instruments whose noise comes from `noise`.
    pub fn new(sensor: Sensor, tracker: Tracker, noise: ChaCha8Rng) -> Self {
        let (line, memory) = (Line::default(), Memory::default());
        Self { sensor, tracker, noise, readings: 0, poses: 0, line, memory, rows: vec![] }
    }

    /// Take the samples that are due.
    pub fn observe(&mut self, scene: &Scene) {
        let due = |count: u32, rate: f64| scene.t * rate >= f64::from(count) - EARLY;
        // Whole nanoseconds: a step count times the step is not a number that one would write down.
        let t = (scene.t * 1e9).round() / 1e9;
        let mut row = Row { t, poses: None, reading: None, rest: None };
        let reads = due(self.readings, self.sensor.rate);
        let delay = lateness(scene.plant, scene.clock);
        if reads {
            self.readings += 1;
            let noise = self.blur([0.0; 3], self.sensor.noise());
            self.line.ask(self.rows.len(), scene.t - delay, noise);
            let Sensor { force_noise, torque_noise, gripper, .. } = self.sensor;
            row.rest = gripper.map(|g| self.blur(g.reading(), [force_noise, torque_noise, torque_noise]));
        }
        if due(self.poses, self.tracker.rate) {
            self.poses += 1;
            row.poses = self.track(scene);
        }
        if reads || row.poses.is_some() {
            self.rows.push(row);
        }
        if reads || delay != 0.0 || scene.plant.has_memory() {
            let read = self.read(scene);
            for (row, reading) in self.line.tell(scene.t, read, delay) {
                if let Some(row) = self.rows.get_mut(row) {
                    row.reading = Some(reading);
                }
            }
        }
    }

    /// The rows since the last time, up to the first whose reading a clock that runs ahead has yet to tell.
    pub fn take(&mut self) -> Vec<Row> {
        let known = self.line.first().unwrap_or(self.rows.len());
        self.line.shift(known);
        whole(self.rows.drain(..known))
    }

    /// All rows since the last time; what is yet to be told is not in them.
    pub fn finish(&mut self) -> Vec<Row> {
        self.line.forget();
        whole(self.rows.drain(..))
    }

    /// Without noise.
    fn read(&mut self, scene: &Scene) -> [f64; 3] {
        let frame = relative(scene.object, scene.gripper);
        let [ax, ay, _] = to_body([scene.accel[0], scene.accel[1], 0.0], scene.gripper[2]);
        let felt = Felt { wrench: scene.wrench, frame, accel: [ax, ay] };
        self.memory.read(&self.sensor, &felt, scene.plant, scene.clock)
    }

    fn track(&mut self, scene: &Scene) -> Option<[f64; 6]> {
        let seen = self.noise.random::<f64>() >= self.tracker.drop_out;
        // Drawn even when lost, so that a drop-out does not change the noise of what follows.
        let [x, y, theta] = self.blur(self.tracker.sees(scene.object, scene.plant), self.tracker.noise);
        let [gx, gy, gtheta] = self.blur(scene.gripper, self.tracker.noise);
        seen.then_some([x, y, wrap(theta), gx, gy, wrap(gtheta)])
    }

    fn blur(&mut self, value: [f64; 3], sd: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| value[k] + sd[k] * self.noise.sample::<f64, _>(StandardNormal))
    }
}

/// Those that hold anything.
fn whole(rows: impl Iterator<Item = Row>) -> Vec<Row> {
    rows.filter(|row| row.reading.is_some() || row.poses.is_some()).collect()
}

/// The columns of a recording, poses first; the last three only of a sensor that has six axes.
pub const COLUMNS: [&str; 12] = [
    "object_x",
    "object_y",
    "object_theta",
    "gripper_x",
    "gripper_y",
    "gripper_theta",
    "force_x",
    "force_y",
    "torque_z",
    "force_z",
    "torque_x",
    "torque_y",
];

/// The rows as an episode of a recording.
pub fn episode(name: String, rows: &[Row]) -> Episode {
    let cell = |row: &Row, k: usize| match k {
        0..6 => row.poses.map(|p| p[k]),
        6..9 => row.reading.map(|r| r[k - 6]),
        _ => row.rest.filter(|_| row.reading.is_some()).map(|r| r[k - 9]),
    };
    let axes = if rows.iter().any(|row| row.rest.is_some()) { 12 } else { 9 };
    let column = |k: usize| rows.iter().map(|row| cell(row, k).unwrap_or(f64::NAN)).collect();
    let columns = COLUMNS.iter().take(axes).enumerate().map(|(k, name)| ((*name).to_owned(), column(k)));
    let t = rows.iter().map(|row| row.t).collect();
    Episode { name, t, columns: columns.collect(), notes: BTreeMap::new() }
}
