//! Timing errors and cross-talk of the instruments are recovered from pushes. The instruments are implemented
//! independently of the laws under test.
#![allow(clippy::unwrap_used)]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_fixtures::{NOISE, locked, table};
use trundle_infer::{Fit, FitOptions, MotionLikelihood, Quiet, fit};
use trundle_model::{Clock, Effect, Kind, Model, Plant, State, transport};
use trundle_record::{Counts, PoseSample, Prepared, WrenchSample};

const CONTACT: f64 = 0.5;
const DT: f64 = 5e-4;
const STEPS: usize = 12_000;

type Signal = Vec<[f64; 3]>;

/// Maps a signal to the recorded signal and to the one that acts on the object.
struct Fault {
    read: fn(&Signal) -> Signal,
    acts: fn(&Signal) -> Signal,
}

fn as_is(signal: &Signal) -> Signal {
    signal.clone()
}

/// A signal filtered by a first-order lag, s.
fn lagging(signal: &Signal, lag: f64) -> Signal {
    let mut y = signal[0];
    let follow = |x: &[f64; 3]| {
        y = [0, 1, 2].map(|k| y[k] + (x[k] - y[k]) * (1.0 - (-DT / lag).exp()));
        y
    };
    signal.iter().map(follow).collect()
}

/// A signal with play, half widths N, N, N·m.
fn playing(signal: &Signal, half: [f64; 3]) -> Signal {
    let mut y = [0.0f64; 3];
    let follow = |x: &[f64; 3]| {
        y = [0, 1, 2].map(|k| y[k].clamp(x[k] - half[k], x[k] + half[k]));
        y
    };
    signal.iter().map(follow).collect()
}

fn by_axis(signal: &Signal, of: impl Fn(usize, f64) -> f64) -> Signal {
    signal.iter().map(|x| [0, 1, 2].map(|k| of(k, x[k]))).collect()
}

/// A force that reverses several times, gripper axes.
fn force(t: f64, phase: f64) -> [f64; 3] {
    let on = ((t - CONTACT) / 0.1).clamp(0.0, 1.0);
    let along = 30.0 * (2.4 * t + phase).sin() + 14.0 * (7.1 * t + 2.0 * phase).sin();
    let side = 18.0 * (3.7 * t - phase).cos() + 7.0 * (9.3 * t).sin();
    [on * along, on * side, on * (0.15 * side + 1.5 * (5.3 * t).sin())]
}

fn push(plant: &Plant<f64>, fault: &Fault, ordinal: usize, seed: u64) -> Prepared {
    let mut rng = ChaCha8Rng::seed_from_u64(100 * seed + ordinal as u64);
    let mut normal = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let frame = [[-0.55, 0.2, 0.4], [0.5, -0.35, 2.0], [0.55, 0.3, -1.1]][ordinal % 3];
    let phase = normal(1.5);
    let signal: Signal = (0..STEPS).map(|k| force((k as f64 + 0.5) * DT, phase)).collect();
    let (felt, acting) = ((fault.read)(&signal), (fault.acts)(&signal));
    let mut state = State::at_rest([normal(1.0), normal(1.0), normal(1.5)]);
    let mut poses = vec![];
    for (k, wrench) in acting.iter().enumerate() {
        let t = k as f64 * DT;
        poses.push(state.pose);
        let moment = Clock::since_contact(t - CONTACT);
        let clock =
            Clock { t: t + DT / 2.0, dt: DT, episode: ordinal as f64, grasp: [frame[0], frame[1]], ..moment };
        state = plant.step(&state, transport(*wrench, frame), clock, DT);
    }
    let noise = [NOISE.force, NOISE.force, NOISE.torque];
    let wrench = (0..STEPS).step_by(8).map(|k| {
        let reading = [0, 1, 2].map(|i| felt[k][i] + normal(noise[i]));
        WrenchSample { t: (k as f64 + 0.5) * DT, reading, frame, ..Default::default() }
    });
    let wrench = wrench.collect();
    let seen = |k: usize| PoseSample {
        t: k as f64 * DT,
        pose: [0, 1, 2].map(|i| poses[k][i] + normal(NOISE.pose[i])),
    };
    Prepared {
        name: format!("episode_{ordinal:02}"),
        ordinal,
        wrench,
        pose: (0..STEPS).step_by(33).map(seen).collect(),
        contact: CONTACT,
        tare_sd: [0.04, 0.04, 0.005],
        at_rest: true,
        counts: Counts::default(),
        ..Default::default()
    }
}

/// Three pushes fitted with the effects free.
fn fitted(fault: &Fault, mass: Option<f64>, tried: &[Effect]) -> Fit {
    fitted_from(fault, mass, tried, &[])
}

/// The same with additional starts.
fn fitted_from(fault: &Fault, mass: Option<f64>, tried: &[Effect], warm: &[Vec<f64>]) -> Fit {
    let plant = locked().resolved().unwrap();
    let episodes: Vec<Prepared> = (0..3).map(|k| push(&plant, fault, k, 7)).collect();
    let likelihood = MotionLikelihood::new(&episodes, &NOISE).unwrap();
    let nominal = Model::nominal(table(), mass, [true; 3]);
    let model = tried.iter().cloned().fold(nominal, Model::with);
    fit(&likelihood, &model, warm, &FitOptions::default(), &Quiet).unwrap()
}

