//! Random-walk Metropolis: the predecessor of the paper's method, for comparison.
//!
//! During warm-up, the covariance of the proposal is adapted to the chain (Haario, Saksman & Tamminen 2001),
//! and its scale to an acceptance rate of 0.234 (Roberts & Rosenthal 2001). Both are then fixed, so that the
//! kept draws form one Markov chain with the correct stationary distribution.

use crate::chain::{Chain, ChainSettings, normal};
use crate::{PosteriorError, Whitened};
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use trundle_infer::{InferError, Watch};

/// Target share of accepted proposals.
const TARGET_ACCEPTANCE: f64 = 0.234;

/// Adaptive proposal.
struct Proposal {
    mean: DVector<f64>,
    scatter: DMatrix<f64>,
    count: f64,
    factor: DMatrix<f64>,
    log_scale: f64,
}

impl Proposal {
    fn new(n: usize) -> Self {
        let log_scale = (2.38 / (n as f64).sqrt()).ln();
        let unit = DMatrix::identity(n, n);
        Self { mean: DVector::zeros(n), scatter: unit.clone(), count: 1.0, factor: unit, log_scale }
    }

    fn step(&self, from: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
        let noise = &self.factor * DVector::from_vec(normal(from.len(), rng)) * self.log_scale.exp();
        from.iter().zip(noise.iter()).map(|(a, b)| a + b).collect()
    }

    /// Adapts to the position of the chain and the acceptance probability of the last proposal.
    fn adapt(&mut self, at: &[f64], accepted: f64, step: usize) {
        self.log_scale += (accepted - TARGET_ACCEPTANCE) / (step as f64 + 1.0).powf(0.6);
        let away = DVector::from_column_slice(at) - &self.mean;
        self.count += 1.0;
        self.mean += &away / self.count;
        let left = DVector::from_column_slice(at) - &self.mean;
        self.scatter += &away * left.transpose();
        let covariance = (&self.scatter + self.scatter.transpose()) * (0.5 / self.count);
        if step > 10 * at.len()
            && let Some(factor) = covariance.cholesky()
        {
            self.factor = factor.l();
        }
    }
}

/// Samples one chain from `start`, a point `w`.
pub(crate) fn chain(
    density: &Whitened<'_>,
    start: Vec<f64>,
    settings: &ChainSettings,
    rng: &mut ChaCha8Rng,
    watch: &dyn Watch,
    tick: &(dyn Fn() + Sync),
) -> Result<Chain, PosteriorError> {
    let mut proposal = Proposal::new(start.len());
    let mut cost = density.cost(&start)?;
    let (mut at, mut kept, mut accepted) = (start, Chain::default(), 0.0);
    for step in 0..settings.warmup + settings.draws {
        if watch.cancelled() {
            return Err(InferError::Interrupted.into());
        }
        let trial = proposal.step(&at, rng);
        let trial_cost = density.cost(&trial)?;
        let chance = (cost - trial_cost).exp().min(1.0);
        if rng.random::<f64>() < chance {
            (at, cost) = (trial, trial_cost);
            accepted += if step >= settings.warmup { 1.0 } else { 0.0 };
        }
        if step < settings.warmup {
            proposal.adapt(&at, chance, step);
        } else {
            kept.push(density.point(&at), -cost, false, 1);
        }
        tick();
    }
    kept.step_size = proposal.log_scale.exp();
    kept.warmup_evaluations = settings.warmup as u64;
    kept.acceptance = Some(accepted / settings.draws as f64);
    Ok(kept)
}
