//! Effects of the instruments, the load or the wheel are recovered from pushes, with their size, delay and
//! time.
#![allow(clippy::unwrap_used)]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_fixtures::{NOISE, effect, locked, table};
use trundle_infer::{Fit, FitOptions, MotionLikelihood, Quiet, fit};
use trundle_model::{Clock, Effect, Kind, Model, Plant, State, to_body, to_world, transport};
use trundle_record::{Counts, PoseSample, Prepared, WrenchSample};

const CONTACT: f64 = 0.5;
const DT: f64 = 5e-4;
const STEPS: usize = 12_000;

/// Instruments with errors, implemented independently of the laws under test.
struct Instruments {
    /// Delay of the readings, s.
    delay: f64,
    /// Ratio of reading to true wrench.
    gain: [f64; 3],
    /// Mass of the gripper between sensor and object, kg.
    gripper: f64,
    /// Pose of the tracked frame in the object frame.
    offset: [f64; 3],
}

const SOUND: Instruments = Instruments { delay: 0.0, gain: [1.0; 3], gripper: 0.0, offset: [0.0; 3] };

fn compose([x, y, angle]: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let [dx, dy, _] = to_world([inner[0], inner[1], 0.0], angle);
    [x + dx, y + dy, angle + inner[2]]
}

/// World velocity of a point of the object.
fn velocity(state: &State<f64>, [x, y]: [f64; 2]) -> [f64; 2] {
    let [rx, ry, _] = to_world([x, y, 0.0], state.pose[2]);
    let [vx, vy, spin] = state.twist;
    [vx - spin * ry, vy + spin * rx]
}

/// A force that reverses several times, gripper axes.
fn force(t: f64, phase: f64) -> [f64; 3] {
    let on = ((t - CONTACT) / 0.1).clamp(0.0, 1.0);
    let along = 30.0 * (2.4 * t + phase).sin() + 14.0 * (7.1 * t + 2.0 * phase).sin();
    let side = 18.0 * (3.7 * t - phase).cos() + 7.0 * (9.3 * t).sin();
    [on * along, on * side, on * 0.15 * side]
}

/// One push: the plant moves the object, and the instruments give readings and poses.
fn push(plant: &Plant<f64>, instruments: &Instruments, ordinal: usize, seed: u64) -> Prepared {
    let mut rng = ChaCha8Rng::seed_from_u64(100 * seed + ordinal as u64);
    let mut normal = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let grasp = [[-0.55, 0.2, 0.4], [0.5, -0.35, 2.0], [0.55, 0.3, -1.1]][ordinal % 3];
    let phase = normal(1.5);
    let mut state = State::at_rest([normal(1.0), normal(1.0), normal(1.5)]);
    let (mut felt, mut poses) = (vec![], vec![]);
    for k in 0..STEPS {
        let t = k as f64 * DT;
        let clock = Clock {
            t: t + DT / 2.0,
            dt: DT,
            episode: ordinal as f64,
            grasp: [grasp[0], grasp[1]],
            ..Clock::since_contact(t - CONTACT)
        };
        let middle = force(t + DT / 2.0, phase);
        let before = velocity(&state, [grasp[0], grasp[1]]);
        let heading = state.pose[2] + grasp[2];
        poses.push(state.pose);
        state = plant.step(&state, transport(middle, grasp), clock, DT);
        let after = velocity(&state, [grasp[0], grasp[1]]);
        let accel = to_body([(after[0] - before[0]) / DT, (after[1] - before[1]) / DT, 0.0], heading);
        felt.push([0, 1, 2].map(|k| instruments.gain[k] * (middle[k] + instruments.gripper * accel[k])));
    }
    let late = (instruments.delay / DT).round() as isize;
    let reading = |k: usize| k.checked_add_signed(-late).and_then(|k| felt.get(k)).copied();
    let seen = |k: usize| compose(poses[k], instruments.offset);
    // The grasp in the tracked frame, the only frame known to the tracker.
    let [x, y, angle] = instruments.offset;
    let frame = to_body([grasp[0] - x, grasp[1] - y, grasp[2] - angle], angle);
    let noise = [NOISE.force, NOISE.force, NOISE.torque];
    let wrench = (0..STEPS)
        .step_by(8)
        .map(|k| {
            let clean = reading(k).unwrap_or([0.0; 3]);
            WrenchSample {
                t: (k as f64 + 0.5) * DT,
                reading: [0, 1, 2].map(|i| clean[i] + normal(noise[i])),
                frame,
                ..Default::default()
            }
        })
        .collect();
    let pose = (0..STEPS)
        .step_by(33)
        .map(|k| PoseSample { t: k as f64 * DT, pose: [0, 1, 2].map(|i| seen(k)[i] + normal(NOISE.pose[i])) })
        .collect();
    Prepared {
        name: format!("episode_{ordinal:02}"),
        ordinal,
        wrench,
        pose,
        contact: CONTACT + instruments.delay,
        tare_sd: [0.04, 0.04, 0.005],
        at_rest: true,
        counts: Counts::default(),
        ..Default::default()
    }
}

