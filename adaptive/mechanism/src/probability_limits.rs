//! Upper limits of the probabilities of effects, by what the named effects explain and leave.

use crate::fitted_model::{FittedModel, SearchResult};
use crate::lack_of_fit::{CERTAIN_EXPLANATION, LackOfFit, explanation};
use crate::model::{Effect, Kind};
use crate::problem::Problem;
use crate::rows::noise_floor;
use crate::search::Searcher;

/// Share of a joint's misfit beyond noise that remains with the effects.
pub(crate) fn remaining(found: &SearchResult, before: &[LackOfFit], after: &[LackOfFit], j: usize) -> f64 {
    let square = |fitted: &FittedModel| fitted.left_out.mean_square(j, fitted.fit.sd[j]);
    let gained = (square(&found.base) - square(&found.best)).max(0.0);
    let missing = before[j].mean_square.max(gained + after[j].mean_square);
    if missing > 0.0 { after[j].mean_square.max(0.0) / missing } else { 0.0 }
}

/// How far the best model reduces the misfit of joints towards the noise: their geometric mean.
pub(crate) fn explained(problem: &Problem, found: &SearchResult, joints: &[usize]) -> f64 {
    let mean = |of: &dyn Fn(usize) -> f64| joints.iter().map(|j| of(*j).ln()).sum::<f64>().exp();
    let size = |fitted: &FittedModel| mean(&|j| fitted.left_out.mean_square(j, fitted.fit.sd[j]).sqrt());
    explanation([size(&found.base), size(&found.best)], mean(&|j| noise_floor(problem, j)))
}

/// Limits of an effect's probability.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProbabilityLimit {
    /// Its share in what was missing, see [`crate::spurious_effects`]: a factor.
    pub share: f64,
    /// Largest probability by what the effects leave.
    pub most: f64,
}

/// Limits of each effect that is named. Names that explain a negligible share are dropped; the others are judged
/// with them, as is the verdict.
pub(crate) fn probability_limits(
    problem: &Problem,
    searcher: &Searcher<'_>,
    found: &mut SearchResult,
    [before, after]: [&[LackOfFit]; 2],
) -> Vec<ProbabilityLimit> {
    let best = found.best.clone();
    // Effects that leave much of the misfit are less probably the right ones. Without a gain, the masses may move the misfit to
    // another joint.
    let own =
        |k: usize, models: &mut Vec<FittedModel>| match searcher.coupling.acts_on(best.fit.effects[k].kind) {
            Some(joints) if joints.len() == 1 => joints,
            Some(joints) => {
                let reduced = searcher.material_joints(&found.base, &best);
                joints.into_iter().filter(|j| reduced.contains(j)).collect()
            }
            None => searcher.material_joints(&searcher.without_effect(&best, k, models), &best),
        };
    let affected: Vec<(Kind, Vec<usize>)> =
        (0..best.fit.effects.len()).map(|k| (best.fit.effects[k].kind, own(k, &mut found.models))).collect();
    let (named, shares) = searcher.without_spurious_effects(&found.base, best.clone(), &mut found.models);
    let limit = |(effect, share): (&Effect, &f64)| {
        let joints = affected.iter().find(|(kind, _)| *kind == effect.kind).map_or(&[][..], |(_, own)| own);
        let left = joints.iter().map(|j| remaining(found, before, after, *j)).fold(0.0, f64::max);
        let most = (1.0 - left).min(explained(problem, found, joints) / CERTAIN_EXPLANATION);
        ProbabilityLimit { share: *share, most }
    };
    let limits = named.fit.effects.iter().zip(&shares).map(limit).collect();
    if named.fit.effects.len() < best.fit.effects.len() {
        found.support = searcher.support_of_all(&named, &mut found.models);
        found.best = named;
    }
    limits
}
