//! Models that explain the data as well as the best one, or almost.

use crate::answer::JointAlternative;
use crate::fitted_model::{FittedModel, SearchResult};
use crate::model::{Kind, label, place};
use crate::problem::Problem;
use crate::search::Searcher;
use trundle_diagnose::MAX_TIE_DIFFERENCE_NATS;

/// Least probability of an alternative that is reported.
const MIN_ALTERNATIVE_PROBABILITY: f64 = 0.005;

/// Posterior weight of every fitted model. Models that are as wrong as the best one are as probable. A set of effects that was
/// fitted repeatedly has the weight of its best fit.
pub(crate) fn posterior_weights(searcher: &Searcher<'_>, found: &SearchResult, times: &[f64]) -> Vec<f64> {
    let least = found.best.log_evidence(times);
    let log = |fitted: &FittedModel| match searcher.is_as_wrong(&found.best, fitted) {
        true => fitted.log_evidence(times).max(least),
        false => fitted.log_evidence(times),
    };
    let logs: Vec<f64> = found.models.iter().map(log).collect();
    let best = logs.iter().copied().fold(least, f64::max);
    let kinds: Vec<Vec<Kind>> = found.models.iter().map(FittedModel::kinds).collect();
    let is_repeated =
        |k: usize| (0..kinds.len()).any(|o| kinds[o] == kinds[k] && o != k && (logs[o], k) > (logs[k], o));
    let weight = |k: usize| if is_repeated(k) { 0.0 } else { (logs[k] - best).exp() };
    let raw: Vec<f64> = (0..logs.len()).map(weight).collect();
    let total: f64 = raw.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    raw.iter().map(|weight| weight / total).collect()
}

/// Share of the weight of models with an effect, among models no larger than the best one.
pub(crate) fn inclusion_probability(found: &SearchResult, weights: &[f64], kind: Kind) -> f64 {
    let most = found.best.fit.effects.len();
    let of = |with: bool| -> f64 {
        let pairs = found.models.iter().zip(weights).filter(|(fitted, _)| fitted.fit.effects.len() <= most);
        pairs.filter(|(fitted, _)| !with || fitted.kinds().contains(&kind)).map(|(_, weight)| weight).sum()
    };
    let all = of(false);
    if all > 0.0 { of(true) / all } else { 1.0 }
}

/// Sets of effects whose models fit as well as the best one, its own first.
pub(crate) fn tied_sets(problem: &Problem, found: &SearchResult, times: &[f64]) -> Vec<Vec<String>> {
    let names = |fitted: &FittedModel| -> Vec<String> {
        fitted.kinds().iter().map(|kind| label(problem, *kind)).collect()
    };
    let best = &found.best;
    if best.fit.effects.is_empty() {
        return vec![];
    }
    let mut sets = vec![names(best)];
    for fitted in &found.models {
        // The data determine no more parameters, and the fit is as good; or the evidence is.
        let close = fitted.fit.cost(times) - best.fit.cost(times) < MAX_TIE_DIFFERENCE_NATS;
        let is_as_simple = fitted.fit.rank < best.fit.rank + 1.0;
        let difference = best.log_evidence(times) - fitted.log_evidence(times);
        let is_like = close && is_as_simple || difference < MAX_TIE_DIFFERENCE_NATS;
        let is_as_many = fitted.fit.effects.len() == best.fit.effects.len();
        if is_like && is_as_many && !sets.contains(&names(fitted)) {
            sets.push(names(fitted));
        }
    }
    sets
}

/// Classes of single effects among tied sets that differ in one effect.
pub(crate) fn single_ties(sets: &[Vec<String>]) -> Vec<Vec<String>> {
    let Some((best, others)) = sets.split_first() else { return vec![] };
    let mut ties: Vec<Vec<String>> = vec![];
    for other in others {
        let own: Vec<&String> = best.iter().filter(|name| !other.contains(name)).collect();
        let new: Vec<&String> = other.iter().filter(|name| !best.contains(name)).collect();
        if let ([own], [new]) = (&own[..], &new[..]) {
            match ties.iter_mut().find(|class| class[0] == **own) {
                Some(class) => class.push((*new).clone()),
                None => ties.push(vec![(*own).clone(), (*new).clone()]),
            }
        }
    }
    ties
}

