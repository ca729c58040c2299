//! What explains the data as well, or almost: ties and alternatives.

use crate::answer::Alternative;
use crate::candidates::name;
use crate::search::{Found, Tried};
use trundle_model::Effect;

/// Difference of log likelihood below which two explanations are the same.
const TIE: f64 = 2.0;

/// Effects that could stand in another's place without the likelihood telling.
pub(crate) fn ties(found: &Found, best: &Tried) -> Vec<Vec<String>> {
    let mut sets = Vec::new();
    for effect in &best.added {
        let mut set = vec![name(effect).to_owned()];
        set.extend(
            rivals(found, best)
                .into_iter()
                .filter(|(own, _)| own.kind == effect.kind)
                .map(|(_, other)| name(other).to_owned()),
        );
        set.dedup();
        if set.len() > 1 {
            sets.push(set);
        }
    }
    sets
}

/// Pairs of an effect of a model and another that could stand in its place without the likelihood telling:
/// of all forms of either model, finer or not, two with as many parameters fit alike.
fn rivals<'a>(found: &'a Found, model: &'a Tried) -> Vec<(&'a Effect, &'a Effect)> {
    let mut pairs: Vec<(&Effect, &Effect)> = Vec::new();
    for own in found.tried.iter().filter(|t| lacking(t, model).is_empty() && lacking(model, t).is_empty()) {
        for other in found.tried.iter().filter(|t| t.added.len() == own.added.len()) {
            let alike = other.fit.estimates.len() == own.fit.estimates.len()
                && (other.fit.cost - own.fit.cost).abs() < TIE;
            if let ([mine], [rival], true) =
                (lacking(own, other).as_slice(), lacking(other, own).as_slice(), alike)
                && name(mine) != name(rival)
                && pairs.iter().all(|(m, r)| (m.kind, r.kind) != (mine.kind, rival.kind))
            {
                pairs.push((*mine, *rival));
            }
        }
    }
    pairs
}

/// Effects of a model of a kind that another has not.
fn lacking<'a>(from: &'a Tried, other: &Tried) -> Vec<&'a Effect> {
    from.added.iter().filter(|e| other.added.iter().all(|o| o.kind != e.kind)).collect()
}

/// At most this many alternatives are told.
const ALTERNATIVES: usize = 5;

/// The best models of other effects than the one that is named, and the push that would tell.
pub(crate) fn alternatives(found: &Found, probabilities: &[f64], best: &Tried) -> Vec<Alternative> {
    let mut told = vec![sorted(best)];
    let mut alternatives = Vec::new();
    for (tried, &probability) in found.tried.iter().zip(probabilities) {
        let names = sorted(tried);
        if tried.added.is_empty() || told.contains(&names) || alternatives.len() == ALTERNATIVES {
            continue;
        }
        told.push(names);
        let effect = tried.names().join(" + ");
        alternatives.push(Alternative { effect, probability, experiment: experiment(found, tried, best) });
    }
    alternatives
}

/// The names of a model's effects, in alphabetical order.
fn sorted(tried: &Tried) -> Vec<&'static str> {
    let mut names = tried.names();
    names.sort_unstable();
    names
}

/// The push that would tell an alternative from the model that is named.
fn experiment(found: &Found, alternative: &Tried, best: &Tried) -> String {
    let Some(new) = lacking(alternative, best).into_iter().next() else { return String::new() };
    let twins = rivals(found, alternative).into_iter().filter(|(own, _)| own.kind == new.kind);
    let twins: Vec<_> = twins.map(|(_, rival)| name(rival)).collect();
    let probe = new.kind.spec().probe;
    if twins.is_empty() {
        probe.to_owned()
    } else {
        format!("these pushes cannot tell it from {}: {probe}", twins.join(", "))
    }
}
