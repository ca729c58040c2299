//! The wrist force-torque sensor.

use std::collections::VecDeque;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use trundle_model::{Clock, Lags, Plant};

use crate::SimError;

/// Times that differ by less are the same, s.
const EARLY: f64 = 1e-9;

/// A planar force-torque sensor between gripper and arm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sensor {
    /// Samples per second.
    pub rate: f64,
    /// Standard deviation of each force axis, N.
    pub force_noise: f64,
    /// Standard deviation of the torque, N·m.
    pub torque_noise: f64,
    /// What it reads without load, constant in its own frame, `[N, N, N·m]`.
    pub offset: [f64; 3],
    /// Time without contact at the start of an episode, from which the offset can be taken, s.
    pub precontact: f64,
    /// What hangs between sensor and object; then all six axes are recorded.
    pub gripper: Option<Hanging>,
}

/// A level gripper that hangs on the sensor: what the axes read that a planar world does not know.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hanging {
    /// kg.
    pub mass: f64,
    /// Its mass centre, sensor frame, m.
    #[serde(default)]
    pub com: [f64; 3],
    /// What `force_z`, `torque_x` and `torque_y` read without load, `[N, N·m, N·m]`.
    #[serde(default)]
    pub offset: [f64; 3],
}

/// m/s².
const GRAVITY: f64 = 9.80665;

impl Hanging {
    /// What `force_z`, `torque_x` and `torque_y` read, without noise: the arm holds the gripper up, and what the arm
    /// does is read as if it were done to the object.
    pub fn reading(&self) -> [f64; 3] {
        let weight = self.mass * GRAVITY;
        let [x, y, _] = self.com;
        [self.offset[0] + weight, self.offset[1] + weight * y, self.offset[2] - weight * x]
    }
}

impl Default for Sensor {
    fn default() -> Self {
        Self {
            rate: 125.0,
            force_noise: 0.4,
            torque_noise: 0.05,
            offset: [0.0; 3],
            precontact: 0.4,
            gripper: None,
        }
    }
}

impl Sensor {
    /// Refuse what cannot be.
    ///
    /// # Errors
    /// When a rate is not positive or a noise negative.
    pub fn check(&self) -> Result<(), SimError> {
        check_rate("sensor.rate", self.rate)?;
        check_noise("sensor.force_noise", self.force_noise)?;
        check_noise("sensor.torque_noise", self.torque_noise)?;
        check_noise("sensor.precontact", self.precontact)?;
        if let Some(Hanging { mass, com, offset }) = &self.gripper {
            check_noise("sensor.gripper.mass", *mass)?;
            if let Some(value) = com.iter().chain(offset).find(|v| !v.is_finite()) {
                return Err(SimError::value("sensor.gripper", value, "must be finite (m; N, N·m, N·m)"));
            }
        }
        match self.offset.iter().find(|v| !v.is_finite()) {
            Some(value) => Err(SimError::value("sensor.offset", value, "must be finite (N, N, N·m)")),
            None => Ok(()),
        }
    }

    /// One standard deviation of each axis.
    pub fn noise(&self) -> [f64; 3] {
        [self.force_noise, self.force_noise, self.torque_noise]
    }

    /// What it reads at that moment, without noise: gripper axes about the gripper's origin.
    pub fn reading(&self, felt: &Felt, plant: &Plant<f64>, clock: Clock) -> [f64; 3] {
        let [fx, fy, torque] = at_frame(felt.wrench, felt.frame);
        let own = plant.rigid(clock).mass - plant.object(clock).mass;
        let [ax, ay] = felt.accel;
        let read = distort([fx + own * ax, fy + own * ay, torque], plant, clock);
        [0, 1, 2].map(|k| read[k] + self.offset[k])
    }
}

