//! Whether an effect improves the predictive density by more than chance, from the densities of single samples.
//!
//! The density of each sample is compared between a model with the effect and one without it. PredictedSamples whose residuals are
//! correlated are no independent evidence: they are summed over blocks of at least five correlation times of the
//! residuals of the fitted model with the effect (Sokal 1997), and the error of the mean gain of a block is found by resampling
//! blocks (the bootstrap; Künsch 1989). No gain is taken to be normal. A block counts at most [`CHANCE`] nats: some effects,
//! like a post that is hit, act for a second in a minute, and what they gain there by thousands would otherwise be the
//! standard error too.

use crate::thresholds::MIN_SIGNIFICANT_GAIN_NATS;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trundle_infer::{Comparison, Fit, InferError, Innovation};

/// Correlation times in a block, at least.
const MIN_CORRELATION_TIMES_PER_BLOCK: f64 = 5.0;
/// Fewest blocks from which anything is concluded.
const MIN_BLOCKS: usize = 5;
/// Times that blocks are drawn anew: a probability near 0.95 is then known to half a per cent.
const RESAMPLES: usize = 2000;

/// A sample as a model predicts it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PredictedSample {
    /// −log density.
    pub cost: f64,
    /// Whitened residual.
    pub residual: [f64; 3],
}

/// The samples of some episodes, each episode's in order.
pub(crate) type PredictedSamples = Vec<Vec<PredictedSample>>;

/// Probability that `fuller` predicts better than `simpler` on average, from the same samples under both, whose residuals
/// have a correlation `time`, samples; one half where there are too few blocks to tell.
pub(crate) fn probability_of_gain(
    time: f64,
    fuller: &[Vec<PredictedSample>],
    simpler: &[Vec<PredictedSample>],
) -> f64 {
    let size = (MIN_CORRELATION_TIMES_PER_BLOCK * time).ceil() as usize;
    let blocks = |(with, without): (&Vec<PredictedSample>, &Vec<PredictedSample>)| -> Vec<f64> {
        let gains: Vec<f64> = with.iter().zip(without).map(|(w, o)| o.cost - w.cost).collect();
        // The last block takes what remains.
        let count = (gains.len() / size).max(1);
        (0..count)
            .map(|k| {
                let end = if k + 1 == count { gains.len() } else { (k + 1) * size };
                gains[k * size..end]
                    .iter()
                    .sum::<f64>()
                    .clamp(-MIN_SIGNIFICANT_GAIN_NATS, MIN_SIGNIFICANT_GAIN_NATS)
            })
            .collect()
    };
    let gains: Vec<f64> =
        fuller.iter().zip(simpler).filter(|(w, _)| !w.is_empty()).flat_map(blocks).collect();
    bootstrap_probability(&gains)
}

