//! Models that explain the data as well or almost as well: ties with their certificates, alternatives, and
//! discriminating experiments.

use crate::answer::Alternative;
use crate::candidates::name;
use crate::design::{Certificate, Experiment};
use crate::engine::Engine;
use crate::fitted_model::FittedModel;
use crate::search::SearchResult;
use crate::thresholds::MAX_TIE_DIFFERENCE_NATS;
use trundle_infer::{InferError, Watch};
use trundle_model::Effect;

/// Difference of log weight below which two models are undecided: odds of 20 to 1.
const MAX_UNDECIDED_LOG_ODDS: f64 = 3.0;
/// Most alternatives that are reported.
const MAX_ALTERNATIVES: usize = 5;
/// Most alternatives for which an experiment is designed. The others get the experiment from the catalogue.
const MAX_DESIGNED_EXPERIMENTS: usize = 2;
/// Least probability of an alternative for which an experiment is designed. The recording excludes less
/// probable ones.
const MIN_DESIGN_PROBABILITY: f64 = 1e-3;

/// Models that compete with the selected one.
#[derive(Clone, Debug, Default)]
pub(crate) struct CompetingModels {
    /// Sets of single effects that are indistinguishable.
    pub tied: Vec<Vec<String>>,
    /// Classes of effect sets that are indistinguishable and differ in more than one effect. The named set
    /// comes first.
    pub tied_sets: Vec<Vec<Vec<String>>>,
    /// A certificate for each tied pair of models.
    pub certificates: Vec<Certificate>,
    /// The best models with other effects than the named ones.
    pub alternatives: Vec<Alternative>,
    /// Discriminating experiments for the best alternatives.
    pub experiments: Vec<Experiment>,
}

/// Find the models that compete with the selected one. With `designing`, also design experiments for the best
/// alternatives.
///
/// # Errors
/// If the user interrupts.
pub(crate) fn competing_models(
    engine: &dyn Engine,
    (found, probabilities): (&SearchResult, &[f64]),
    best: &FittedModel,
    designing: bool,
    watch: &dyn Watch,
) -> Result<CompetingModels, InferError> {
    let pairs = pairs(engine, found, best)?;
    let mut competing_models = CompetingModels {
        tied: ties(&pairs, best),
        tied_sets: tied_sets(found, best),
        certificates: pairs.iter().map(|pair| pair.certificate.clone()).collect(),
        ..CompetingModels::default()
    };
    let mut attempts = 0;
    for (fitted, probability) in alternatives(found, probabilities, best) {
        let effect = fitted.names().join(" + ");
        let is_possible =
            probability > MIN_DESIGN_PROBABILITY || pairs.iter().any(|pair| same_kinds(pair.other, fitted));
        let mut text = catalogue_experiment(found, fitted, best);
        if designing && is_possible && attempts < MAX_DESIGNED_EXPERIMENTS {
            attempts += 1;
            let names = [&*own_name(best, fitted), &*effect];
            let experiment = engine.experiment(names, [best, fitted], &best.fit.channels, watch)?;
            if let Some(experiment) = experiment.filter(Experiment::is_informative) {
                text.clone_from(&experiment.sentence);
                competing_models.experiments.push(experiment);
            }
        }
        competing_models.alternatives.push(Alternative { effect, probability, experiment: text });
    }
    Ok(competing_models)
}

/// An effect of a model and an indistinguishable replacement.
struct TiedPair<'a> {
    own_effect: &'a Effect,
    other_effect: &'a Effect,
    other: &'a FittedModel,
    certificate: Certificate,
}

/// Pairs of an effect of the best model and a replacement for it that the data do not exclude. All forms of
/// both models count, with and without refinements.
///
/// Two models are a pair if they fit equally well with as many parameters, or if their motions agree within
/// noise. The best forms of both are also a pair if neither is 20 times as probable as the other.
fn pairs<'a>(
    engine: &dyn Engine,
    found: &'a SearchResult,
    best: &'a FittedModel,
) -> Result<Vec<TiedPair<'a>>, InferError> {
    let mut pairs: Vec<TiedPair> = Vec::new();
    for own in found.models.iter().filter(|t| same_kinds(t, best)) {
        for other in found.models.iter().filter(|t| t.added.len() == own.added.len()) {
            let Some((own_effect, other_effect)) = exchanged_effects(own, other) else { continue };
            let fits_alike = (other.fit.cost - own.fit.cost).abs() < MAX_TIE_DIFFERENCE_NATS;
            let undecided = std::ptr::eq(own, best) && is_undecided(own.log_weight(), other.log_weight());
            if !(fits_alike || undecided) || pairs.iter().any(|p| p.is_of(own_effect, other_effect)) {
                continue;
            }
            let certificate = engine.certificate([name(own_effect), name(other_effect)], [own, other])?;
            if undecided || certificate.same || other.fit.estimates.len() == own.fit.estimates.len() {
                pairs.push(TiedPair { own_effect, other_effect, other, certificate });
            }
        }
    }
    Ok(pairs)
}

/// Whether two log weights leave it undecided which model is true.
fn is_undecided(own: f64, other: f64) -> bool {
    (other - own).abs() < MAX_UNDECIDED_LOG_ODDS
}

impl TiedPair<'_> {
    fn is_of(&self, own_effect: &Effect, other_effect: &Effect) -> bool {
        (self.own_effect.kind, self.other_effect.kind) == (own_effect.kind, other_effect.kind)
    }
}

