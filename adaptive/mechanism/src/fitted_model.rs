//! A fitted model of the search, and what the tests of effects found.

use crate::cross_validation::LeftOut;
use crate::fit::Fit;
use crate::model::Kind;
use trundle_diagnose::{MIN_EFFECT_PROBABILITY, MIN_MATERIAL_ERROR_RATIO};

/// Ratio of the errors without and with an effect from which it is certain: that of a material effect in the benchmark. An
/// effect that lowers them less may only correct the form of another one.
const CERTAIN_ERROR_RATIO: f64 = 2.0;

/// A fitted model with its predictions of left-out parts.
#[derive(Clone, Debug)]
pub(crate) struct FittedModel {
    pub fit: Fit,
    pub left_out: LeftOut,
    /// Logarithmic prior probability of its effects among as many.
    pub log_prior: f64,
}

impl FittedModel {
    pub fn kinds(&self) -> Vec<Kind> {
        let mut kinds: Vec<Kind> = self.fit.effects.iter().map(|e| e.kind).collect();
        kinds.sort();
        kinds
    }

    /// Log evidence by the Bayesian information criterion (Schwarz 1978), with the prior of its effects; `time` as in
    /// [`Fit::cost`].
    pub fn log_evidence(&self, time: &[f64]) -> f64 {
        let samples: f64 = (0..time.len()).map(|j| self.fit.samples[j] as f64 / time[j]).sum();
        self.log_prior - self.fit.cost(time) - 0.5 * self.fit.rank * samples.max(1.0).ln()
    }
}

/// What the tests of an effect found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Support {
    /// Probability that the effect improves the prediction of left-out parts.
    pub probability: f64,
    /// Ratio of the squared errors without and with it.
    pub error_ratio: f64,
    /// Whether a reduction of the noise may explain that.
    pub may_be_noise: bool,
}

impl Support {
    pub fn is_certain(self) -> bool {
        self.probability >= MIN_EFFECT_PROBABILITY
    }

    pub fn is_material(self) -> bool {
        self.error_ratio >= MIN_MATERIAL_ERROR_RATIO
    }

    pub fn passes(self) -> bool {
        self.is_certain() && self.is_material() && !self.may_be_noise
    }

    /// Rise of the errors without the effect, as a share of that of a certain one.
    pub fn share(self) -> f64 {
        ((self.error_ratio.sqrt() - 1.0) / (CERTAIN_ERROR_RATIO - 1.0)).clamp(0.0, 1.0)
    }
}

/// Result of the search.
pub(crate) struct SearchResult {
    pub base: FittedModel,
    pub best: FittedModel,
    /// Support of each effect of the best model.
    pub support: Vec<Support>,
    /// All models that were fitted to their optimum.
    pub models: Vec<FittedModel>,
}

#[cfg(test)]
mod tests {
    use super::Support;

    #[test]
    fn effects_without_which_errors_double_are_certain() {
        for (errors, share) in [(1.0, 0.0), (1.5, 0.5), (2.0, 1.0), (9.0, 1.0)] {
            let support = Support { probability: 1.0, error_ratio: errors * errors, may_be_noise: false };
            assert!((support.share() - share).abs() < 1e-12, "{errors}: {}", support.share());
        }
    }
}
