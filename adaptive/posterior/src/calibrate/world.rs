//! Recordings simulated from the assumptions of the likelihood: the plant of the model with a fine step,
//! white noise on wrench and pose, and a tare error that is constant within an episode.

use crate::calibrate::Calibration;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;
use trundle_model::{Clock, Plant, State, transport};
use trundle_record::{Counts, PoseSample, Prepared, WrenchSample};

/// Time of contact, s; the object rests before it.
const CONTACT: f64 = 0.4;
/// Steps of the plant per second. Every 12th step has a wrench sample, every 50th a pose.
const RATE: usize = 3000;
const WRENCH_EVERY: usize = 12;
const POSE_EVERY: usize = 50;

fn normal(sd: f64, rng: &mut ChaCha8Rng) -> f64 {
    sd * rng.sample::<f64, _>(StandardNormal)
}

/// A force with four sinusoidal components along and across the gripper, from contact on.
struct Waves {
    parts: Vec<[f64; 3]>,
    steady: f64,
}

impl Waves {
    fn new(amplitude: f64, rng: &mut ChaCha8Rng) -> Self {
        let part =
            |rng: &mut ChaCha8Rng| [normal(amplitude, rng), 0.3 + normal(0.4, rng).abs(), normal(2.0, rng)];
        Self { parts: (0..4).map(|_| part(rng)).collect(), steady: 0.7 * amplitude }
    }

    /// Gripper axes, N, N, N·m.
    fn at(&self, t: f64) -> [f64; 3] {
        let on = ((t - CONTACT) / 0.1).clamp(0.0, 1.0);
        let along: f64 = self.parts.iter().map(|[a, f, p]| a * (TAU * f * t + p).sin()).sum();
        let side: f64 = self.parts.iter().map(|[a, f, p]| 0.4 * a * (3.0 * f * t - 2.0 * p).cos()).sum();
        [on * (along + self.steady), on * side, 0.05 * on * side]
    }
}

impl Calibration {
    /// Simulates one push.
    pub(crate) fn push(&self, plant: &Plant<f64>, index: usize, rng: &mut ChaCha8Rng) -> Prepared {
        let (dof, push, noise) = (self.model.dof, &self.push, &self.noise);
        let only = |values: [f64; 3]| [0, 1, 2].map(|k| if dof[k] { values[k] } else { 0.0 });
        let frame = [push.grasp[0], push.grasp[1] + normal(push.scatter, rng), normal(0.1, rng)];
        let frame = if dof[2] { frame } else { [0.0; 3] };
        let force = Waves::new(push.force, rng);
        let tare = self.tare.map(|sd| normal(sd, rng));
        let mut state = State::at_rest(only([normal(1.0, rng), normal(1.0, rng), normal(1.5, rng)]));
        let (mut wrench, mut pose) = (vec![], vec![]);
        let dt = 1.0 / RATE as f64;
        for k in 0..(push.duration * RATE as f64) as usize {
            let t = k as f64 * dt;
            if k % WRENCH_EVERY == 0 {
                let (f, sd) = (force.at(t), [noise.force, noise.force, noise.torque]);
                let reading = [0, 1, 2].map(|i| f[i] + tare[i] + normal(sd[i], rng));
                wrench.push(WrenchSample { t, reading, frame, ..Default::default() });
            }
            if k % POSE_EVERY == 0 {
                let seen = [0, 1, 2].map(|i| state.pose[i] + normal(noise.pose[i], rng));
                pose.push(PoseSample { t, pose: only(seen) });
            }
            let clock = Clock::since_contact(t - CONTACT);
            state = plant.step(&state, transport(force.at(t + dt / 2.0), frame), clock, dt);
        }
        Prepared {
            ordinal: 0,
            name: format!("push_{index}"),
            wrench,
            pose,
            contact: CONTACT,
            tare_sd: self.tare,
            at_rest: true,
            counts: Counts::default(),
            ..Default::default()
        }
    }
}
