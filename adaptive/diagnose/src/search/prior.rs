//! The prior over sets of effects, and the posterior over the models that were tried.

use crate::engine::FittedModel;

/// Share of simulations that lack an effect; of those that lack some, the share that lack one more.
const P_MISSING_EFFECT: f64 = 0.05;

/// Log prior probability of a set of effects, less that of none: geometric in their number, and uniform over the sets of
/// that size of the effects that were offered.
pub(super) fn log_prior(effects: usize, offered: usize) -> f64 {
    let one = |k: usize| {
        let sets = offered.saturating_sub(k).max(1) as f64 / (k + 1) as f64;
        P_MISSING_EFFECT.ln() - sets.ln()
    };
    (0..effects).map(one).sum()
}

/// Probability of each model among those tried, the first `rejected` of which are out of the question.
pub(crate) fn probabilities(tried: &[FittedModel], rejected: usize) -> Vec<f64> {
    let best = tried.iter().skip(rejected).map(FittedModel::log_weight).fold(f64::NEG_INFINITY, f64::max);
    let weight =
        |(k, t): (usize, &FittedModel)| if k < rejected { 0.0 } else { (t.log_weight() - best).exp() };
    let weights: Vec<f64> = tried.iter().enumerate().map(weight).collect();
    let total: f64 = weights.iter().sum();
    weights.iter().map(|w| w / total).collect()
}

#[cfg(test)]
mod tests {
    use super::{P_MISSING_EFFECT, log_prior};

    #[test]
    fn sets_of_one_size_share_the_prior_of_that_size() {
        // Of 30 effects there are 435 pairs, together as probable as one effect times the share that lack one more.
        let pair = 435.0 * log_prior(2, 30).exp();
        assert!((pair - P_MISSING_EFFECT * P_MISSING_EFFECT).abs() < 1e-12, "{pair}");
        assert!((30.0 * log_prior(1, 30).exp() - P_MISSING_EFFECT).abs() < 1e-12);
        assert!(log_prior(0, 30).abs() < 1e-12);
    }
}
