//! Wrist force-torque sensor with instrument effects, delays and lags.

use std::collections::VecDeque;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use trundle_model::{Clock, Lags, Plant, STANDARD_GRAVITY_M_PER_S2};

use crate::SimError;

/// Times that differ by less count as equal, s.
const TIME_TOLERANCE_S: f64 = 1e-9;

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
    /// Reading without load, constant in the sensor frame, `[N, N, N·m]`.
    pub offset: [f64; 3],
    /// Time without contact at the start of an episode, for the tare, s.
    pub precontact: f64,
    /// Gripper attached to the sensor. If present, all six axes are recorded.
    pub gripper: Option<GripperPayload>,
}

/// A level gripper attached to the sensor. Its weight appears in the three axes outside the plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GripperPayload {
    /// Mass, kg.
    pub mass: f64,
    /// Mass centre, sensor frame, m.
    #[serde(default)]
    pub com: [f64; 3],
    /// Readings of `force_z`, `torque_x` and `torque_y` without load, `[N, N·m, N·m]`.
    #[serde(default)]
    pub offset: [f64; 3],
}

impl GripperPayload {
    /// Readings of `force_z`, `torque_x` and `torque_y` without noise. The sensor reports the force that the arm exerts, so
    /// the supporting force is positive.
    pub fn reading(&self) -> [f64; 3] {
        let weight = self.mass * STANDARD_GRAVITY_M_PER_S2;
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
    /// Check the values.
    ///
    /// # Errors
    /// If the rate is not positive, a noise, duration or mass is negative, or a value is not finite.
    pub fn check(&self) -> Result<(), SimError> {
        check_rate("sensor.rate", self.rate)?;
        check_non_negative("sensor.force_noise", self.force_noise)?;
        check_non_negative("sensor.torque_noise", self.torque_noise)?;
        check_non_negative("sensor.precontact", self.precontact)?;
        if let Some(GripperPayload { mass, com, offset }) = &self.gripper {
            check_non_negative("sensor.gripper.mass", *mass)?;
            if let Some(value) = com.iter().chain(offset).find(|v| !v.is_finite()) {
                return Err(SimError::value("sensor.gripper", value, "must be finite (m; N, N·m, N·m)"));
            }
        }
        match self.offset.iter().find(|v| !v.is_finite()) {
            Some(value) => Err(SimError::value("sensor.offset", value, "must be finite (N, N, N·m)")),
            None => Ok(()),
        }
    }

    /// Standard deviation of each axis, `[N, N, N·m]`.
    pub fn noise(&self) -> [f64; 3] {
        [self.force_noise, self.force_noise, self.torque_noise]
    }

    /// Reading without noise, gripper axes about the gripper's origin.
    pub fn reading(&self, load: &GripperLoad, plant: &Plant<f64>, clock: Clock) -> [f64; 3] {
        let [fx, fy, torque] = wrench_in_frame(load.wrench, load.frame);
        let gripper_mass = plant.rigid(clock).mass - plant.object(clock).mass;
        let [ax, ay] = load.accel;
        let read = distort([fx + gripper_mass * ax, fy + gripper_mass * ay, torque], plant, clock);
        [0, 1, 2].map(|k| read[k] + self.offset[k])
    }
}

/// Load on the gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripperLoad {
    /// Wrench on the object, object axes about the object origin, `[N, N, N·m]`.
    pub wrench: [f64; 3],
    /// Pose of the gripper in the object frame, m and rad.
    pub frame: [f64; 3],
    /// Acceleration of the gripper's origin, gripper axes, m/s². The gripper's mass is taken to be at its origin.
    pub accel: [f64; 2],
}

/// Delay line between sensor and recording. The delay may be negative: a leading clock requests future readings.
#[derive(Clone, Debug, Default)]
pub(crate) struct DelayLine {
    /// Times and readings that a request may still need.
    history: VecDeque<(f64, [f64; 3])>,
    pending: VecDeque<Request>,
}

/// A sample that waits for its reading.
#[derive(Clone, Copy, Debug)]
struct Request {
    row: usize,
    /// Time of the reading, s.
    time: f64,
    noise: [f64; 3],
}

impl DelayLine {
    /// Request the reading at a time for a row.
    pub fn request(&mut self, row: usize, time: f64, noise: [f64; 3]) {
        self.pending.push_back(Request { row, time, noise });
    }

    /// Add the reading at `t`, while the delay is `delay`, s. Returns the rows whose requests are now complete.
    pub fn push(&mut self, t: f64, reading: [f64; 3], delay: f64) -> Vec<(usize, [f64; 3])> {
        self.history.push_back((t, reading));
        let mut answers = vec![];
        while let Some(&Request { row, time, noise }) =
            self.pending.front().filter(|w| w.time <= t + TIME_TOLERANCE_S)
        {
            let clean = self.interpolate(time);
            answers.push((row, [0, 1, 2].map(|k| clean[k] + noise[k])));
            self.pending.pop_front();
        }
        let needed = self.pending.front().map_or(t - delay, |w| w.time.min(t - delay));
        while self.history.get(1).is_some_and(|(t, _)| *t <= needed) {
            self.history.pop_front();
        }
        answers
    }

