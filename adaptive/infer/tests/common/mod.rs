//! Recordings of a simulated table: the model's integrator with a finer step, noise, and optional hidden
//! effects.
#![allow(dead_code, clippy::unwrap_used)]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_model::{Body, Clock, Effect, Kind, MAX_INNER_STATES, Model, Plant, State, transport};
use trundle_record::{Counts, Dataset, Noise, PoseSample, Prepared, WrenchSample};

pub const NOISE: Noise =
    Noise { pose: [0.0005, 0.0005, 0.00175], force: 0.4, torque: 0.05, time: 0.0, stated: true };
const CONTACT: f64 = 0.4;
const TARE: [f64; 3] = [0.04, 0.04, 0.005];

pub fn table() -> Body {
    Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0).unwrap()
}

/// An effect with values by name.
pub fn effect(kind: Kind, values: &[(&str, f64)]) -> Effect {
    values.iter().fold(Effect::free(kind), |e, (name, value)| e.with(name, Some(*value)))
}

/// An office table with one locked wheel: φ = (22, −0.5, −0.3, 0.2, 15, 180).
pub fn locked() -> Model {
    let wheel = [("x", -0.5), ("y", -0.3), ("angle", 0.2), ("mu_x", 15.0), ("mu_y", 180.0)];
    Model {
        body: table(),
        mass: Some(22.0),
        dof: [true; 3],
        effects: vec![effect(Kind::ViscousWheel, &wheel)],
        priors: Default::default(),
        discrepancy: None,
    }
}

/// A simulated world.
pub struct World {
    /// The true model.
    pub truth: Model,
    /// Offset of the sensor from contact on, sensor axes.
    pub bias: [f64; 3],
    /// An out-of-catalogue wrench, object axes about the origin.
    pub foreign: fn(&State<f64>) -> [f64; 3],
    /// Initial values of the laws' own states.
    pub inner: [f64; MAX_INNER_STATES],
}

impl World {
    pub fn of(truth: Model) -> Self {
        Self { truth, bias: [0.0; 3], foreign: |_| [0.0; 3], inner: [0.0; MAX_INNER_STATES] }
    }

    /// Pushes of six seconds at random grasps, with noise and a tare from 100 samples.
    pub fn pushes(&self, episodes: usize, seed: u64) -> Vec<Prepared> {
        let plant = self.truth.resolved().unwrap();
        (0..episodes).map(|k| self.push(&plant, k, seed)).collect()
    }

    /// Five pushes, the last of which is held out.
    pub fn recording(&self, seed: u64) -> Dataset {
        let mut training = self.pushes(5, seed);
        let held_out = training.split_off(4);
        Dataset {
            name: "table".to_owned(),
            body: table(),
            dof: [true; 3],
            noise: NOISE,
            point_contact: false,
            commanded: false,
            wrench_pose: Default::default(),
            mass_given: None,
            training,
            held_out,
            obstacles: vec![],
        }
    }

    fn push(&self, plant: &Plant<f64>, index: usize, seed: u64) -> Prepared {
        let mut rng = ChaCha8Rng::seed_from_u64(seed * 1000 + index as u64);
        let mut normal = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
        let frame = [-0.6, normal(0.15), normal(0.1)];
        let waves: Vec<[f64; 3]> =
            (0..4).map(|_| [normal(12.0), 0.3 + normal(0.4).abs(), normal(2.0)]).collect();
        let force = |t: f64| {
            let along: f64 =
                waves.iter().map(|[a, f, p]| a * (std::f64::consts::TAU * f * t + p).sin()).sum();
            let side: f64 = waves.iter().map(|[a, f, p]| 0.4 * a * (3.0 * f * t - 2.0 * p).cos()).sum();
            let on = ((t - CONTACT) / 0.1).clamp(0.0, 1.0);
            [on * (along + 8.0), on * side, 0.05 * on * side]
        };
        let start = State::at_rest([normal(1.0), normal(1.0), normal(1.5)]);
        let mut state = start.with_inner(self.inner);
        let tare = TARE.map(&mut normal);
        let (mut wrench, mut pose) = (vec![], vec![]);
        let dt = 1.0 / 3000.0;
        for k in 0..18_000 {
            let t = k as f64 * dt;
            let bias = if t >= CONTACT { self.bias } else { [0.0; 3] };
            if k % 12 == 0 {
                let (f, sd) = (force(t), [NOISE.force, NOISE.force, NOISE.torque]);
                let reading = [0, 1, 2].map(|i| f[i] + bias[i] + tare[i] + normal(sd[i]));
                wrench.push(WrenchSample { t, reading, frame, ..Default::default() });
            }
            if k % 50 == 0 {
                pose.push(PoseSample { t, pose: [0, 1, 2].map(|i| state.pose[i] + normal(NOISE.pose[i])) });
            }
            let clock = Clock {
                t,
                dt,
                episode: index as f64,
                grasp: [frame[0], frame[1]],
                ..Clock::since_contact(t - CONTACT)
            };
            let applied = transport(force(t + dt / 2.0), frame);
            // Until contact the table is held in place.
            let foreign = if t >= CONTACT { (self.foreign)(&state) } else { [0.0; 3] };
            state = plant.step(&state, [0, 1, 2].map(|i| applied[i] + foreign[i]), clock, dt);
        }
        let name = format!("episode_{index:02}");
        Prepared {
            ordinal: index,
            name,
            wrench,
            pose,
            contact: CONTACT,
            tare_sd: TARE,
            at_rest: true,
            counts: Counts::default(),
            ..Default::default()
        }
    }
}