/// What acts at the gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Felt {
    /// Wrench on the object, object axes about the object origin, `[N, N, N·m]`.
    pub wrench: [f64; 3],
    /// Pose of the gripper in the object frame, m and rad.
    pub frame: [f64; 3],
    /// Acceleration of the gripper's origin, gripper axes, m/s²: what instruments say that the gripper weighs
    /// sits there.
    pub accel: [f64; 2],
}

/// Readings between sensor and recording: some arrive late, and a clock that runs ahead tells of what is yet to come.
#[derive(Clone, Debug, Default)]
pub(crate) struct Line {
    /// Times and readings that may still be asked for.
    past: VecDeque<(f64, [f64; 3])>,
    waiting: VecDeque<Waiting>,
}

/// A sample that is due.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    row: usize,
    /// Time of the reading that it holds, s.
    of: f64,
    noise: [f64; 3],
}

impl Line {
    /// Await the reading of a time for a row.
    pub fn ask(&mut self, row: usize, of: f64, noise: [f64; 3]) {
        self.waiting.push_back(Waiting { row, of, noise });
    }

    /// What is read at `t`, when `delay` is the line's; the rows that this answers.
    pub fn tell(&mut self, t: f64, reading: [f64; 3], delay: f64) -> Vec<(usize, [f64; 3])> {
        self.past.push_back((t, reading));
        let mut answers = vec![];
        while let Some(&Waiting { row, of, noise }) = self.waiting.front().filter(|w| w.of <= t + EARLY) {
            let clean = self.at(of);
            answers.push((row, [0, 1, 2].map(|k| clean[k] + noise[k])));
            self.waiting.pop_front();
        }
        let needed = self.waiting.front().map_or(t - delay, |w| w.of.min(t - delay));
        while self.past.get(1).is_some_and(|(t, _)| *t <= needed) {
            self.past.pop_front();
        }
        answers
    }

    /// The first row that awaits a reading.
    pub fn first(&self) -> Option<usize> {
        self.waiting.front().map(|waiting| waiting.row)
    }

    /// So many rows are gone.
    pub fn shift(&mut self, rows: usize) {
        self.waiting.iter_mut().for_each(|waiting| waiting.row -= rows);
    }

    /// Await nothing any more.
    pub fn forget(&mut self) {
        self.waiting.clear();
    }

    /// The reading at a time: straight between two, and before the first the first.
    fn at(&self, t: f64) -> [f64; 3] {
        let after = self.past.partition_point(|(before, _)| *before <= t + EARLY);
        let (Some(&(a, low)), next) = (self.past.get(after.max(1) - 1), self.past.get(after)) else {
            return [0.0; 3];
        };
        match next {
            Some(&(b, high)) if after > 0 => {
                let share = ((t - a) / (b - a)).clamp(0.0, 1.0);
                [0, 1, 2].map(|k| low[k] + share * (high[k] - low[k]))
            }
            _ => low,
        }
    }
}

/// A wrench in object axes about the object origin, in the axes and about the origin of `frame`.
pub(crate) fn at_frame([fx, fy, torque]: [f64; 3], [x, y, angle]: [f64; 3]) -> [f64; 3] {
    trundle_model::to_body([fx, fy, torque - (x * fy - y * fx)], angle)
}

/// What a sensor remembers of the past.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Memory {
    load: Follower,
    reading: Follower,
}

/// A load that is followed: with lags of first order, and by how fast it changes.
#[derive(Clone, Copy, Debug, Default)]
struct Follower {
    /// Time, load and lagged load, `[N, N, N·m]`.
    last: Option<(f64, [f64; 3], [f64; 3])>,
}

impl Memory {
    /// What a sensor reads at a moment, without noise, with what it remembers.
    pub fn read(&mut self, sensor: &Sensor, felt: &Felt, plant: &Plant<f64>, clock: Clock) -> [f64; 3] {
        // Only what plays looks at the trend, and only at its direction: that of the load is that of the reading.
        let (_, trend) = self.load.follow(clock.t, at_frame(felt.wrench, felt.frame), None);
        let read = sensor.reading(felt, plant, Clock { trend, ..clock });
        self.reading.follow(clock.t, read, plant.lags()).0
    }
}

