//! Which of the models that were tried is named, and what to say of it.

use crate::adequacy::{Remainder, remainder};
use crate::answer::Verdict;
use crate::confirm::holds_up;
use crate::naming::without;
use crate::outlook::outlook;
use crate::search::{Found, Tried};
use trundle_infer::{Comparison, InferError};
use trundle_record::Dataset;

/// Chance that an effect must have, block by block, to be named.
const SURE: f64 = 0.95;
/// Share of what was missing that named effects may leave and still explain it.
const LEFT_OVER: f64 = 0.25;
/// Share of the misfit that named effects may leave, and misfit per sample that they may leave anyway, nats. A right law
/// leaves thousandths: what leaves a hundredth is a law that is like the missing one.
const LIKENESS: f64 = 0.01;
const UNSEEN: f64 = 2.0;
/// Gain of each of several effects over what they all leave, at least.
const OUTWEIGHS: f64 = 2.0;
/// Mean square of the errors one second ahead without one of several effects, over that with all, at least.
const MATTERS: f64 = 1.5;

/// The model that is named, if any.
pub(crate) struct Choice<'a> {
    pub best: &'a Tried,
    /// Of each of its effects, that it helps block by block.
    pub chances: Vec<f64>,
    /// How many models of more weight have an effect that did not earn its place.
    pub rejected: usize,
}

/// The model with the most weight each of whose effects holds up block by block; without one, the one with the most
/// weight and no chances.
pub(crate) fn choose<'a>(
    data: &Dataset,
    comparison: &Comparison,
    found: &'a Found,
) -> Result<Choice<'a>, InferError> {
    for (rejected, candidate) in found.tried.iter().enumerate() {
        let mut chances = Vec::new();
        for k in 0..candidate.added.len() {
            match without(found, candidate, k) {
                Some(simpler) => chances.push(holds_up(comparison, &candidate.fit, &simpler.fit)?),
                None => chances.push(0.0),
            }
        }
        if chances.iter().all(|c| *c >= SURE) && outweighs(data, comparison, found, candidate)? {
            return Ok(Choice { best: candidate, chances, rejected });
        }
    }
    Ok(Choice { best: &found.tried[0], chances: vec![], rejected: 0 })
}

/// Whether each of several effects gains more than what they all leave unexplained, and is missed one second ahead. No
/// law is exact: after a large effect is explained, a small one can soak up what its law got a little wrong, and that is
/// no second effect.
fn outweighs(
    data: &Dataset,
    comparison: &Comparison,
    found: &Found,
    candidate: &Tried,
) -> Result<bool, InferError> {
    if candidate.added.len() < 2 {
        return Ok(true);
    }
    let Some(left) = remainder(comparison, &candidate.fit)? else { return Ok(true) };
    let gain =
        |k: usize| without(found, candidate, k).map_or(0.0, |simpler| simpler.fit.cost - candidate.fit.cost);
    if !(0..candidate.added.len()).all(|k| gain(k) > OUTWEIGHS * left.gain) {
        return Ok(false);
    }
    let with = outlook(data, &candidate.fit)?.share;
    for k in 0..candidate.added.len() {
        let Some(simpler) = without(found, candidate, k) else { return Ok(false) };
        if outlook(data, &simpler.fit)?.share < MATTERS * with {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Chance that a law which leaves so much is the missing one, rather than one that is like it: even where it leaves as
/// much as is still named.
pub(crate) fn likeness(left: Option<Remainder>, observations: usize) -> f64 {
    let most = UNSEEN * observations as f64;
    left.map_or(1.0, |left| 1.0 / (1.0 + (left.misfit() / most).powi(2)))
}

/// The verdict on a model, given what the simulation under test and it leave.
pub(crate) fn judge(
    comparison: &Comparison,
    before: Option<Remainder>,
    best: &Tried,
    left: Option<Remainder>,
) -> Verdict {
    let observations = comparison.observations();
    let matters = |r: Option<Remainder>| r.is_some_and(|r| r.matters(observations));
    match (before, left) {
        _ if best.added.is_empty() && matters(before) => Verdict::Unexplained,
        _ if best.added.is_empty() => Verdict::Consistent,
        (Some(before), Some(after)) if matters(left) && after.gain > LEFT_OVER * before.gain => {
            Verdict::Unexplained
        }
        (Some(before), Some(after))
            if after.misfit() > (UNSEEN * observations as f64).max(LIKENESS * before.misfit()) =>
        {
            Verdict::Unexplained
        }
        _ => Verdict::Explained,
    }
}
