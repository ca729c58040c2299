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

/// Pairs of an effect of a model and another that could stand in its place without the likelihood telling.
fn rivals<'a>(found: &'a Found, model: &'a Tried) -> impl Iterator<Item = (&'a Effect, &'a Effect)> {
    let lacking = |from: &'a Tried, other: &'a Tried| {
        from.added.iter().filter(|e| other.added.iter().all(|o| o.kind != e.kind)).collect::<Vec<_>>()
    };
    found.tried.iter().filter_map(move |other| {
        let same = other.added.len() == model.added.len() && other.fit.cost - model.fit.cost < TIE;
        match (lacking(model, other).as_slice(), lacking(other, model).as_slice()) {
            ([own], [rival]) if same && name(own) != name(rival) => Some((*own, *rival)),
            _ => None,
        }
    })
}

/// At most this many alternatives are told.
const ALTERNATIVES: usize = 5;

/// The best models beside the one that is named, and the push that would tell.
pub(crate) fn alternatives(found: &Found, probabilities: &[f64], best: &Tried) -> Vec<Alternative> {
    let other = |(t, _): &(&Tried, &f64)| !t.added.is_empty() && t.names() != best.names();
    found
        .tried
        .iter()
        .zip(probabilities)
        .filter(other)
        .take(ALTERNATIVES)
        .map(|(t, &probability)| {
            let new = t.added.iter().find(|e| best.added.iter().all(|b| b.kind != e.kind));
            let twins = rivals(found, t).filter(|(own, _)| new.is_some_and(|new| new.kind == own.kind));
            let twins: Vec<_> = twins.map(|(_, rival)| name(rival)).collect();
            let mut experiment = new.map_or(String::new(), |e| e.kind.spec().probe.to_owned());
            if !twins.is_empty() {
                experiment = format!("these pushes cannot tell it from {}: {experiment}", twins.join(", "));
            }
            Alternative { effect: t.names().join(" + "), probability, experiment }
        })
        .collect()
}
