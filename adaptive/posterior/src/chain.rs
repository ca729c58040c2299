//! Chains of draws and the three sampling methods.

use crate::{PosteriorError, Whitened, metropolis, nuts};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use trundle_infer::Watch;

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

/// Samples one chain. Chains are assigned to the modes in turn, and each starts from a point that is
/// overdispersed relative to the posterior. Laplace draws come from all modes, according to their weights.
///
/// # Errors
/// When the density fails, or the user interrupts.
pub(crate) fn chain(
    method: Method,
    modes: &[(Whitened<'_>, f64)],
    settings: &ChainSettings,
    watch: &dyn Watch,
    tick: &(dyn Fn() + Sync),
) -> Result<Chain, PosteriorError> {
    let mut rng = settings.rng();
    let density = &modes[settings.chain % modes.len()].0;
    match method {
        Method::Laplace => Ok(laplace(modes, settings, &mut rng, tick)),
        Method::Nuts => {
            nuts::chain(density, overdispersed(density, &mut rng)?, settings, &mut rng, watch, tick)
        }
        Method::Metropolis => {
            metropolis::chain(density, overdispersed(density, &mut rng)?, settings, &mut rng, watch, tick)
        }
    }
}

/// A standard normal point.
pub(crate) fn normal(n: usize, rng: &mut ChaCha8Rng) -> Vec<f64> {
    (0..n).map(|_| rng.sample(StandardNormal)).collect()
}

/// A start twice as far out as a draw of the Laplace approximation; nearer where the density cannot be
/// evaluated.
fn overdispersed(density: &Whitened<'_>, rng: &mut ChaCha8Rng) -> Result<Vec<f64>, PosteriorError> {
    const START_SPREAD: f64 = 2.0;
    const MAX_TRIES: usize = 12;
    let direction = normal(density.dimension(), rng);
    let mut spread = START_SPREAD;
    for _ in 0..MAX_TRIES {
        let start: Vec<f64> = direction.iter().map(|d| d * spread).collect();
        if density.cost(&start)?.is_finite() {
            return Ok(start);
        }
        spread /= 2.0;
    }
    Ok(vec![0.0; density.dimension()])
}

fn laplace(
    modes: &[(Whitened<'_>, f64)],
    settings: &ChainSettings,
    rng: &mut ChaCha8Rng,
    tick: &(dyn Fn() + Sync),
) -> Chain {
    let mut chain = Chain { step_size: 1.0, acceptance: Some(1.0), ..Chain::default() };
    for _ in 0..settings.draws {
        let mut left: f64 = rng.random();
        let chosen = modes.iter().position(|(_, weight)| {
            left -= weight;
            left < 0.0
        });
        let (density, weight) = &modes[chosen.unwrap_or(0)];
        let w = normal(density.dimension(), rng);
        let log_density = weight.ln() - 0.5 * w.iter().map(|x| x * x).sum::<f64>();
        chain.push(density.point(&w), log_density, false, 0);
        tick();
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_densities::{Banana, Gaussian};
    use trundle_infer::{Density, Quiet};

    /// Means and variances over four chains.
    fn moments(method: Method, density: &dyn Density, precision: &nalgebra::DMatrix<f64>) -> Vec<(f64, f64)> {
        let n = density.dimension();
        let white = [(Whitened::new(density, &vec![0.0; n], precision), 1.0)];
        let mut points = vec![];
        for k in 0..4 {
            let settings = ChainSettings { warmup: 500, draws: 4000, seed: 1, chain: k };
            points.extend(chain(method, &white, &settings, &Quiet, &|| ()).unwrap().points);
        }
        let count = points.len() as f64;
        let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / count;
        let variance = |k: usize, m: f64| points.iter().map(|p| (p[k] - m).powi(2)).sum::<f64>() / count;
        (0..n).map(|k| (mean(k), variance(k, mean(k)))).collect()
    }

    #[test]
    fn every_sampler_finds_the_moments_of_a_normal() {
        let density = Gaussian::correlated(3, 0.8);
        for (name, method) in Method::ALL {
            for (mean, variance) in moments(method, &density, &density.precision) {
                assert!(mean.abs() < 0.08 && (variance - 1.0).abs() < 0.12, "{name}: {mean} {variance}");
            }
        }
    }

    #[test]
    fn samplers_are_correct_for_a_skewed_density_with_a_biased_gradient() {
        // x standard normal, y about x²/2: mean ½, variance 1 + ½.
        for wrong in [1.0, 1.25] {
            for method in [Method::Nuts, Method::Metropolis] {
                let found = moments(method, &Banana { wrong }, &nalgebra::DMatrix::identity(2, 2));
                let [(mean_x, variance_x), (mean_y, variance_y)] = [found[0], found[1]];
                assert!(
                    mean_x.abs() < 0.1 && (variance_x - 1.0).abs() < 0.15,
                    "{wrong} {method:?} {found:?}"
                );
                assert!(
                    (mean_y - 0.5).abs() < 0.1 && (variance_y - 1.5).abs() < 0.3,
                    "{wrong} {method:?} {found:?}"
                );
            }
        }
    }
}