/// The effect of each model that is missing from the other; `None` unless the models differ in exactly one effect with
/// different names.
fn exchanged_effects<'a>(own: &'a FittedModel, other: &'a FittedModel) -> Option<(&'a Effect, &'a Effect)> {
    match (extra_effects(own, other).as_slice(), extra_effects(other, own).as_slice()) {
        ([own_effect], [other_effect]) if name(own_effect) != name(other_effect) => {
            Some((own_effect, other_effect))
        }
        _ => None,
    }
}

/// Each effect of the best model with its indistinguishable replacements.
fn ties(pairs: &[TiedPair<'_>], best: &FittedModel) -> Vec<Vec<String>> {
    let set = |effect: &Effect| {
        let mut set = vec![name(effect).to_owned()];
        set.extend(
            pairs
                .iter()
                .filter(|p| p.own_effect.kind == effect.kind)
                .map(|p| name(p.other_effect).to_owned()),
        );
        set.dedup();
        set
    };
    best.added.iter().map(set).filter(|set| set.len() > 1).collect()
}

/// The best model's effects together with other effect sets that differ in more than one effect and whose
/// odds are undecided; empty if there are none.
fn tied_sets(found: &SearchResult, best: &FittedModel) -> Vec<Vec<Vec<String>>> {
    let own = sorted_names(best);
    let mut class = vec![own.clone()];
    for other in found.models.iter().filter(|t| !t.added.is_empty() && !best.added.is_empty()) {
        let names = sorted_names(other);
        let undecided = is_undecided(best.log_weight(), other.log_weight());
        let differ = !extra_effects(best, other).is_empty() && !extra_effects(other, best).is_empty();
        if undecided && differ && exchanged_effects(best, other).is_none() && !class.contains(&names) {
            class.push(names);
        }
    }
    let named = |set: &Vec<&str>| set.iter().map(|&name| name.to_owned()).collect();
    if class.len() > 1 { vec![class.iter().map(named).collect()] } else { vec![] }
}

/// Whether two models have effects of the same kinds.
fn same_kinds(one: &FittedModel, other: &FittedModel) -> bool {
    extra_effects(one, other).is_empty() && extra_effects(other, one).is_empty()
}

/// Effects of a model whose kind another model does not contain.
fn extra_effects<'a>(from: &'a FittedModel, other: &FittedModel) -> Vec<&'a Effect> {
    from.added.iter().filter(|e| other.added.iter().all(|o| o.kind != e.kind)).collect()
}

/// The best models with other effects than the named ones, one for each set of names, with their
/// probabilities.
fn alternatives<'a>(
    found: &'a SearchResult,
    probabilities: &[f64],
    best: &FittedModel,
) -> Vec<(&'a FittedModel, f64)> {
    let mut reported = vec![sorted_names(best)];
    let mut alternatives = Vec::new();
    for (fitted, &probability) in found.models.iter().zip(probabilities) {
        let names = sorted_names(fitted);
        if !fitted.added.is_empty() && !reported.contains(&names) && alternatives.len() < MAX_ALTERNATIVES {
            reported.push(names);
            alternatives.push((fitted, probability));
        }
    }
    alternatives
}

/// The names of a model's effects in alphabetical order.
fn sorted_names(fitted: &FittedModel) -> Vec<&'static str> {
    let mut names = fitted.names();
    names.sort_unstable();
    names
}

/// The name of the best model in a comparison: its effects that the other model does not contain.
fn own_name(best: &FittedModel, other: &FittedModel) -> String {
    let own: Vec<_> = extra_effects(best, other).into_iter().map(name).collect();
    match (own.is_empty(), best.added.is_empty()) {
        (false, _) => own.join(" + "),
        (true, true) => "no missing effect".to_owned(),
        (true, false) => best.names().join(" + "),
    }
}

/// The experiment that the catalogue recommends for an alternative's effect.
fn catalogue_experiment(found: &SearchResult, alternative: &FittedModel, best: &FittedModel) -> String {
    let Some(new) = extra_effects(alternative, best).into_iter().next() else { return String::new() };
    let fits_alike = |other: &&FittedModel| {
        other.added.len() == alternative.added.len()
            && other.fit.estimates.len() == alternative.fit.estimates.len()
            && (other.fit.cost - alternative.fit.cost).abs() < MAX_TIE_DIFFERENCE_NATS
    };
    let mut indistinguishable: Vec<&str> = found
        .models
        .iter()
        .filter(fits_alike)
        .filter_map(|other| exchanged_effects(alternative, other))
        .filter(|(own_effect, _)| own_effect.kind == new.kind)
        .map(|(_, other_effect)| name(other_effect))
        .collect();
    indistinguishable.dedup();
    let probe = new.kind.spec().suggested_push;
    if indistinguishable.is_empty() {
        probe.to_owned()
    } else {
        format!("the recorded pushes do not distinguish it from {}: {probe}", indistinguishable.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::is_undecided;

    #[test]
    fn one_to_twenty_decides() {
        let odds = |odds: f64| is_undecided(-7000.0, -7000.0 - odds.ln());
        assert!(odds(1.0) && odds(19.0) && odds(1.0 / 19.0));
        assert!(!odds(21.0) && !odds(1.0 / 21.0));
    }
}
