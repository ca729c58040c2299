//! Sensor and tracker, each with its own clock, that fill the rows of an episode.

use std::collections::BTreeMap;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_model::{Clock, Plant, to_body};
use trundle_record::Episode;

use crate::gripper::{relative, wrap_angle};
use crate::sensor::{DelayLine, GripperLoad, SensorMemory, reading_delay};
use crate::{Sensor, Tracker};

/// Tolerance in samples within which a sample is due on the grid of simulation steps.
const SAMPLE_TOLERANCE: f64 = 1e-9;

/// True state at one time, as input of the instruments.
pub struct GroundTruth<'a> {
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
    /// The plant, whose instrument effects distort readings and poses.
    pub plant: &'a Plant<f64>,
    /// Clock of the laws.
    pub clock: Clock,
}

/// One row of an episode table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Time, s.
    pub t: f64,
    /// Poses of object and gripper in the world.
    pub poses: Option<[f64; 6]>,
    /// Planar reading of the sensor, gripper axes.
    pub reading: Option<[f64; 3]>,
    /// Readings of the other three axes: `force_z`, `torque_x`, `torque_y`.
    pub other_axes: Option<[f64; 3]>,
}

/// Sensor and tracker with their state during an episode.
#[derive(Clone, Debug)]
pub struct Instruments {
    sensor: Sensor,
    tracker: Tracker,
    noise: ChaCha8Rng,
    readings: u32,
    poses: u32,
    delay_line: DelayLine,
    memory: SensorMemory,
    rows: Vec<Row>,
}

impl Instruments {
    /// Instruments that draw their noise from `noise`.
    pub fn new(sensor: Sensor, tracker: Tracker, noise: ChaCha8Rng) -> Self {
        let (delay_line, memory) = (DelayLine::default(), SensorMemory::default());
        Self { sensor, tracker, noise, readings: 0, poses: 0, delay_line, memory, rows: vec![] }
    }

    /// Take the samples that are due.
    pub fn observe(&mut self, truth: &GroundTruth) {
        let due = |count: u32, rate: f64| truth.t * rate >= f64::from(count) - SAMPLE_TOLERANCE;
        // Round to nanoseconds: the step count times the step has rounding errors.
        let t = (truth.t * 1e9).round() / 1e9;
        let mut row = Row { t, poses: None, reading: None, other_axes: None };
        let reads = due(self.readings, self.sensor.rate);
        let delay = reading_delay(truth.plant, truth.clock);
        if reads {
            self.readings += 1;
            let noise = self.add_noise([0.0; 3], self.sensor.noise());
            self.delay_line.request(self.rows.len(), truth.t - delay, noise);
            let Sensor { force_noise, torque_noise, gripper, .. } = self.sensor;
            row.other_axes =
                gripper.map(|g| self.add_noise(g.reading(), [force_noise, torque_noise, torque_noise]));
        }
        if due(self.poses, self.tracker.rate) {
            self.poses += 1;
            row.poses = self.track(truth);
        }
        if reads || row.poses.is_some() {
            self.rows.push(row);
        }
        if reads || delay != 0.0 || truth.plant.has_memory() {
            let read = self.read(truth);
            for (row, reading) in self.delay_line.push(truth.t, read, delay) {
                if let Some(row) = self.rows.get_mut(row) {
                    row.reading = Some(reading);
                }
            }
        }
    }

    /// Rows since the last call, up to the first row that waits for a future reading.
    pub fn take_rows(&mut self) -> Vec<Row> {
        let complete = self.delay_line.first_pending_row().unwrap_or(self.rows.len());
        self.delay_line.drop_rows(complete);
        non_empty(self.rows.drain(..complete))
    }

    /// All rows since the last call, without pending readings.
    pub fn finish(&mut self) -> Vec<Row> {
        self.delay_line.clear();
        non_empty(self.rows.drain(..))
    }

    /// Reading without noise.
    fn read(&mut self, truth: &GroundTruth) -> [f64; 3] {
        let frame = relative(truth.object, truth.gripper);
        let [ax, ay, _] = to_body([truth.accel[0], truth.accel[1], 0.0], truth.gripper[2]);
        let load = GripperLoad { wrench: truth.wrench, frame, accel: [ax, ay] };
        self.memory.read(&self.sensor, &load, truth.plant, truth.clock)
    }

    fn track(&mut self, truth: &GroundTruth) -> Option<[f64; 6]> {
        let is_seen = self.noise.random::<f64>() >= self.tracker.drop_out;
        // Draw noise even for a lost sample, so that a drop-out does not change later noise.
        let [x, y, theta] =
            self.add_noise(self.tracker.tracked_pose(truth.object, truth.plant), self.tracker.noise);
        let [gx, gy, gtheta] = self.add_noise(truth.gripper, self.tracker.noise);
        is_seen.then_some([x, y, wrap_angle(theta), gx, gy, wrap_angle(gtheta)])
    }

    fn add_noise(&mut self, value: [f64; 3], sd: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| value[k] + sd[k] * self.noise.sample::<f64, _>(StandardNormal))
    }
}

/// Rows with a reading or a pose.
fn non_empty(rows: impl Iterator<Item = Row>) -> Vec<Row> {
    rows.filter(|row| row.reading.is_some() || row.poses.is_some()).collect()
}

/// Columns of a recording. Only sensors with six axes fill the last three.
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

/// An episode of a recording from its rows.
pub fn episode(name: String, rows: &[Row]) -> Episode {
    let cell = |row: &Row, k: usize| match k {
        0..6 => row.poses.map(|p| p[k]),
        6..9 => row.reading.map(|r| r[k - 6]),
        _ => row.other_axes.filter(|_| row.reading.is_some()).map(|r| r[k - 9]),
    };
    let axes = if rows.iter().any(|row| row.other_axes.is_some()) { 12 } else { 9 };
    let column = |k: usize| rows.iter().map(|row| cell(row, k).unwrap_or(f64::NAN)).collect();
    let columns = COLUMNS.iter().take(axes).enumerate().map(|(k, name)| ((*name).to_owned(), column(k)));
    let t = rows.iter().map(|row| row.t).collect();
    Episode { name, t, columns: columns.collect(), notes: BTreeMap::new() }
}
