//! Recordings of a simulated table, made with the model's own integrator at a finer step.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_model::{Body, Clock, Effect, Kind, Model, Plant, State, transport};
use trundle_record::{Counts, Noise, PoseSample, Prepared, WrenchSample};

pub const NOISE: Noise =
    Noise { pose: [0.0005, 0.0005, 0.00175], force: 0.4, torque: 0.05, time: 0.0, stated: true };

pub fn table() -> Body {
    Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0).unwrap()
}

/// An office table with one locked wheel.
pub fn locked() -> Model {
    let wheel = [("x", -0.5), ("y", -0.3), ("angle", 0.2), ("mu_x", 15.0), ("mu_y", 180.0)];
    let wheel = wheel.iter().fold(Effect::free(Kind::ViscousWheel), |e, (name, v)| e.with(name, Some(*v)));
    Model { body: table(), mass: Some(22.0), dof: [true; 3], effects: vec![wheel] }
}

const CONTACT: f64 = 0.4;

/// Eight pushes of six seconds at random grasps, with noise and a tare from 100 samples.
pub fn pushes(truth: &Model, episodes: usize, seed: u64) -> Vec<Prepared> {
    let plant = truth.resolved().unwrap();
    (0..episodes).map(|k| push(&plant, k, seed)).collect()
}

fn push(plant: &Plant<f64>, index: usize, seed: u64) -> Prepared {
    let mut rng = ChaCha8Rng::seed_from_u64(seed * 1000 + index as u64);
    let mut normal = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let frame = [-0.6, normal(0.15), normal(0.1)];
    let waves: Vec<[f64; 3]> = (0..4).map(|_| [normal(12.0), 0.3 + normal(0.4).abs(), normal(2.0)]).collect();
    let force = |t: f64| {
        let s: f64 = waves.iter().map(|[a, f, p]| a * (std::f64::consts::TAU * f * t + p).sin()).sum();
        let side: f64 = waves.iter().map(|[a, f, p]| 0.4 * a * (3.0 * f * t - 2.0 * p).cos()).sum();
        let on = ((t - CONTACT) / 0.1).clamp(0.0, 1.0);
        [on * (s + 8.0), on * side, 0.05 * on * side]
    };
    let mut state = State::at_rest([normal(1.0), normal(1.0), normal(1.5)]);
    let tare = [normal(0.04), normal(0.04), normal(0.005)];
    let (mut wrench, mut pose) = (vec![], vec![]);
    let dt = 1.0 / 3000.0;
    for k in 0..(6.0 / dt) as usize {
        let t = k as f64 * dt;
        if k % 12 == 0 {
            let f = force(t);
            let sd = [0.4, 0.4, 0.05];
            let reading = [0, 1, 2].map(|i| f[i] + tare[i] + normal(sd[i]));
            wrench.push(WrenchSample { t, reading, frame });
        }
        if k % 50 == 0 {
            let sd = NOISE.pose;
            pose.push(PoseSample { t, pose: [0, 1, 2].map(|i| state.pose[i] + normal(sd[i])) });
        }
        let clock = Clock { since_contact: t - CONTACT };
        state = plant.step(&state, transport(force(t + dt / 2.0), frame), clock, dt);
    }
    Prepared {
        name: format!("episode_{index:02}"),
        wrench,
        pose,
        contact: CONTACT,
        tare_sd: [0.04, 0.04, 0.005],
        at_rest: true,
        counts: Counts::default(),
    }
}
