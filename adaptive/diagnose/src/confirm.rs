//! Whether an effect holds up block by block, so that no single stretch carries it.
//!
//! Samples depend on one another, blocks of episodes much less: the paired differences of two
//! models' log predictive densities over blocks have an honest standard error. A block counts at most [`CHANCE`] nats:
//! some effects, like a post that is hit, act for a second in a minute, and what they gain there by thousands would
//! otherwise be the standard error too.

use crate::engine::{Engine, Tried};
use crate::thresholds::CHANCE;
use statrs::distribution::{ContinuousCDF, StudentsT};
use trundle_infer::{Comparison, Fit, InferError, Likelihood};

/// Blocks into which an episode is cut, of motion and of slow pushes.
const BLOCKS: usize = 20;
const SLOW_BLOCKS: usize = 5;

/// Probability, from the paired block differences, that `fuller` predicts better than `simpler`.
pub(crate) fn holds_up(engine: &dyn Engine, fuller: &Tried, simpler: &Tried) -> Result<f64, InferError> {
    let with = engine.blocks(fuller)?;
    let without = engine.blocks(simpler)?;
    let differences: Vec<f64> = without.iter().zip(&with).map(|(a, b)| a - b).collect();
    // Each extra parameter buys half a nat by chance.
    let (more, fewer) = (fuller.fit.estimates.len(), simpler.fit.estimates.len());
    Ok(chance(&differences, 0.5 * more.saturating_sub(fewer) as f64))
}

/// Probability, from what each block gained, nats, that the mean gain is positive, `bought` of all of it by chance.
fn chance(gains: &[f64], bought: f64) -> f64 {
    let gains: Vec<f64> = gains.iter().map(|gain| gain.clamp(-CHANCE, CHANCE)).collect();
    let n = gains.len() as f64;
    if gains.len() < 3 {
        return 0.5;
    }
    let mean = (gains.iter().sum::<f64>() - bought) / n;
    let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let t = mean / (variance / n).sqrt().max(1e-12);
    StudentsT::new(0.0, 1.0, n - 1.0).map_or(0.5, |d| d.cdf(t))
}

/// Fewest wrench samples of a block: neighbours within a second or so depend on one another.
const SMALLEST: usize = 5;

/// Costs of the samples of one episode, summed over successive blocks.
pub(crate) fn in_blocks(costs: &[f64]) -> Vec<f64> {
    let size = costs.len().div_ceil(BLOCKS).max(1);
    costs.chunks(size).map(|block| block.iter().sum()).collect()
}

/// Costs of successive blocks.
pub(crate) fn blocks(comparison: &Comparison, fit: &Fit) -> Result<Vec<f64>, InferError> {
    match comparison.with_channels(fit.channels) {
        Comparison::Motion(motion) => {
            let Some(all) = motion.innovations(&fit.model, &fit.values)? else { return Ok(vec![]) };
            let costs = |episode: &Vec<trundle_infer::Innovation>| -> Vec<f64> {
                episode.iter().map(|innovation| innovation.cost).collect()
            };
            Ok(all.iter().flat_map(|episode| in_blocks(&costs(episode))).collect())
        }
        Comparison::Wrench(wrench) => {
            let mut episodes: Vec<usize> = wrench.samples().iter().map(|s| s.episode).collect();
            episodes.dedup();
            let mut costs = Vec::new();
            for episode in episodes {
                let own = wrench.only(|k| k == episode);
                let size = own.samples().len().div_ceil(SLOW_BLOCKS).max(SMALLEST);
                for block in own.samples().chunks(size) {
                    costs.push(own.over(block).cost(&fit.model, &fit.values)?);
                }
            }
            Ok(costs)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::chance;

    /// Blocks of which the first `count` gain.
    fn gaining(count: usize, gain: f64) -> Vec<f64> {
        (0..120).map(|k| if k < count { gain } else { 0.1 * (k as f64).sin() }).collect()
    }

    #[test]
    fn one_stretch_carries_nothing() {
        assert!(chance(&gaining(1, 1e4), 1.0) < 0.95);
    }

    #[test]
    fn a_second_of_contact_is_enough() {
        assert!(chance(&gaining(4, 1e3), 1.0) > 0.95);
    }

    #[test]
    fn gains_everywhere_are_sure_and_what_is_lost_elsewhere_counts() {
        let small: Vec<f64> = (0..120).map(|k| 0.3 + (k as f64).sin()).collect();
        assert!(chance(&small, 2.0) > 0.99);
        let torn: Vec<f64> = (0..120).map(|k| if k % 2 == 0 { 1e3 } else { -20.0 }).collect();
        assert!(chance(&torn, 0.0) < 0.6);
    }
}
