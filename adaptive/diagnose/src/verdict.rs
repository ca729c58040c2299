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

/// The verdict, given what the simulation under test leaves, and what it leaves with the effects that were `named`, if any.
pub(crate) fn judge(
    observations: usize,
    before: Option<Remainder>,
    named: bool,
    left: Option<Remainder>,
) -> Verdict {
    let matters = |r: Option<Remainder>| r.is_some_and(|r| r.matters(observations));
    match (before, left) {
        _ if !named && matters(before) => Verdict::Unexplained,
        _ if !named => Verdict::Consistent,
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

#[cfg(test)]
mod tests {
    use super::{judge, likeness};
    use crate::adequacy::Remainder;
    use crate::answer::Verdict;
    use trundle_infer::Channels;

    const SAMPLES: usize = 2000;

    fn leaving(gain: f64, excess: f64) -> Option<Remainder> {
        let channels = Channels { pose: [1e-3; 3], reading: [0.4; 3], wander: [0.0; 3] };
        Some(Remainder { gain, channels, excess })
    }

    #[test]
    fn what_is_named_must_leave_little() {
        let judged = |left| judge(SAMPLES, leaving(5e5, 5e5), true, left);
        assert_eq!(judged(leaving(200.0, 400.0)), Verdict::Explained);
        assert_eq!(judged(leaving(3e4, 3e4)), Verdict::Unexplained, "a law like the missing one");
        assert_eq!(judged(leaving(0.0, 1.5e5)), Verdict::Unexplained, "blows, where no walk helps");
        // A hundredth of what was missing may be left, were it much.
        assert_eq!(judge(SAMPLES, leaving(4e6, 4e6), true, leaving(2e4, 2e4)), Verdict::Explained);
        // Of little, most must go.
        assert_eq!(judge(SAMPLES, leaving(100.0, 100.0), true, leaving(40.0, 40.0)), Verdict::Unexplained);
    }

    #[test]
    fn without_a_name_it_is_what_is_missing_that_counts() {
        assert_eq!(judge(SAMPLES, leaving(3.0, 300.0), false, None), Verdict::Consistent);
        assert_eq!(judge(SAMPLES, leaving(300.0, 300.0), false, None), Verdict::Unexplained);
    }

    #[test]
    fn a_law_is_the_less_likely_the_more_it_leaves() {
        assert!(likeness(leaving(0.0, 100.0), SAMPLES) > 0.99);
        assert!((likeness(leaving(4000.0, 0.0), SAMPLES) - 0.5).abs() < 1e-12);
        assert_eq!(likeness(None, SAMPLES), 1.0);
    }
}
