//! The model with an effect reproduces a recording with that effect; the nominal model does not.

#![allow(clippy::unwrap_used)]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trundle_model::{Body, Clock, Effect, Kind, Lags, Model, State, transport};
use trundle_sim::{Coupling, DriveMode, EpisodeSetup, Push, Row, Sensor, SimError, Tracker};

const STEP: f64 = 5e-4;
const PRECONTACT: f64 = 0.4;

fn table() -> Model {
    let body = Body::from_footprint(&[[-0.5, -0.4], [0.7, -0.4], [0.7, 0.3], [-0.5, 0.3]], 22.0).unwrap();
    let wheel = [("x", -0.4), ("y", -0.3), ("angle", 0.2), ("mu_x", 15.0), ("mu_y", 80.0)];
    let effects = vec![effect(Kind::ViscousWheel, &wheel)];
    Model { body, mass: Some(22.0), dof: [true; 3], effects, priors: Default::default(), discrepancy: None }
}

fn effect(kind: Kind, values: &[(&str, f64)]) -> Effect {
    values.iter().fold(Effect::free(kind), |effect, (name, value)| effect.with(name, Some(*value)))
}

/// A push of three seconds that reverses and turns.
fn push() -> Push {
    let knots = vec![
        [0.0, 0.0, 0.0, 0.0],
        [0.3, 0.3, 0.0, 0.3],
        [0.9, 0.3, 0.1, 0.3],
        [1.2, -0.2, 0.2, -0.6],
        [2.0, -0.2, 0.0, -0.6],
        [2.3, 0.0, -0.3, 0.4],
        [3.0, 0.1, -0.2, 0.2],
    ];
    Push { start: [0.3, -0.2, 0.7], grasp: [0.6, 0.25, 0.5], drive: DriveMode::Velocity, knots }
}

/// Samples of noise-free instruments at every step, in the second episode of a recording.
fn rows(model: &Model) -> Result<Vec<Row>, SimError> {
    let rate = STEP.recip();
    let setup = EpisodeSetup {
        model,
        obstacles: &[],
        step: STEP,
        // A stiff grip: the grasp follows the gripper.
        coupling: Coupling { stiffness: 1e6, damping: 1e4, twist_stiffness: 3e4, twist_damping: 1e3 },
        sensor: Sensor {
            rate,
            force_noise: 0.0,
            torque_noise: 0.0,
            precontact: PRECONTACT,
            ..Sensor::default()
        },
        tracker: Tracker { rate, noise: [0.0; 3], drop_out: 0.0 },
    };
    setup.run(1, &push(), ChaCha8Rng::seed_from_u64(0))
}

/// Largest deviation of the model's pose from the recorded one, m and rad, under the corrected readings.
fn miss(model: &Model, rows: &[Row]) -> f64 {
    let plant = model.resolved().unwrap();
    let lags = plant.lags().unwrap_or(Lags { sensor: 0.0, drive: 0.0 });
    let poses: Vec<[f64; 6]> = rows.iter().map(|row| row.poses.unwrap()).collect();
    let reading = |k: usize, late: isize| k.checked_add_signed(late).and_then(|k| rows.get(k)?.reading);
    let mut driven = [0.0; 3];
    let mut state = State::at_rest([0, 1, 2].map(|k| poses[0][k]));
    let mut farthest = 0.0f64;
    for k in 0..rows.len() - 1 {
        let ([x, y, theta, gx, gy, gtheta], t) = (poses[k], rows[k].t);
        let (sin, cos) = theta.sin_cos();
        let frame = [cos * (gx - x) + sin * (gy - y), cos * (gy - y) - sin * (gx - x), gtheta - theta];
        let clock = Clock {
            t: t + STEP / 2.0,
            dt: STEP,
            episode: 1.0,
            grasp: [frame[0], frame[1]],
            ..Clock::since_contact(t - PRECONTACT)
        };
        let late = (plant.delay(clock).unwrap_or(0.0) / STEP).round() as isize;
        let (Some(a), Some(b)) = (reading(k, late), reading(k + 1, late)) else { continue };
        // The slope compensates a lag of the reading. A lag of the drive is simulated.
        let mut mean = [0, 1, 2].map(|i| (a[i] + b[i]) / 2.0 + lags.sensor * (b[i] - a[i]) / STEP);
        if lags.drive > 0.0 {
            let share = 1.0 - (-STEP / lags.drive).exp();
            driven = [0, 1, 2].map(|i| driven[i] + share * (mean[i] - driven[i]));
            mean = driven;
        }
        state = plant.step(&state, transport(plant.correct(mean, clock), frame), clock, STEP);
        let seen = poses[k + 1];
        let turned = (state.pose[2] - seen[2]).sin().abs();
        farthest = farthest.max((state.pose[0] - seen[0]).hypot(state.pose[1] - seen[1])).max(turned);
    }
    farthest
}

