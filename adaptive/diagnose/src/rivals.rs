//! What explains the data as well, or almost: ties with their certificates, alternatives, and the push that would tell.

use crate::answer::Alternative;
use crate::candidates::name;
use crate::design::{Certificate, Experiment};
use crate::engine::{Engine, Tried};
use crate::search::Found;
use crate::thresholds::TIE;
use trundle_infer::{InferError, Watch};
use trundle_model::Effect;

/// Difference of log weight below which the data do not decide: one to twenty.
const OPEN: f64 = 3.0;
/// At most this many alternatives are told.
const ALTERNATIVES: usize = 5;
/// To so many of them a push is designed; of the others the catalogue knows one.
const DESIGNED: usize = 2;
/// Less probable alternatives need no push: the recording excludes them.
const POSSIBLE: f64 = 1e-3;

/// What stays in doubt.
#[derive(Clone, Debug, Default)]
pub(crate) struct Doubts {
    /// Sets of effects that could stand in one another's place.
    pub tied: Vec<Vec<String>>,
    /// The set of effects that is named and others, in which more than one effect differs, that the data do not tell from it.
    pub tied_sets: Vec<Vec<Vec<String>>>,
    /// How alike the models of each pair in them are.
    pub certificates: Vec<Certificate>,
    /// The best models of other effects than what is named.
    pub alternatives: Vec<Alternative>,
    /// The pushes that would tell them apart.
    pub experiments: Vec<Experiment>,
}

/// What else could explain a recording, and how to find out. With `designing`, pushes are designed for the best few.
///
/// # Errors
/// When the user interrupts.
pub(crate) fn doubts(
    engine: &dyn Engine,
    (found, probabilities): (&Found, &[f64]),
    best: &Tried,
    designing: bool,
    watch: &dyn Watch,
) -> Result<Doubts, InferError> {
    let pairs = pairs(engine, found, best)?;
    let mut doubts = Doubts {
        tied: ties(&pairs, best),
        tied_sets: tied_sets(found, best),
        certificates: pairs.iter().map(|pair| pair.certificate.clone()).collect(),
        ..Doubts::default()
    };
    let mut attempts = 0;
    for (tried, probability) in others(found, probabilities, best) {
        let effect = tried.names().join(" + ");
        let possible = probability > POSSIBLE || pairs.iter().any(|pair| alike(pair.other, tried));
        let mut text = probe(found, tried, best);
        if designing && possible && attempts < DESIGNED {
            attempts += 1;
            let names = [&*own_name(best, tried), &*effect];
            let planned = engine.experiment(names, [best, tried], &best.fit.channels, watch)?;
            if let Some(planned) = planned.filter(Experiment::is_informative) {
                text.clone_from(&planned.sentence);
                doubts.experiments.push(planned);
            }
        }
        doubts.alternatives.push(Alternative { effect, probability, experiment: text });
    }
    Ok(doubts)
}

/// An effect of a model and another that could stand in its place.
struct Pair<'a> {
    mine: &'a Effect,
    rival: &'a Effect,
    other: &'a Tried,
    certificate: Certificate,
}

/// Pairs of an effect of the best model and another in its place that the data do not tell: of all forms of either
/// model, finer or not, two that fit alike with as many parameters, or that make the same motion within noise; or the
/// best forms of both, where neither is twenty times as probable as the other.
fn pairs<'a>(engine: &dyn Engine, found: &'a Found, best: &'a Tried) -> Result<Vec<Pair<'a>>, InferError> {
    let mut pairs: Vec<Pair> = Vec::new();
    for own in found.tried.iter().filter(|t| alike(t, best)) {
        for other in found.tried.iter().filter(|t| t.added.len() == own.added.len()) {
            let Some((mine, rival)) = swapped(own, other) else { continue };
            let like = (other.fit.cost - own.fit.cost).abs() < TIE;
            let open = std::ptr::eq(own, best) && is_open(own.log_weight(), other.log_weight());
            if !(like || open) || pairs.iter().any(|p| p.is_of(mine, rival)) {
                continue;
            }
            let certificate = engine.certificate([name(mine), name(rival)], [own, other])?;
            if open || certificate.same || other.fit.estimates.len() == own.fit.estimates.len() {
                pairs.push(Pair { mine, rival, other, certificate });
            }
        }
    }
    Ok(pairs)
}

/// Whether two log weights leave open which model is true.
fn is_open(own: f64, other: f64) -> bool {
    (other - own).abs() < OPEN
}

impl Pair<'_> {
    fn is_of(&self, mine: &Effect, rival: &Effect) -> bool {
        (self.mine.kind, self.rival.kind) == (mine.kind, rival.kind)
    }
}

