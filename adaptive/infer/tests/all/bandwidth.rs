//! Wrench residuals below the bandwidth measure the model and the wrench sensor, not the tracker.
#![allow(clippy::unwrap_used)]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_fixtures::{NOISE, effect, locked};
use trundle_infer::{Channels, Score, score, score_compared};
use trundle_model::{Clock, Kind, Model, State, transport};
use trundle_record::{Noise, PoseSample, Prepared, WrenchSample};

const CONTACT: f64 = 0.4;
const DT: f64 = 5e-4;
const GRASP: [f64; 3] = [-0.6, 0.1, 0.3];

fn force(t: f64) -> [f64; 3] {
    let on = ((t - CONTACT) / 0.1).clamp(0.0, 1.0);
    [on * (14.0 + 22.0 * (2.4 * t).sin()), on * 10.0 * (3.7 * t).cos(), on * (2.1 * t).sin()]
}

fn values(model: &Model) -> Vec<f64> {
    model.slots().iter().map(|slot| slot.value.unwrap()).collect()
}

/// A push of five seconds with a pose every `every` steps and the noise of `instruments`.
fn push(truth: &Model, every: usize, instruments: &Noise) -> Prepared {
    let plant = truth.resolved().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut normal = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let mut state = State::at_rest([0.2, -0.1, 0.4]);
    let (mut wrench, mut pose) = (vec![], vec![]);
    for k in 0..10_000 {
        let t = k as f64 * DT;
        if k % 16 == 0 {
            let sd = [instruments.force, instruments.force, instruments.torque];
            let reading = [0, 1, 2].map(|i| force(t)[i] + normal(sd[i]));
            wrench.push(WrenchSample { t, reading, frame: GRASP, ..Default::default() });
        }
        if k % every == 0 {
            let seen = [0, 1, 2].map(|i| state.pose[i] + normal(instruments.pose[i]));
            pose.push(PoseSample { t, pose: seen });
        }
        let clock = Clock { t: t + DT / 2.0, dt: DT, ..Clock::since_contact(t - CONTACT) };
        state = plant.step(&state, transport(force(t + DT / 2.0), GRASP), clock, DT);
    }
    Prepared { name: "push".to_owned(), wrench, pose, contact: CONTACT, at_rest: true, ..Default::default() }
}

fn scored(model: &Model, episode: &Prepared, noise: &Noise) -> Score {
    let episodes = std::slice::from_ref(episode);
    score(model, &values(model), &Channels::of(noise), episodes, noise, false).unwrap()
}

#[test]
fn the_true_models_residual_is_the_sensor_noise_at_any_pose_rate() {
    // Poses of a camera at 30, 60, 250 and 1000 Hz, and of an encoder at 1000 Hz.
    let encoder = Noise { pose: [1e-5; 3], ..NOISE };
    for (every, noise) in [(66, &NOISE), (33, &NOISE), (8, &NOISE), (2, &NOISE), (2, &encoder)] {
        let figures = scored(&locked(), &push(&locked(), every, noise), noise);
        let (force, torque) = (figures.force_rmse.unwrap(), figures.torque_rmse.unwrap());
        let bandwidth = figures.force_bandwidth.unwrap();
        let about_origin = NOISE.torque.hypot(GRASP[0].hypot(GRASP[1]) * NOISE.force);
        assert!(force < 1.5 * 2f64.sqrt() * NOISE.force, "every {every}: {force} N below {bandwidth} Hz");
        assert!(torque < 1.5 * about_origin, "every {every}: {torque} N·m below {bandwidth} Hz");
        assert!(bandwidth > 1.0, "every {every}: {bandwidth} Hz");
    }
}

#[test]
fn better_poses_increase_the_bandwidth_up_to_half_their_rate() {
    let of = |every: usize, noise: &Noise| {
        scored(&locked(), &push(&locked(), every, noise), noise).force_bandwidth.unwrap()
    };
    let encoder = Noise { pose: [1e-5; 3], ..NOISE };
    assert!(of(8, &NOISE) > 1.1 * of(33, &NOISE));
    assert!(of(8, &encoder) > 2.0 * of(8, &NOISE));
    let exact = Noise { pose: [1e-9; 3], ..NOISE };
    assert!((of(33, &exact) - 0.5 / (33.0 * DT)).abs() < 1e-9);
    let late = Noise { time: 5e-3, ..NOISE };
    assert!(of(8, &late) < 0.9 * of(8, &NOISE), "errors of the time stamps");
    // A command has no noise; a share of the recorded wrench counts instead.
    let command = Noise { force: 1e-6, torque: 1e-6, ..NOISE };
    assert!(of(33, &command) > 1.0);
}

#[test]
fn a_missing_effect_increases_the_residual() {
    let rubbing = effect(Kind::CoulombFriction, &[("x", 0.45), ("y", 0.31), ("force", 6.0)]);
    let episode = push(&locked().with(rubbing), 33, &NOISE);
    let missing = scored(&locked(), &episode, &NOISE).force_rmse.unwrap();
    assert!((4.0..8.0).contains(&missing), "{missing} N");
}

#[test]
fn compared_models_share_one_frequency() {
    let (light, mut heavy) = (locked(), locked());
    heavy.mass = heavy.mass.map(|mass| 4.0 * mass);
    let episode = push(&light, 33, &NOISE);
    let (own, other) = (values(&light), values(&heavy));
    let compared = |model: &Model, own: &[f64], other: (&Model, &[f64])| {
        let episodes = std::slice::from_ref(&episode);
        let channels = Channels::of(&NOISE);
        score_compared(model, own, &channels, episodes, &NOISE, false, Some(other)).unwrap().force_bandwidth
    };
    let both = [compared(&light, &own, (&heavy, &other)), compared(&heavy, &other, (&light, &own))];
    assert_eq!(both[0], both[1]);
    assert!(both[0] < scored(&light, &episode, &NOISE).force_bandwidth);
}

#[test]
fn quasi_static_comparisons_have_no_bandwidth() {
    let episode = push(&locked(), 33, &NOISE);
    let episodes = std::slice::from_ref(&episode);
    let figures =
        score(&locked(), &values(&locked()), &Channels::of(&NOISE), episodes, &NOISE, true).unwrap();
    assert!(figures.force_rmse.is_some() && figures.force_bandwidth.is_none());
}