/// The deviation is below a tenth of a millimetre with the effect, and centimetres without it.
#[track_caller]
fn check(kind: Kind, values: &[(&str, f64)]) {
    check_to(1e-4, kind, values);
}

#[track_caller]
fn check_to(tolerance: f64, kind: Kind, values: &[(&str, f64)]) {
    let model = table().with(effect(kind, values));
    let rows = rows(&model).unwrap();
    let (with, without) = (miss(&model, &rows), miss(&table(), &rows));
    assert!(with < tolerance && without > 0.02, "{with} with it, {without} without");
}

#[test]
fn the_nominal_model_reproduces_a_clean_recording() {
    let miss = miss(&table(), &rows(&table()).unwrap());
    assert!(miss < 2e-4, "{miss}");
}

#[test]
fn an_offset_mass_centre() {
    check(Kind::ComOffset, &[("com_x", 0.25), ("com_y", -0.15)]);
}

#[test]
fn a_load_added_during_the_episode() {
    check(Kind::MassChange, &[("episode", 1.0), ("time", 1.2), ("mass", 9.0)]);
}

#[test]
fn a_load_removed_in_the_previous_episode() {
    check(Kind::MassChange, &[("episode", 0.0), ("time", 1.2), ("mass", -6.0)]);
}

#[test]
fn a_wheel_that_locks_during_the_episode() {
    check(Kind::WheelEvent, &[("episode", 1.0), ("time", 1.7), ("factor_x", 30.0), ("factor_y", 0.2)]);
}

#[test]
fn the_mass_of_the_gripper() {
    check(Kind::GripperInertia, &[("mass", 2.5)]);
}

#[test]
fn wrong_gains() {
    check(Kind::ForceScale, &[("gain_x", 0.9), ("gain_y", 1.2), ("gain_torque", 1.4)]);
}

#[test]
fn a_delayed_reading() {
    check(Kind::Latency, &[("delay", 0.08)]);
}

#[test]
fn a_leading_reading() {
    check(Kind::Latency, &[("delay", -0.06)]);
}

#[test]
fn a_drifting_clock() {
    check(Kind::ClockDrift, &[("drift", 0.04)]);
}

#[test]
fn a_sensor_lag() {
    check(Kind::SensorLag, &[("time_constant", 0.06)]);
}

#[test]
fn a_drive_lag() {
    // The slope of a command is known only for the previous step: an error of half a step at 0.5 m/s.
    check_to(3e-4, Kind::DriveLag, &[("time_constant", 0.06)]);
}

#[test]
fn cross_talk_dead_band_and_saturation() {
    let silent = [("x_from_torque", 0.0), ("y_from_x", 0.0), ("torque_from_y", 0.0)];
    let mixed = [("x_from_y", 0.3), ("y_from_torque", 0.5), ("torque_from_x", 0.2)];
    check(Kind::CrossTalk, &[silent, mixed].concat());
    check(Kind::DeadBand, &[("force", 6.0), ("torque", 1.0)]);
    let limits = [("limit_x", 10.0), ("limit_y", 10.0), ("limit_torque", 2.0), ("excess", 0.6)];
    check(Kind::Saturation, &limits);
}

#[test]
fn axis_friction_and_thinning_drag() {
    let axes = [("angle", 0.4), ("force_x", 6.0), ("force_y", 12.0), ("torque", 2.0)];
    check(Kind::AxisFriction, &axes);
    check(Kind::BodyAxisFriction, &axes);
    check(Kind::ThinningDrag, &[("force", 12.0), ("exponent", 0.4), ("spread", 1.0)]);
}

#[test]
fn a_tracker_offset() {
    check(Kind::TrackerOffset, &[("offset_x", 0.08), ("offset_y", -0.05), ("offset_theta", 0.3)]);
}

#[test]
fn cogging() {
    check(Kind::Cogging, &[("amplitude", 15.0), ("period", 0.3), ("phase", 0.4), ("angle", 0.6)]);
}

#[test]
fn quadratic_drag() {
    check(Kind::QuadraticDrag, &[("drag", 90.0)]);
}

#[test]
fn the_delay_does_not_change_the_rate_of_readings() {
    let count = |delay: f64| {
        let model = table().with(effect(Kind::Latency, &[("delay", delay)]));
        rows(&model).unwrap().iter().filter(|row| row.reading.is_some()).count()
    };
    let all = count(0.0);
    assert_eq!([count(0.05), count(-0.05)], [all, all - 100], "only future readings are missing");
}