/// The one effect in which two models differ, of either, if it is one and goes by different names.
fn swapped<'a>(own: &'a Tried, other: &'a Tried) -> Option<(&'a Effect, &'a Effect)> {
    match (lacking(own, other).as_slice(), lacking(other, own).as_slice()) {
        ([mine], [rival]) if name(mine) != name(rival) => Some((mine, rival)),
        _ => None,
    }
}

/// Sets of an effect of the best model and all that could stand in its place.
fn ties(pairs: &[Pair<'_>], best: &Tried) -> Vec<Vec<String>> {
    let set = |effect: &Effect| {
        let mut set = vec![name(effect).to_owned()];
        set.extend(pairs.iter().filter(|p| p.mine.kind == effect.kind).map(|p| name(p.rival).to_owned()));
        set.dedup();
        set
    };
    best.added.iter().map(set).filter(|set| set.len() > 1).collect()
}

/// The best model's set of effects with others that are neither twenty times as probable nor twenty times less, where more
/// than one effect differs; empty where there is none.
fn tied_sets(found: &Found, best: &Tried) -> Vec<Vec<Vec<String>>> {
    let own = sorted(best);
    let mut class = vec![own.clone()];
    for other in found.tried.iter().filter(|t| !t.added.is_empty() && !best.added.is_empty()) {
        let names = sorted(other);
        let open = is_open(best.log_weight(), other.log_weight());
        let differ = !lacking(best, other).is_empty() && !lacking(other, best).is_empty();
        if open && differ && swapped(best, other).is_none() && !class.contains(&names) {
            class.push(names);
        }
    }
    let named = |set: &Vec<&str>| set.iter().map(|&name| name.to_owned()).collect();
    if class.len() > 1 { vec![class.iter().map(named).collect()] } else { vec![] }
}

/// Whether two models have effects of the same kinds.
fn alike(one: &Tried, other: &Tried) -> bool {
    lacking(one, other).is_empty() && lacking(other, one).is_empty()
}

/// Effects of a model of a kind that another has not.
fn lacking<'a>(from: &'a Tried, other: &Tried) -> Vec<&'a Effect> {
    from.added.iter().filter(|e| other.added.iter().all(|o| o.kind != e.kind)).collect()
}

/// The best models of other effects than the one that is named, each once, with their probabilities.
fn others<'a>(found: &'a Found, probabilities: &[f64], best: &Tried) -> Vec<(&'a Tried, f64)> {
    let mut told = vec![sorted(best)];
    let mut others = Vec::new();
    for (tried, &probability) in found.tried.iter().zip(probabilities) {
        let names = sorted(tried);
        if !tried.added.is_empty() && !told.contains(&names) && others.len() < ALTERNATIVES {
            told.push(names);
            others.push((tried, probability));
        }
    }
    others
}

/// The names of a model's effects, in alphabetical order.
fn sorted(tried: &Tried) -> Vec<&'static str> {
    let mut names = tried.names();
    names.sort_unstable();
    names
}

/// What to call the best model beside another: the effects that the other has not.
fn own_name(best: &Tried, other: &Tried) -> String {
    let own: Vec<_> = lacking(best, other).into_iter().map(name).collect();
    match (own.is_empty(), best.added.is_empty()) {
        (false, _) => own.join(" + "),
        (true, true) => "nothing missing".to_owned(),
        (true, false) => best.names().join(" + "),
    }
}

/// The push that the catalogue knows to show an alternative's effect.
fn probe(found: &Found, alternative: &Tried, best: &Tried) -> String {
    let Some(new) = lacking(alternative, best).into_iter().next() else { return String::new() };
    let fits_alike = |other: &&Tried| {
        other.added.len() == alternative.added.len()
            && other.fit.estimates.len() == alternative.fit.estimates.len()
            && (other.fit.cost - alternative.fit.cost).abs() < TIE
    };
    let mut twins: Vec<&str> = found
        .tried
        .iter()
        .filter(fits_alike)
        .filter_map(|other| swapped(alternative, other))
        .filter(|(mine, _)| mine.kind == new.kind)
        .map(|(_, rival)| name(rival))
        .collect();
    twins.dedup();
    let probe = new.kind.spec().suggested_push;
    if twins.is_empty() {
        probe.to_owned()
    } else {
        format!("these pushes cannot tell it from {}: {probe}", twins.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::is_open;

    #[test]
    fn one_to_twenty_decides() {
        let odds = |odds: f64| is_open(-7000.0, -7000.0 - odds.ln());
        assert!(odds(1.0) && odds(19.0) && odds(1.0 / 19.0));
        assert!(!odds(21.0) && !odds(1.0 / 21.0));
    }
}
