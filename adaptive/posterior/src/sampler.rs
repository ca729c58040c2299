//! The three sampling methods.

use crate::chain::{Chain, ChainSettings, Method, normal};
use crate::{PosteriorError, Whitened, metropolis, nuts};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use trundle_infer::Watch;

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
