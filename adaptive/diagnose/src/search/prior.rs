//! Prior over sets of effects, and posterior over the fitted models.

use crate::fitted_model::FittedModel;

/// Prior probability that an effect is missing from a simulation, and that a second one is missing if one is.
const P_MISSING_EFFECT: f64 = 0.05;

/// Log prior probability of a set of effects relative to the empty set. It is geometric in the number of
/// effects, and uniform over the sets of one size.
pub(super) fn log_prior(effects: usize, offered: usize) -> f64 {
    let one = |k: usize| {
        let sets = offered.saturating_sub(k).max(1) as f64 / (k + 1) as f64;
        P_MISSING_EFFECT.ln() - sets.ln()
    };
    (0..effects).map(one).sum()
}

/// Posterior probability of each fitted model. The first `rejected` models have probability zero.
pub(crate) fn probabilities(models: &[FittedModel], rejected: usize) -> Vec<f64> {
    let best = models.iter().skip(rejected).map(FittedModel::log_weight).fold(f64::NEG_INFINITY, f64::max);
    let weight =
        |(k, t): (usize, &FittedModel)| if k < rejected { 0.0 } else { (t.log_weight() - best).exp() };
    let weights: Vec<f64> = models.iter().enumerate().map(weight).collect();
    let total: f64 = weights.iter().sum();
    weights.iter().map(|w| w / total).collect()
}

#[cfg(test)]
mod tests {
    use super::{P_MISSING_EFFECT, log_prior};

    #[test]
    fn sets_of_one_size_share_the_prior_of_that_size() {
        // Of 30 effects there are 435 pairs, which together have the prior probability of two missing
        // effects.
        let pair = 435.0 * log_prior(2, 30).exp();
        assert!((pair - P_MISSING_EFFECT * P_MISSING_EFFECT).abs() < 1e-12, "{pair}");
        assert!((30.0 * log_prior(1, 30).exp() - P_MISSING_EFFECT).abs() < 1e-12);
        assert!(log_prior(0, 30).abs() < 1e-12);
    }
}
