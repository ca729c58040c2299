//! Block bootstrap: the probability that an effect improves the predictive density by more than chance.
//!
//! The log density of each sample is compared between a model with the effect and one without it. Samples
//! with correlated residuals are not independent. Their gains are therefore summed over blocks of at least
//! five correlation times of the residuals (Sokal 1997). Resampling the blocks gives the distribution of the
//! mean gain (bootstrap; Künsch 1989), which need not be normal.
//!
//! The gain of a block is clipped to [`MIN_SIGNIFICANT_GAIN_NATS`] in either direction. Some effects, such as
//! a contact, act for one second in a minute. Their large gain in a single block would otherwise dominate the
//! standard error.

use crate::thresholds::MIN_SIGNIFICANT_GAIN_NATS;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trundle_infer::{Comparison, Fit, InferError, Innovation};

/// Least length of a block, correlation times.
const MIN_CORRELATION_TIMES_PER_BLOCK: f64 = 5.0;
/// Least number of blocks for a conclusion.
const MIN_BLOCKS: usize = 5;
/// Number of bootstrap resamples. The standard error of a probability near 0.95 is then half a per cent.
const RESAMPLES: usize = 2000;

/// A model's prediction of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedSample {
    /// −log density, nats.
    pub cost: f64,
    /// Whitened residual.
    pub residual: [f64; 3],
}

/// Predicted samples of some episodes, in order.
pub type PredictedSamples = Vec<Vec<PredictedSample>>;

/// Probability that `fuller` predicts better than `simpler` on average, from the same samples under both
/// models. `time` is the correlation time of the residuals, in samples. The probability is one half if there
/// are too few blocks.
pub fn probability_of_gain(
    time: f64,
    fuller: &[Vec<PredictedSample>],
    simpler: &[Vec<PredictedSample>],
) -> f64 {
    let size = (MIN_CORRELATION_TIMES_PER_BLOCK * time).ceil() as usize;
    let blocks = |(with, without): (&Vec<PredictedSample>, &Vec<PredictedSample>)| -> Vec<f64> {
        let gains: Vec<f64> = with.iter().zip(without).map(|(w, o)| o.cost - w.cost).collect();
        // The last block contains the remaining samples.
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

/// Bootstrap probability that the mean gain of a block is positive.
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

/// Integrated autocorrelation time of the residuals, in samples: one plus twice the sum of the
/// autocorrelations up to the first that is not positive. Directions and episodes are pooled.
pub fn correlation_time(samples: &[Vec<PredictedSample>]) -> f64 {
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

/// The predicted samples of a fit.
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

    /// Samples with given gains, whose residuals are correlated over `memory` samples.
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

    /// Gains, of which the first `count` are large.
    fn gaining(count: usize, gain: f64) -> Vec<f64> {
        (0..600).map(|k| if k < count { gain } else { 0.02 * (k as f64).sin() }).collect()
    }

    #[test]
    fn one_block_is_no_evidence() {
        assert!(probability_of(&gaining(4, 1e4), 0.1) < 0.95);
    }

    #[test]
    fn a_second_of_contact_is_enough() {
        assert!(probability_of(&gaining(60, 1e3), 0.1) > 0.95);
    }

    #[test]
    fn correlated_residuals_reduce_the_evidence() {
        assert!(probability_of(&gaining(60, 1e3), 60.0) < 0.95);
    }

    #[test]
    fn consistent_gains_are_certain_and_losses_count() {
        let small: Vec<f64> = (0..600).map(|k| 0.3 + (k as f64).sin()).collect();
        assert!(probability_of(&small, 0.1) > 0.99);
        let mixed: Vec<f64> = (0..600).map(|k| if k % 200 < 100 { 1e3 } else { -20.0 }).collect();
        assert!(probability_of(&mixed, 0.1) < 0.8);
    }

    #[test]
    fn the_correlation_time_is_that_of_the_process() {
        let [first_order, _] = samples(&vec![0.0; 100_000], 10.0);
        let decay = (-0.1_f64).exp();
        let expected = (1.0 + decay) / (1.0 - decay);
        assert!((correlation_time(&first_order) / expected - 1.0).abs() < 0.1);
    }

    #[test]
    fn few_blocks_are_inconclusive() {
        assert!((bootstrap_probability(&[1.0; 4]) - 0.5).abs() < 1e-12);
    }
}
