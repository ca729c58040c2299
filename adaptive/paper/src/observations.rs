//! Noisy training pushes of an object, and noise-free test pushes.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trundle_infer::{Pushes, SigmaReading, Transition, noisy, transitions};
use trundle_model::Model;

use crate::PaperError;

/// First seed of the test pushes, far from the seeds of training pushes.
const FIRST_TEST_SEED: u64 = 1 << 32;

/// Stream of the random numbers of wrench noise.
const WRENCH_NOISE_STREAM: u64 = 2;

/// Noise of the observations.
#[derive(Clone, Copy, Debug)]
pub enum ObservationNoise {
    /// On the state after a push, with an interpretation of its σ.
    State(SigmaReading, f64),
    /// On the wrench: σ in N on each force, in N·m on the torque.
    Wrench(f64),
}

impl ObservationNoise {
    /// Noise by the name of its interpretation: `si`, `cm_deg`, `of_motion` or `wrench`.
    ///
    /// # Errors
    /// If the name is unknown.
    pub fn named(reading: &str, sigma: f64) -> Result<Self, PaperError> {
        match reading {
            "si" => Ok(Self::State(SigmaReading::Si, sigma)),
            "cm_deg" => Ok(Self::State(SigmaReading::CentimetreDegree, sigma)),
            "of_motion" => Ok(Self::State(SigmaReading::OfMotion, sigma)),
            "wrench" => Ok(Self::Wrench(sigma)),
            _ => {
                let known = "si, cm_deg, of_motion and wrench";
                Err(PaperError::UnknownName { name: reading.to_owned(), known })
            }
        }
    }

    /// Adds noise to transitions. If σ is a share of the motion, it refers to the motion of the test pushes.
    fn add(self, data: &[Transition], test: &[Transition], seed: u64) -> Vec<Transition> {
        match self {
            Self::State(reading, sigma) => noisy(data, &reading.sd(sigma, test), seed),
            Self::Wrench(sigma) => {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream(WRENCH_NOISE_STREAM);
                let mut perturbed = |w: f64| {
                    let z: f64 = StandardNormal.sample(&mut rng);
                    w + sigma * z
                };
                data.iter().map(|t| Transition { wrench: t.wrench.map(&mut perturbed), ..*t }).collect()
            }
        }
    }
}

/// Training and test pushes.
#[derive(Clone, Debug)]
pub struct Observations {
    /// Pushes with noise.
    pub training: Vec<Transition>,
    /// Pushes without noise.
    pub test: Vec<Transition>,
}

impl Observations {
    /// Simulates `counts` training and test pushes of `dt` seconds each. A seed gives the same pushes for every
    /// noise and learner.
    ///
    /// # Errors
    /// If a value of the model is free.
    pub fn simulate(
        object: &Model,
        noise: ObservationNoise,
        counts: [usize; 2],
        seed: u64,
        dt: f64,
    ) -> Result<Self, PaperError> {
        let pushes = Pushes { dt, ..Pushes::default() };
        let [training, test] = counts;
        let test = transitions(object, test, seed + FIRST_TEST_SEED, &pushes)?;
        let training = noise.add(&transitions(object, training, seed, &pushes)?, &test, seed);
        Ok(Self { training, test })
    }
}