    /// First row with a pending request.
    pub fn first_pending_row(&self) -> Option<usize> {
        self.pending.front().map(|waiting| waiting.row)
    }

    /// Account for the removal of the first `rows` rows.
    pub fn drop_rows(&mut self, rows: usize) {
        self.pending.iter_mut().for_each(|waiting| waiting.row -= rows);
    }

    /// Cancel all pending requests.
    pub fn clear(&mut self) {
        self.pending.clear();
    }

    /// The reading at a time by linear interpolation; before the first reading, the first reading.
    fn interpolate(&self, t: f64) -> [f64; 3] {
        let after = self.history.partition_point(|(before, _)| *before <= t + TIME_TOLERANCE_S);
        let (Some(&(a, low)), next) = (self.history.get(after.max(1) - 1), self.history.get(after)) else {
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

/// A wrench given in object axes about the object origin, expressed in the axes of `frame` about its origin.
pub(crate) fn wrench_in_frame([fx, fy, torque]: [f64; 3], [x, y, angle]: [f64; 3]) -> [f64; 3] {
    trundle_model::to_body([fx, fy, torque - (x * fy - y * fx)], angle)
}

/// State of a sensor whose reading depends on past loads.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SensorMemory {
    load: LagFilter,
    reading: LagFilter,
}

/// First-order lag and rate of change of a load.
#[derive(Clone, Copy, Debug, Default)]
struct LagFilter {
    /// Time, load and lagged load, `[N, N, N·m]`.
    last: Option<(f64, [f64; 3], [f64; 3])>,
}

impl SensorMemory {
    /// Reading without noise at a time, including lags and play.
    pub fn read(
        &mut self,
        sensor: &Sensor,
        load: &GripperLoad,
        plant: &Plant<f64>,
        clock: Clock,
    ) -> [f64; 3] {
        // Only sensor play uses the trend, and only its direction, which is the same for load and reading.
        let (_, trend) = self.load.update(clock.t, wrench_in_frame(load.wrench, load.frame), None);
        let read = sensor.reading(load, plant, Clock { trend, ..clock });
        self.reading.update(clock.t, read, plant.lags()).0
    }
}

impl LagFilter {
    /// Add a load at time `t`. Returns the recorded value with lags, and the rate of change of the load, 1/s.
    pub fn update(&mut self, t: f64, load: [f64; 3], lags: Option<Lags<f64>>) -> ([f64; 3], [f64; 3]) {
        let Lags { sensor, drive } = lags.unwrap_or(Lags { sensor: 0.0, drive: 0.0 });
        let (before, was, lagged) = self.last.unwrap_or((t, load, load));
        let dt = t - before;
        let trend = if dt > TIME_TOLERANCE_S { [0, 1, 2].map(|k| (load[k] - was[k]) / dt) } else { [0.0; 3] };
        let decay = if sensor > 0.0 { (-dt / sensor).exp() } else { 0.0 };
        // Between two times the load is taken as their mean.
        let update = |k: usize| {
            let driven = if sensor > 0.0 { (load[k] + was[k]) / 2.0 } else { load[k] };
            driven + (lagged[k] - driven) * decay
        };
        let lagged = [0, 1, 2].map(update);
        self.last = Some((t, load, lagged));
        ([0, 1, 2].map(|k| lagged[k] + drive * trend[k]), trend)
    }
}

/// Delay of a reading recorded now, s: it shows the load at that time before.
pub(crate) fn reading_delay(plant: &Plant<f64>, clock: Clock) -> f64 {
    let at = |delay: f64| Clock { since_contact: clock.since_contact - delay, t: clock.t - delay, ..clock };
    // The delay of a drifting clock depends on the time of the reading: fixed-point iteration.
    (0..DELAY_ITERATIONS).fold(0.0, |delay, _| plant.delay(at(delay)).unwrap_or(0.0))
}

/// Fixed-point iterations for the delay. With a drift of 0.3 the relative error is 3e-5.
const DELAY_ITERATIONS: usize = 8;

/// Largest number of Newton iterations, and of step halvings in one of them.
const MAX_NEWTON_ITERATIONS: usize = 30;
const MAX_STEP_HALVINGS: usize = 20;
/// Relative tolerance of the inverted load.
const RELATIVE_TOLERANCE: f64 = 1e-10;
/// Relative step of finite differences.
const RELATIVE_DIFFERENCE_STEP: f64 = 1e-6;

/// Reading of a true load: the inverse of the model's correction from reading to load. Most corrections are affine in
/// the reading. Newton's method with step halving inverts the others.
fn distort(truth: [f64; 3], plant: &Plant<f64>, clock: Clock) -> [f64; 3] {
    let correct = |reading: Vector3<f64>| Vector3::from(plant.correct(reading.into(), clock));
    let truth = Vector3::from(truth);
    let slopes = |at: Vector3<f64>, by: f64| {
        let zero = correct(at);
        Matrix3::from_columns(&[0, 1, 2].map(|k| (correct(at + Vector3::ith(k, by)) - zero) / by))
    };
    let gain = slopes(Vector3::zeros(), 1.0);
    // A singular gain has no inverse: the sensor reads its offset alone.
    let Some(mut reading) = gain.lu().solve(&(truth - correct(Vector3::zeros()))) else { return [0.0; 3] };
    let scale = 1.0 + truth.norm();
    for _ in 0..MAX_NEWTON_ITERATIONS {
        let off = correct(reading) - truth;
        if off.norm() <= RELATIVE_TOLERANCE * scale {
            break;
        }
        let Some(step) = slopes(reading, RELATIVE_DIFFERENCE_STEP * scale).lu().solve(&off) else { break };
        let better = |share: &f64| (correct(reading - step * *share) - truth).norm() < off.norm();
        let Some(share) = (0..MAX_STEP_HALVINGS).map(|k| 0.5f64.powi(k as i32)).find(better) else { break };
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

pub(crate) fn check_non_negative(key: &str, value: f64) -> Result<(), SimError> {
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
    fn the_reading_is_in_gripper_axes_about_the_gripper() {
        // 10 N along the object's y at a gripper 0.5 m ahead of the origin and turned left by 90°: along the gripper's x,
        // without a moment about the gripper.
        let frame = [0.5, 0.0, std::f64::consts::FRAC_PI_2];
        let sensor = Sensor { offset: [1.0, -2.0, 0.5], ..Sensor::default() };
        let load = GripperLoad { wrench: [0.0, 10.0, 5.0], frame, accel: [0.0; 2] };
        let reading = sensor.reading(&load, &plant(vec![]), CONTACT);
        for (read, expected) in reading.into_iter().zip([11.0, -2.0, 0.5]) {
            assert!((read - expected).abs() < 1e-12, "{reading:?}");
        }
    }

    #[test]
    fn the_model_corrects_the_reading_of_a_biased_sensor() {
        let values = [1.5, -0.5, 0.2, 0.3, 0.0].map(Some).to_vec();
        let plant = plant(vec![Effect { kind: Kind::ForceBias, values }]);
        let (truth, frame) = ([4.0, 3.0, 2.0], [0.2, 0.1, 0.3]);
        let load = GripperLoad { wrench: truth, frame, accel: [0.0; 2] };
        let reading = Sensor::default().reading(&load, &plant, CONTACT);
        let back = trundle_model::transport(plant.correct(reading, CONTACT), frame);
        for (back, truth) in back.into_iter().zip(truth) {
            assert!((back - truth).abs() < 1e-12, "{back} {truth}");
        }
    }

    #[test]
    fn nonlinear_corrections_are_inverted() {
        let nonlinear = [
            (Kind::DeadBand, vec![3.0, 0.4]),
            (Kind::Saturation, vec![8.0, 5.0, 1.0, 0.7]),
            (Kind::CrossTalk, vec![0.2, 0.5, -0.1, 0.3, 0.05, -0.1]),
            (Kind::SensorPlay, vec![4.0, 0.5]),
        ];
        let clock = Clock { trend: [20.0, -3.0, 0.0], ..CONTACT };
        for (kind, values) in nonlinear {
            let plant = plant(vec![Effect { kind, values: values.into_iter().map(Some).collect() }]);
            for truth in [[0.3, -0.1, 0.02], [9.0, -4.0, 0.5], [-14.0, 9.0, -2.0]] {
                let read = distort(truth, &plant, clock);
                let back = plant.correct(read, clock);
                assert!((0..3).all(|k| (back[k] - truth[k]).abs() < 1e-7), "{kind:?}: {back:?} {truth:?}");
            }
        }
    }

    #[test]
    fn a_lag_reaches_two_thirds_of_a_step_after_its_time_constant() {
        let (mut memory, lags) = (LagFilter::default(), Lags { sensor: 0.05, drive: 0.0 });
        memory.update(0.0, [0.0; 3], Some(lags));
        let mut read = [0.0; 3];
        for k in 1..=500 {
            read = memory.update(f64::from(k) * 1e-4, [1.0, -2.0, 0.5], Some(lags)).0;
        }
        let closed = 1.0 - (-1.0f64).exp();
        for (read, load) in read.into_iter().zip([1.0, -2.0, 0.5]) {
            assert!((read / load - closed).abs() < 1e-3, "{read} of {load}");
        }
    }
}