impl Follower {
    /// What is recorded at a time of a load, where it or its reading lags; 1/s, how fast the load changes.
    pub fn follow(&mut self, t: f64, load: [f64; 3], lags: Option<Lags<f64>>) -> ([f64; 3], [f64; 3]) {
        let Lags { sensor, drive } = lags.unwrap_or(Lags { sensor: 0.0, drive: 0.0 });
        let (before, was, lagged) = self.last.unwrap_or((t, load, load));
        let dt = t - before;
        let trend = if dt > EARLY { [0, 1, 2].map(|k| (load[k] - was[k]) / dt) } else { [0.0; 3] };
        let kept = if sensor > 0.0 { (-dt / sensor).exp() } else { 0.0 };
        // The load between two times is their mean.
        let follow = |k: usize| {
            let driven = if sensor > 0.0 { (load[k] + was[k]) / 2.0 } else { load[k] };
            driven + (lagged[k] - driven) * kept
        };
        let lagged = [0, 1, 2].map(follow);
        self.last = Some((t, load, lagged));
        ([0, 1, 2].map(|k| lagged[k] + drive * trend[k]), trend)
    }
}

/// The time by which a reading that is taken now is late, s: what it shows happened then.
pub(crate) fn lateness(plant: &Plant<f64>, clock: Clock) -> f64 {
    let at = |late: f64| Clock { since_contact: clock.since_contact - late, t: clock.t - late, ..clock };
    // A clock that drifts is as late as it was then; each round is more exact by the drift.
    (0..DRIFTS).fold(0.0, |late, _| plant.delay(at(late)).unwrap_or(0.0))
}

/// Rounds of that: a drift of 0.3 leaves 3e-5 of itself.
const DRIFTS: usize = 8;

/// Steps of Newton's method at most, and halvings of one.
const STEPS: usize = 30;
const HALVINGS: usize = 20;
/// Relative error of a load that is met.
const MET: f64 = 1e-10;
/// Relative step of a derivative.
const NUDGE: f64 = 1e-6;

/// Turn the truth into a reading: the inverse of the instrument effects, which the model knows as
/// the way from the reading to the truth. Most are affine in the reading; the rest is met by Newton's method.
fn distort(truth: [f64; 3], plant: &Plant<f64>, clock: Clock) -> [f64; 3] {
    let correct = |reading: Vector3<f64>| Vector3::from(plant.correct(reading.into(), clock));
    let truth = Vector3::from(truth);
    let slopes = |at: Vector3<f64>, by: f64| {
        let zero = correct(at);
        Matrix3::from_columns(&[0, 1, 2].map(|k| (correct(at + Vector3::ith(k, by)) - zero) / by))
    };
    let gain = slopes(Vector3::zeros(), 1.0);
    // A gain that maps some load to nothing has no inverse: such a sensor reads its offset alone.
    let Some(mut reading) = gain.lu().solve(&(truth - correct(Vector3::zeros()))) else { return [0.0; 3] };
    let scale = 1.0 + truth.norm();
    for _ in 0..STEPS {
        let off = correct(reading) - truth;
        if off.norm() <= MET * scale {
            break;
        }
        let Some(step) = slopes(reading, NUDGE * scale).lu().solve(&off) else { break };
        let better = |share: &f64| (correct(reading - step * *share) - truth).norm() < off.norm();
        let Some(share) = (0..HALVINGS).map(|k| 0.5f64.powi(k as i32)).find(better) else { break };
        reading -= step * share;
    }
    reading.into()
}

pub(crate) fn check_rate(key: &str, value: f64) -> Result<(), SimError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(SimError::value(key, value, "must be positive (samples per second)"))
}