/// Probability that the mean of what blocks gain is positive, by drawing blocks anew.
fn bootstrap_probability(gains: &[f64]) -> f64 {
    let n = gains.len();
    if n < MIN_BLOCKS || gains.iter().any(|gain| !gain.is_finite()) {
        return 0.5;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let drawn = |_| (0..n).map(|_| gains[rng.random_range(0..n)]).sum::<f64>() > 0.0;
    let positive = (0..RESAMPLES).map(drawn).filter(|positive| *positive).count();
    positive as f64 / RESAMPLES as f64
}

/// Integrated autocorrelation time of the residuals, samples: one and twice the sum of the autocorrelations up to the first
/// that is not positive, pooled over directions and episodes.
pub(crate) fn correlation_time(samples: &[Vec<PredictedSample>]) -> f64 {
    let longest = samples.iter().map(Vec::len).max().unwrap_or(0);
    let product = |lag: usize| -> f64 {
        let pairs = samples.iter().flat_map(|episode| episode.iter().zip(episode.iter().skip(lag)));
        pairs.map(|(a, b)| Vector3::from(a.residual).dot(&Vector3::from(b.residual))).sum()
    };
    let variance = product(0);
    if variance.is_nan() || variance <= 0.0 {
        return 1.0;
    }
    let positive = (1..longest).map(|lag| product(lag) / variance).take_while(|r| *r > 0.0);
    1.0 + 2.0 * positive.sum::<f64>()
}

/// The samples of a comparison under a fit.
pub(crate) fn predicted_samples(comparison: &Comparison, fit: &Fit) -> Result<PredictedSamples, InferError> {
    match comparison.with_channels(fit.channels) {
        Comparison::Motion(motion) => {
            let one =
                |i: &Innovation| PredictedSample { cost: i.cost, residual: (i.whitener * i.error).into() };
            let all = motion.innovations(&fit.model, &fit.values)?.unwrap_or_default();
            Ok(all.iter().map(|episode| episode.iter().map(one).collect()).collect())
        }
        Comparison::Wrench(wrench) => {
            let constant = wrench.log_normaliser();
            let whitened = wrench.whitened(&fit.model, &fit.values)?;
            let mut episodes: PredictedSamples = vec![];
            let mut last = None;
            for (sample, residual) in wrench.samples().iter().zip(whitened) {
                if last != Some(sample.episode) {
                    episodes.push(vec![]);
                    last = Some(sample.episode);
                }
                let cost = constant + 0.5 * residual.iter().map(|e| e * e).sum::<f64>();
                episodes.last_mut().into_iter().for_each(|own| own.push(PredictedSample { cost, residual }));
            }
            Ok(episodes)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// PredictedSamples with a gain each, of residuals that are correlated over `memory` samples.
    fn samples(gains: &[f64], memory: f64) -> [PredictedSamples; 2] {
        let decay = (-1.0 / memory).exp();
        let mut state = 0.0;
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut residual = || {
            state = decay * state + rng.random_range(-1.0..1.0);
            [state, 0.0, 0.0]
        };
        let with: Vec<_> =
            gains.iter().map(|_| PredictedSample { cost: 0.0, residual: residual() }).collect();
        let without =
            with.iter().zip(gains).map(|(one, gain)| PredictedSample { cost: *gain, ..*one }).collect();
        [vec![with], vec![without]]
    }

    fn probability_of(gains: &[f64], memory: f64) -> f64 {
        let [with, without] = samples(gains, memory);
        probability_of_gain(correlation_time(&with), &with, &without)
    }

    /// Gains of which the first `count` are large.
    fn gaining(count: usize, gain: f64) -> Vec<f64> {
        (0..600).map(|k| if k < count { gain } else { 0.02 * (k as f64).sin() }).collect()
    }

    #[test]
    fn one_block_carries_nothing() {
        assert!(probability_of(&gaining(4, 1e4), 0.1) < 0.95);
    }

    #[test]
    fn a_second_of_contact_is_enough() {
        assert!(probability_of(&gaining(60, 1e3), 0.1) > 0.95);
    }

    #[test]
    fn where_residuals_are_correlated_there_is_less_evidence() {
        assert!(probability_of(&gaining(60, 1e3), 60.0) < 0.95);
    }

    #[test]
    fn gains_everywhere_are_sure_and_what_is_lost_elsewhere_counts() {
        let small: Vec<f64> = (0..600).map(|k| 0.3 + (k as f64).sin()).collect();
        assert!(probability_of(&small, 0.1) > 0.99);
        let mixed: Vec<f64> = (0..600).map(|k| if k % 200 < 100 { 1e3 } else { -20.0 }).collect();
        assert!(probability_of(&mixed, 0.1) < 0.8);
    }

    #[test]
    fn a_correlation_time_is_that_of_the_process() {
        let [first_order, _] = samples(&vec![0.0; 100_000], 10.0);
        let decay = (-0.1_f64).exp();
        let expected = (1.0 + decay) / (1.0 - decay);
        assert!((correlation_time(&first_order) / expected - 1.0).abs() < 0.1);
    }

    #[test]
    fn few_blocks_tell_nothing() {
        assert!((bootstrap_probability(&[1.0; 4]) - 0.5).abs() < 1e-12);
    }
}
