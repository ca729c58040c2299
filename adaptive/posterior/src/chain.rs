//! Chains of draws.

use crate::PosteriorError;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

/// Sampling method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// No-U-Turn sampler (Hoffman & Gelman 2014, implemented by nuts-rs).
    Nuts,
    /// Independent draws of the normal approximation at the mode.
    #[default]
    Laplace,
    /// Random-walk Metropolis with a proposal adapted during warm-up (Haario 2001).
    Metropolis,
}

impl Method {
    /// All methods by name.
    pub const ALL: [(&'static str, Self); 3] =
        [("nuts", Self::Nuts), ("laplace", Self::Laplace), ("metropolis", Self::Metropolis)];

    /// The method with a name.
    ///
    /// # Errors
    /// If there is no such method.
    pub fn named(name: &str) -> Result<Self, PosteriorError> {
        let known = Self::ALL.iter().find(|(known, _)| *known == name);
        known.map(|(_, method)| *method).ok_or_else(|| PosteriorError::UnknownMethod {
            name: name.to_owned(),
            known: Self::ALL.map(|(name, _)| name).join(", "),
        })
    }

    /// Name of the method.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nuts => "nuts",
            Self::Laplace => "laplace",
            Self::Metropolis => "metropolis",
        }
    }
}

/// Length and random numbers of a chain.
#[derive(Clone, Copy, Debug)]
pub struct ChainSettings {
    /// Number of draws that tune the sampler and are discarded.
    pub warmup: usize,
    /// Number of draws that are kept.
    pub draws: usize,
    /// Seed of the whole run.
    pub seed: u64,
    /// Index of the chain: its stream of random numbers.
    pub chain: usize,
}

impl ChainSettings {
    /// Random numbers of the chain, independent of the other chains.
    pub(crate) fn rng(&self) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(self.chain as u64 + 1);
        rng
    }
}

/// Draws of one chain; the lists have one entry for each draw.
#[derive(Clone, Debug, Default)]
pub struct Chain {
    /// Points `z`.
    pub points: Vec<Vec<f64>>,
    /// Log posterior density, not normalised.
    pub log_density: Vec<f64>,
    /// Whether the trajectory diverged (NUTS).
    pub diverging: Vec<bool>,
    /// Number of density evaluations for the draw.
    pub evaluations: Vec<u64>,
    /// Step of the leapfrog integrator, or scale of the random walk, in standard deviations.
    pub step_size: f64,
    /// Number of density evaluations during warm-up.
    pub warmup_evaluations: u64,
    /// Share of accepted proposals; one for independent draws, `None` for NUTS.
    pub acceptance: Option<f64>,
}

impl Chain {
    pub(crate) fn push(&mut self, point: Vec<f64>, log_density: f64, diverging: bool, evaluations: u64) {
        self.points.push(point);
        self.log_density.push(log_density);
        self.diverging.push(diverging);
        self.evaluations.push(evaluations);
    }
}

/// A standard normal point.
pub(crate) fn normal(n: usize, rng: &mut ChaCha8Rng) -> Vec<f64> {
    (0..n).map(|_| rng.sample(StandardNormal)).collect()
}
