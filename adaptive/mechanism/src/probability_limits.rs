//! Upper limits of the probabilities of effects, by what the named effects explain and leave.

use crate::fitted_model::{FittedModel, SearchResult};
use crate::lack_of_fit::{CERTAIN_EXPLANATION, LackOfFit, explanation};
use crate::model::{Effect, Kind};
use crate::problem::Problem;
use crate::rows::noise_floor;
use crate::search::Searcher;
use crate::spurious_effects::is_spurious;

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

/// Limits of each effect that is named. Names that explain a negligible share, that leave more than they explain, or whose
/// absence raises the errors by little, are dropped; the others are judged with them, as is the verdict. Of several names of
/// the last kind, those are dropped that together raise the errors by little.
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
    let (mut named, shares) = searcher.without_spurious_effects(&found.base, best.clone(), &mut found.models);
    let most = |effect: &Effect| {
        let joints = affected.iter().find(|(kind, _)| *kind == effect.kind).map_or(&[][..], |(_, own)| own);
        let left = joints.iter().map(|j| remaining(found, before, after, *j)).fold(0.0, f64::max);
        (1.0 - left).min(explained(problem, found, joints) / CERTAIN_EXPLANATION)
    };
    let limits: Vec<f64> = named.fit.effects.iter().map(most).collect();
    let mut rise = |dropped: &[usize]| {
        searcher.support(&without_effects(searcher, &named, dropped, &mut found.models), &named).share()
    };
    let dropped = improbable(&limits, &mut rise);
    named = without_effects(searcher, &named, &dropped, &mut found.models);
    let is_kept = |k: usize| !dropped.contains(&k);
    found.support = searcher.support_of_all(&named, &mut found.models);
    found.best = named;
    let all = shares.into_iter().zip(limits).enumerate().filter(|(k, _)| is_kept(*k));
    all.map(|(_, (share, most))| ProbabilityLimit { share, most }).collect()
}

/// A model without some of its effects.
fn without_effects(
    searcher: &Searcher<'_>,
    model: &FittedModel,
    effects: &[usize],
    models: &mut Vec<FittedModel>,
) -> FittedModel {
    let mut all = effects.to_vec();
    all.sort_unstable_by(|a, b| b.cmp(a));
    all.iter().fold(model.clone(), |model, k| searcher.without_effect(&model, *k, models))
}

/// The effects that are not named, by the largest probability of each by what remains, and by the rise of the errors, as a
/// share of a certain one, without several effects. Effects that each raise the errors by little may raise them by much together.
fn improbable(limits: &[f64], rise: &mut dyn FnMut(&[usize]) -> f64) -> Vec<usize> {
    let mut dropped: Vec<usize> = vec![];
    loop {
        let kept: Vec<usize> = (0..limits.len()).filter(|k| !dropped.contains(k)).collect();
        let without = |k: usize| [&dropped[..], &[k]].concat();
        let all: Vec<f64> = kept.iter().map(|k| rise(&without(*k)).min(limits[*k])).collect();
        let Some(least) = least_probable(&all) else { return dropped };
        dropped.push(kept[least]);
    }
}

/// The least probable effect by the largest probabilities, if it is more probably wrong than right and another one is not:
/// it is then not named.
fn least_probable(most: &[f64]) -> Option<usize> {
    let least = (0..most.len()).min_by(|a, b| most[*a].total_cmp(&most[*b]))?;
    let others_are_named = most.iter().any(|limit| !is_spurious(*limit));
    (is_spurious(most[least]) && others_are_named).then_some(least)
}

#[cfg(test)]
mod tests {
    use super::{improbable, least_probable};

    #[test]
    fn effects_that_only_together_matter_are_not_all_dropped() {
        let limits = [1.0, 0.9, 0.9];
        // Without one of two effects the errors rise by little, and without both by much.
        let mut rise = |dropped: &[usize]| match dropped {
            [0] => 1.0,
            [_] => 0.3,
            _ => 0.8,
        };
        assert_eq!(improbable(&limits, &mut rise), [1]);
        let mut independent = |dropped: &[usize]| if dropped.contains(&0) { 1.0 } else { 0.3 };
        assert_eq!(improbable(&limits, &mut independent), [1, 2]);
    }

    #[test]
    fn an_improbable_effect_is_named_only_alone() {
        assert_eq!(least_probable(&[0.9, 0.2, 0.4]), Some(1));
        assert_eq!(least_probable(&[0.9, 0.6]), None);
        assert_eq!(least_probable(&[0.3, 0.2]), None);
        assert_eq!(least_probable(&[]), None);
    }
}