/// Effects that explain the data almost as well.
pub(crate) fn alternatives(
    problem: &Problem,
    found: &SearchResult,
    weights: &[f64],
) -> Vec<JointAlternative> {
    let own = found.best.kinds();
    let mut all: Vec<JointAlternative> = vec![];
    for (fitted, weight) in found.models.iter().zip(weights) {
        let new: Vec<Kind> = fitted.kinds().into_iter().filter(|kind| !own.contains(kind)).collect();
        let [kind] = new[..] else { continue };
        if fitted.fit.effects.len() > own.len() || *weight < MIN_ALTERNATIVE_PROBABILITY {
            continue;
        }
        let found_place = place(problem, kind);
        if all.iter().all(|one| one.effect != kind.effect() || one.place != found_place) {
            all.push(JointAlternative {
                effect: kind.effect().to_owned(),
                probability: *weight,
                experiment: kind.spec().experiment.to_owned(),
                place: found_place,
            });
        }
    }
    all.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    all
}

#[cfg(test)]
mod tests {
    use super::posterior_weights;
    use crate::cross_validation::LeftOut;
    use crate::fit::fit;
    use crate::fitted_model::{FittedModel, SearchResult};
    use crate::laws::JointKind;
    use crate::model::{Effect, Kind};
    use crate::rows::{Scope, noise_floor, tests::carriage};
    use crate::search::Searcher;
    use trundle_infer::Quiet;

    #[test]
    fn a_set_that_was_fitted_repeatedly_counts_once() {
        let problem = carriage("joint", Some(|t| -4.0 * (3.0 * t).sin()));
        let searcher = Searcher::new(&problem, &[], &Quiet);
        let with_effect = |kind: JointKind| -> FittedModel {
            let effects = [Effect { kind: Kind::Joint(kind, 0), values: vec![0.1] }];
            searcher.cross_validated(fit(&problem, &effects, None, Scope::Training, 0))
        };
        let (one, other) = (with_effect(JointKind::ViscousFriction), with_effect(JointKind::AirDrag));
        let of = |models: Vec<FittedModel>| {
            let found = SearchResult { base: one.clone(), best: one.clone(), support: vec![], models };
            posterior_weights(&searcher, &found, &searcher.times(&one))
        };
        let once = of(vec![one.clone(), other.clone()]);
        let thrice = of(vec![one.clone(), other.clone(), one.clone(), one.clone()]);
        assert_eq!(thrice, [once[0], once[1], 0.0, 0.0]);
    }

    #[test]
    fn models_are_as_wrong_if_the_errors_exceed_the_noise_and_are_alike() {
        let problem = carriage("joint", Some(|t| -4.0 * (3.0 * t).sin()));
        let searcher = Searcher::new(&problem, &[], &Quiet);
        // A model with one effect, and left-out errors of a multiple of the noise.
        let with_effect = |kind: JointKind, noises: f64| -> FittedModel {
            let effects = [Effect { kind: Kind::Joint(kind, 0), values: vec![0.1] }];
            let mut found = searcher.cross_validated(fit(&problem, &effects, None, Scope::Training, 0));
            let size = noises * noise_floor(&problem, 0);
            found.fit.sd[0] = size;
            found.left_out = LeftOut { residuals: vec![vec![vec![size; 20]]] };
            found
        };
        let (one, other) = (JointKind::ViscousFriction, JointKind::AirDrag);
        for (best, competitor, expected) in
            [(5.0, 5.5, true), (5.0, 5.7, false), (5.0, 1.0, true), (1.9, 1.9, false)]
        {
            let found = searcher.is_as_wrong(&with_effect(one, best), &with_effect(other, competitor));
            assert_eq!(found, expected, "{best} {competitor}");
        }
        assert!(!searcher.is_as_wrong(&with_effect(one, 5.0), &with_effect(one, 5.0)));
    }
}
