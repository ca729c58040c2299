//! Spurious effects: laws that only correct the idealised form of another law.
//!
//! A law with an idealised form does not explain a small part of its effect. If the noise is smaller, another law fits that part
//! with certainty, although it does not act. Effects that explain a negligible share of what was missing are therefore
//! detectable but not named, unless no more than noise remains: a spurious effect leaves a part of what it imitates.

use crate::fitted_model::FittedModel;
use crate::lack_of_fit::{CERTAIN_EXPLANATION, explanation};
use crate::rows::noise_floor;
use crate::search::Searcher;
use trundle_diagnose::{MIN_MATERIAL_ERROR_RATIO, NEGLIGIBLE_SHARE};

/// Share in what was missing, in units of a negligible one, below which an effect is not named: it is then more probably a
/// correction of another law.
const MIN_NAMED_SHARE: f64 = 0.5;

impl Searcher<'_> {
    /// Joints at which the errors rise by a material ratio without an effect.
    pub fn material_joints(&self, simpler: &FittedModel, fuller: &FittedModel) -> Vec<usize> {
        let rises = |j: &usize| square(simpler, *j) >= MIN_MATERIAL_ERROR_RATIO * square(fuller, *j);
        self.affected(simpler, fuller).into_iter().filter(rises).collect()
    }

    /// Largest probability of what `fuller` has in addition to `simpler`, by its share in what was missing at the joints where
    /// it is material, or by how near to the noise it comes there.
    pub fn share_limit(&self, base: &FittedModel, simpler: &FittedModel, fuller: &FittedModel) -> f64 {
        let joints = self.material_joints(simpler, fuller);
        let own = |&j: &usize| {
            let squares = [base, simpler, fuller].map(|fitted| square(fitted, j));
            share_limit(squares)
                .max(noise_limit([squares[1], squares[2]].map(f64::sqrt), noise_floor(self.problem, j)))
        };
        joints.iter().map(own).reduce(f64::max).unwrap_or(1.0)
    }

    /// The model without spurious effects, which are removed in the order of their shares, and the largest probability of each
    /// remaining effect.
    pub fn without_spurious_effects(
        &self,
        base: &FittedModel,
        mut model: FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> (FittedModel, Vec<f64>) {
        loop {
            let limit = |k: usize| {
                let simpler = self.without_effect(&model, k, models);
                self.share_limit(base, &simpler, &model)
            };
            let limits: Vec<f64> = (0..model.fit.effects.len()).map(limit).collect();
            let least = (0..limits.len()).min_by(|a, b| limits[*a].total_cmp(&limits[*b]));
            match least {
                Some(k) if is_spurious(limits[k]) => model = self.without_effect(&model, k, models),
                _ => return (model, limits),
            }
        }
    }
}

/// Whether an effect with a largest probability is not named.
pub(crate) fn is_spurious(limit: f64) -> bool {
    limit < MIN_NAMED_SHARE
}

/// Mean square of the left-out errors of a joint.
fn square(fitted: &FittedModel, j: usize) -> f64 {
    fitted.left_out.mean_square(j, fitted.fit.sd[j])
}

/// Largest probability of an effect by the mean squares of the nominal model, without the effect, and with it: its share in what
/// was missing, in units of a negligible one.
fn share_limit([nominal, without, with]: [f64; 3]) -> f64 {
    let (missing, gained) = (nominal - with, without - with);
    if gained < missing { (gained / missing / NEGLIGIBLE_SHARE).clamp(0.0, 1.0) } else { 1.0 }
}

/// Largest probability of an effect by the errors without and with it: certain if only noise remains, and zero if it explains
/// no more than a lone effect must.
fn noise_limit(errors: [f64; 2], noise: f64) -> f64 {
    ((explanation(errors, noise) - CERTAIN_EXPLANATION) / (1.0 - CERTAIN_EXPLANATION)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::{is_spurious, noise_limit, share_limit};

    #[test]
    fn effects_of_thousandths_of_what_was_missing_are_spurious() {
        // A lone effect explains all; errors far above the noise do not make a small share larger.
        for (squares, limit) in
            [([50.0, 50.0, 1.0], 1.0), ([1001.0, 21.0, 1.0], 1.0), ([1001.0, 9.0, 1.0], 0.8)]
        {
            assert!((share_limit(squares) - limit).abs() < 1e-12, "{squares:?}: {}", share_limit(squares));
        }
        assert!(is_spurious(share_limit([65001.0, 40.0, 1.0])));
        assert!(!is_spurious(share_limit([1.0, 2.0, 1.0])));
    }

    #[test]
    fn a_small_effect_that_leaves_only_noise_is_named() {
        assert_eq!(noise_limit([8.0, 0.9], 1.0), 1.0);
        assert!(!is_spurious(noise_limit([8.0, 1.2], 1.0)));
        // A play whose drive is modelled too simply, and a tilt of the base that imitates the rest.
        assert!(is_spurious(noise_limit([2.0, 1.3], 1.0)));
    }
}