/// Three pushes fitted with an effect free.
fn fitted(truth: &Model, instruments: &Instruments, tried: Effect, mass: Option<f64>) -> Fit {
    let plant = truth.resolved().unwrap();
    let episodes: Vec<Prepared> = (0..3).map(|k| push(&plant, instruments, k, 7)).collect();
    let likelihood = MotionLikelihood::new(&episodes, &NOISE).unwrap();
    let model = Model::nominal(table(), mass, [true; 3]).with(tried);
    fit(&likelihood, &model, &[], &FitOptions::default(), &Quiet).unwrap()
}

/// Asserts that the estimate is within `within` of the truth and within four standard deviations.
#[track_caller]
fn assert_found(fit: &Fit, name: &str, truth: f64, within: f64) {
    let found = fit.estimate(name).unwrap();
    let off = (found.mean - truth).abs();
    assert!(found.identified, "{found:?} for {truth}");
    assert!(off < within && off < 4.0 * found.sd, "{found:?} for {truth}");
}

#[test]
fn a_mass_centre_offset() {
    let values = [("com_x", 0.18), ("com_y", -0.09)];
    let truth = locked().with(effect(Kind::ComOffset, &values));
    let found = fitted(&truth, &SOUND, Effect::free(Kind::ComOffset), None);
    assert_found(&found, "com_offset.com_x", 0.18, 0.01);
    assert_found(&found, "com_offset.com_y", -0.09, 0.01);
}

#[test]
fn mass_at_the_edge() {
    let truth = locked().with(effect(Kind::MassSpread, &[("inertia_factor", 1.7)]));
    let found = fitted(&truth, &SOUND, Effect::free(Kind::MassSpread), None);
    assert_found(&found, "mass_spread.inertia_factor", 1.7, 0.05);
}

#[test]
fn load_put_on_in_the_second_push() {
    let values = [("episode", 1.0), ("time", 2.7), ("mass", 6.0)];
    let truth = locked().with(effect(Kind::MassChange, &values));
    let tried = Effect::free(Kind::MassChange).with("episode", Some(1.0));
    let found = fitted(&truth, &SOUND, tried, None);
    assert_found(&found, "mass_change.mass", 6.0, 0.2);
    assert_found(&found, "mass_change.time", 2.7, 0.05);
}

#[test]
fn a_wheel_released_in_the_second_push() {
    let values = [("episode", 1.0), ("time", 3.1), ("factor_x", 3.0), ("factor_y", 0.2)];
    let truth = locked().with(effect(Kind::WheelEvent, &values));
    let tried = Effect::free(Kind::WheelEvent).with("episode", Some(1.0));
    let found = fitted(&truth, &SOUND, tried, None);
    assert_found(&found, "wheel_event.time", 3.1, 0.05);
    assert_found(&found, "wheel_event.factor_y", 0.2, 0.02);
}

#[test]
fn the_grippers_own_mass() {
    let instruments = Instruments { gripper: 1.9, ..SOUND };
    let found = fitted(&locked(), &instruments, Effect::free(Kind::GripperInertia), None);
    assert_found(&found, "gripper_inertia.mass", 1.9, 0.2);
    assert_found(&found, "body.mass", 22.0, 0.2);
}

#[test]
fn gains_with_known_mass_and_their_ratios_without() {
    let instruments = Instruments { gain: [0.8, 1.1, 1.3], ..SOUND };
    let tried = Effect::free(Kind::ForceScale);
    let found = fitted(&locked(), &instruments, tried.clone(), Some(22.0));
    for (name, truth) in [("gain_x", 0.8), ("gain_y", 1.1), ("gain_torque", 1.3)] {
        assert_found(&found, &format!("force_scale.{name}"), truth, 0.03);
    }
    let found = fitted(&locked(), &instruments, tried, None);
    assert_found(&found, "force_scale.gain_y", 1.1 / 0.8, 0.03);
    assert_found(&found, "force_scale.gain_torque", 1.3 / 0.8, 0.05);
    // With readings of 0.8 times the true wrench, the object appears lighter by the same factor.
    assert_found(&found, "body.mass", 22.0 * 0.8, 0.4);
}

#[test]
fn late_and_early_readings() {
    for delay in [0.08, 0.2, -0.04] {
        let instruments = Instruments { delay, ..SOUND };
        let found = fitted(&locked(), &instruments, Effect::free(Kind::Latency), None);
        assert_found(&found, "latency.delay", delay, 0.003);
        assert_found(&found, "body.mass", 22.0, 0.3);
    }
}

#[test]
fn an_offset_of_the_tracked_frame() {
    let instruments = Instruments { offset: [0.07, -0.05, 0.0], ..SOUND };
    let found = fitted(&locked(), &instruments, Effect::free(Kind::TrackerOffset), None);
    assert_found(&found, "tracker_offset.offset_x", 0.07, 0.01);
    assert_found(&found, "tracker_offset.offset_y", -0.05, 0.01);
    // Without feet and with a free wheel, the direction of the object axes is not identifiable.
    assert!(!found.estimate("tracker_offset.offset_theta").unwrap().identified);
}