/// Asserts that the estimate is within `within` of the truth.
#[track_caller]
fn assert_near(fit: &Fit, name: &str, truth: f64, within: f64) {
    let found = fit.estimate(name).unwrap();
    assert!(found.identified && (found.mean - truth).abs() < within, "{found:?} for {truth}");
}

#[test]
fn a_reading_that_lags() {
    let fault = Fault { read: |x| lagging(x, 0.06), acts: as_is };
    let found = fitted(&fault, None, &[Effect::free(Kind::SensorLag)]);
    assert_near(&found, "sensor_lag.time_constant", 0.06, 0.003);
    assert_near(&found, "body.mass", 22.0, 0.3);
}

#[test]
fn a_lag_is_distinguished_from_a_delay() {
    let fault = Fault { read: |x| lagging(x, 0.06), acts: as_is };
    let both = [Effect::free(Kind::SensorLag), Effect::free(Kind::Latency)];
    let found = fitted(&fault, None, &both);
    assert_near(&found, "sensor_lag.time_constant", 0.06, 0.006);
    assert_near(&found, "latency.delay", 0.0, 0.006);
    let delayed = fitted(&fault, None, &both[1..]);
    assert!(delayed.cost - found.cost > 50.0, "{} {}", delayed.cost, found.cost);
}

#[test]
fn a_drive_that_lags() {
    let fault = Fault { read: as_is, acts: |x| lagging(x, 0.05) };
    let found = fitted(&fault, None, &[Effect::free(Kind::DriveLag)]);
    assert_near(&found, "drive_lag.time_constant", 0.05, 0.003);
    assert_near(&found, "body.mass", 22.0, 0.3);
}

#[test]
fn a_clock_that_runs_fast() {
    let fault = Fault {
        read: |x| {
            let at = |k: usize| {
                let s = (k as f64 * DT - CONTACT).max(0.0) / 1.03;
                let true_time = (k as f64 * DT).min(CONTACT + s);
                x[((true_time / DT).round() as usize).min(x.len() - 1)]
            };
            (0..x.len()).map(at).collect()
        },
        acts: as_is,
    };
    let found = fitted(&fault, None, &[Effect::free(Kind::ClockDrift)]);
    assert_near(&found, "clock_drift.drift", 0.03, 0.002);
    assert_near(&found, "body.mass", 22.0, 0.3);
}

#[test]
fn axes_that_are_mixed() {
    let fault = Fault {
        read: |x| {
            let mix = |[x, y, t]: &[f64; 3]| [x + 0.12 * y + 0.4 * t, y - 0.08 * x, t + 0.05 * x - 0.07 * y];
            x.iter().map(mix).collect()
        },
        acts: as_is,
    };
    let found = fitted(&fault, Some(22.0), &[Effect::free(Kind::CrossTalk)]);
    let truth = [
        ("x_from_y", 0.12, 0.03),
        ("x_from_torque", 0.4, 0.1),
        ("y_from_x", -0.08, 0.03),
        ("y_from_torque", 0.0, 0.1),
        ("torque_from_x", 0.05, 0.01),
        ("torque_from_y", -0.07, 0.01),
    ];
    for (name, value, within) in truth {
        assert_near(&found, &format!("cross_talk.{name}"), value, within);
    }
}

#[test]
fn a_dead_zone_of_the_reading() {
    let fault = Fault {
        read: |x| by_axis(x, |k, v| v.signum() * (v.abs() - [5.0, 5.0, 0.4][k]).max(0.0)),
        acts: as_is,
    };
    let found = fitted(&fault, Some(22.0), &[Effect::free(Kind::DeadBand)]);
    assert_near(&found, "dead_band.force", 5.0, 0.5);
    assert_near(&found, "dead_band.torque", 0.4, 0.1);
}

#[test]
fn a_reading_with_play() {
    let fault = Fault { read: |x| playing(x, [3.0, 3.0, 0.3]), acts: as_is };
    let found = fitted(&fault, Some(22.0), &[Effect::free(Kind::SensorPlay)]);
    assert_near(&found, "sensor_play.force", 6.0, 1.0);
    assert_near(&found, "sensor_play.torque", 0.6, 0.15);
}

#[test]
fn a_saturated_reading() {
    const LIMITS: [f64; 3] = [22.0, 15.0, 2.2];
    let fault = Fault { read: |x| by_axis(x, |k, v| v.clamp(-LIMITS[k], LIMITS[k])), acts: as_is };
    let without = fitted(&fault, Some(22.0), &[]);
    // Started at the largest readings: a limit above those has a zero gradient.
    let start = [without.values.clone(), vec![23.0, 16.0, 2.3, 0.2]].concat();
    let found = fitted_from(&fault, Some(22.0), &[Effect::free(Kind::Saturation)], &[start]);
    assert_near(&found, "saturation.limit_x", LIMITS[0], 3.0);
    assert_near(&found, "saturation.limit_y", LIMITS[1], 3.0);
    assert!(without.cost - found.cost > 100.0, "{} {}", without.cost, found.cost);
}