pub(crate) fn check_noise(key: &str, value: f64) -> Result<(), SimError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(SimError::value(key, value, "must be finite and not negative"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_model::{Body, Effect, Kind, Model};

    const CONTACT: Clock = Clock::since_contact(2.0);

    fn plant(effects: Vec<Effect>) -> Plant<f64> {
        let body = Body::from_footprint(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], 5.0).unwrap();
        Model {
            body,
            mass: Some(5.0),
            dof: [true; 3],
            effects,
            priors: Default::default(),
            discrepancy: None,
        }
        .resolved()
        .unwrap()
    }

    #[test]
    fn the_moment_is_about_the_gripper_and_the_axes_are_its_own() {
        // 10 N along the object's y at a gripper 0.5 m ahead of the origin, turned left by 90°: the
        // gripper's x, and no moment about itself.
        let frame = [0.5, 0.0, std::f64::consts::FRAC_PI_2];
        let sensor = Sensor { offset: [1.0, -2.0, 0.5], ..Sensor::default() };
        let felt = Felt { wrench: [0.0, 10.0, 5.0], frame, accel: [0.0; 2] };
        let reading = sensor.reading(&felt, &plant(vec![]), CONTACT);
        for (read, expected) in reading.into_iter().zip([11.0, -2.0, 0.5]) {
            assert!((read - expected).abs() < 1e-12, "{reading:?}");
        }
    }

    #[test]
    fn a_biased_instrument_reads_what_the_model_corrects() {
        let values = [1.5, -0.5, 0.2, 0.3, 0.0].map(Some).to_vec();
        let plant = plant(vec![Effect { kind: Kind::ForceBias, values }]);
        let (truth, frame) = ([4.0, 3.0, 2.0], [0.2, 0.1, 0.3]);
        let felt = Felt { wrench: truth, frame, accel: [0.0; 2] };
        let reading = Sensor::default().reading(&felt, &plant, CONTACT);
        let back = trundle_model::transport(plant.correct(reading, CONTACT), frame);
        for (back, truth) in back.into_iter().zip(truth) {
            assert!((back - truth).abs() < 1e-12, "{back} {truth}");
        }
    }

    #[test]
    fn what_bends_a_reading_is_inverted_too() {
        let bent = [
            (Kind::DeadBand, vec![3.0, 0.4]),
            (Kind::Saturation, vec![8.0, 5.0, 1.0, 0.7]),
            (Kind::CrossTalk, vec![0.2, 0.5, -0.1, 0.3, 0.05, -0.1]),
            (Kind::SensorPlay, vec![4.0, 0.5]),
        ];
        let clock = Clock { trend: [20.0, -3.0, 0.0], ..CONTACT };
        for (kind, values) in bent {
            let plant = plant(vec![Effect { kind, values: values.into_iter().map(Some).collect() }]);
            for truth in [[0.3, -0.1, 0.02], [9.0, -4.0, 0.5], [-14.0, 9.0, -2.0]] {
                let read = distort(truth, &plant, clock);
                let back = plant.correct(read, clock);
                assert!((0..3).all(|k| (back[k] - truth[k]).abs() < 1e-7), "{kind:?}: {back:?} {truth:?}");
            }
        }
    }

    #[test]
    fn a_lag_closes_two_thirds_of_a_step_in_its_time_constant() {
        let (mut memory, lags) = (Follower::default(), Lags { sensor: 0.05, drive: 0.0 });
        memory.follow(0.0, [0.0; 3], Some(lags));
        let mut read = [0.0; 3];
        for k in 1..=500 {
            read = memory.follow(f64::from(k) * 1e-4, [1.0, -2.0, 0.5], Some(lags)).0;
        }
        let closed = 1.0 - (-1.0f64).exp();
        for (read, load) in read.into_iter().zip([1.0, -2.0, 0.5]) {
            assert!((read / load - closed).abs() < 1e-3, "{read} of {load}");
        }
    }
}
