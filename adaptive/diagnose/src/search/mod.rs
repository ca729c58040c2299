//! Trying effects: alone, and while the data ask for more, several together.
//!
//! Every candidate is screened by its score; those that promise most are fitted in full, from where the screen's
//! step leads. One more effect is screened on top of each of the best models; effects that mask each other are found by
//! exchanging each for others ([`again`]).

mod again;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod nested;

use crate::adequacy::{Remainder, remainder};
use crate::candidates::{candidates, name, repeats};
use crate::locate::{Located, located};
use crate::screen::{Screen, Start};
use rayon::prelude::*;
use std::collections::BTreeSet;
use trundle_infer::{
    Comparison, Coordinates, Fit, FitOptions, InferError, MotionLikelihood, Watch, carried, fit, on_all_cores,
};
use trundle_model::{Effect, INNER, Kind, Model};
use trundle_record::Prepared;

/// A model that was tried: the simulation under test with some effects added.
#[derive(Clone)]
pub(crate) struct Tried {
    pub added: Vec<Effect>,
    pub fit: Fit,
}

impl Tried {
    /// Log evidence plus log prior: an effect is missing in one simulation of twenty, and may be any.
    pub fn log_weight(&self) -> f64 {
        let one = MISSING / (1.0 - MISSING) / Kind::ALL.len() as f64;
        self.fit.log_evidence + self.added.len() as f64 * one.ln()
    }

    /// Names of the added effects.
    pub fn names(&self) -> Vec<&'static str> {
        self.added.iter().map(name).collect()
    }
}

/// What the search found, best first.
pub(crate) struct Found {
    pub tried: Vec<Tried>,
    /// What the simulation under test leaves.
    pub before: Option<Remainder>,
    /// Where it leaves it.
    pub located: Located,
}

/// Share of simulations that lack an effect.
const MISSING: f64 = 0.05;
/// Gain, nats, below which a kind is not fitted unless it is among the first `ALWAYS`: what a prior costs at least.
pub(crate) const HOPELESS: f64 = 5.0;
const ALWAYS: usize = 3;
/// Kinds fitted in full on top of the simulation under test, and on top of a richer model.
const SINGLES: usize = 9;
const MORE: usize = 3;
/// Models of one size on top of which one more effect is sought.
const FIRSTS: usize = 2;
/// Share of the misfit that an effect may leave for a further one to be sought: an effect that does not halve what is left
/// only soaks up what no law of the catalogue explains.
const HALVED: f64 = 0.5;
/// Effects that are added at most: each must earn its place, so that only the time of a search is bounded here.
const MAX_EFFECTS: usize = 6;
/// Starts of a kind.
const STARTS: usize = 2;
/// Gain per sample that a remainder must promise for another effect to be sought beside one, nats.
const ANOTHER: f64 = 0.15;
/// Steps of a search that only ranks models, first on thinned tracks and then on all, and of one that ends.
const GLANCE: usize = 8;
const SECOND_GLANCE: usize = 2;
const TO_THE_END: usize = 60;
/// How far behind the best a model may be after a glance and still be followed: nats, and as a share of what the best
/// gained; and how many more steps like its last one it is given.
const NEAR: f64 = 30.0;
const BEHIND: f64 = 0.1;
const STILL: f64 = 10.0;
/// Random starts of a candidate that cannot be screened, beside the carried-over one.
const EXTRA_STARTS: usize = 3;

pub(crate) struct Searcher<'a> {
    pub comparison: &'a Comparison,
    pub nominal: &'a Model,
    /// Whether the recorded wrench was commanded, not measured.
    pub commanded: bool,
    pub episodes: &'a [Prepared],
    /// Effects that are not offered, by their names in a diagnosis.
    pub without: &'a [String],
    /// Parts of the floor that seem to drag: convex polygons, world, m; known once the simulation under test is fitted.
    pub regions: &'a [Vec<[f64; 2]>],
    pub seed: u64,
    pub watch: &'a dyn Watch,
}

/// A fit that is to be made: effects to add, and values of all slots to start from.
#[derive(Clone)]
struct Job {
    added: Vec<Effect>,
    warm: Vec<Vec<f64>>,
    /// Cost of the simpler model that it goes out from.
    from: f64,
}

impl Searcher<'_> {
    /// Try everything worth trying.
    pub fn run(&self) -> Result<Found, InferError> {
        self.watch.progress("the simulation under test", 0.0);
        let options = FitOptions { seed: self.seed, from_afar: true, ..FitOptions::default() };
        let base =
            Tried { added: vec![], fit: fit(self.comparison, self.nominal, &[], &options, self.watch)? };
        // Where the noise is not stated, the next searches start from what suits the simulation under test.
        let comparison = self.comparison.with_channels(base.fit.channels);
        let tuned = Searcher { comparison: &comparison, ..*self };
        tuned.beyond(base)
    }

    fn beyond(&self, base: Tried) -> Result<Found, InferError> {
        let before = remainder(self.comparison, &base.fit)?;
        let located = located(self.comparison, &base.fit, before, self.episodes)?;
        let regions: Vec<_> = located.regions.iter().map(|r| r.polygon.clone()).collect();
        let tried = Searcher { regions: &regions, ..*self }.over(base)?;
        Ok(Found { tried, before, located })
    }

    /// Models with one effect and, while the data ask for it, with one more; best first.
    fn over(&self, base: Tried) -> Result<Vec<Tried>, InferError> {
        let mut tried = vec![base.clone()];
        let offered = self.offered(&base);
        self.try_all("single effects", self.jobs(&base, &offered, SINGLES)?, &mut tried)?;
        self.shapes_again(&mut tried)?;
        self.refine(&mut tried)?;
        let mut before = f64::INFINITY;
        for size in 1..MAX_EFFECTS {
            let left = remainder(self.comparison, &tried[0].fit)?.map_or(0.0, |left| left.misfit());
            if tried[0].added.len() != size || left > HALVED * before || !self.asks_for_more(&tried[0])? {
                break;
            }
            before = left;
            self.one_more(size, &mut tried)?;
            self.shapes_again(&mut tried)?;
            self.exchange(&mut tried)?;
            self.shapes_again(&mut tried)?;
            self.subsets(&mut tried)?;
            self.refine(&mut tried)?;
        }
        Ok(tried)
    }

    /// Kinds of effects that may be added to a model.
    fn offered(&self, to: &Tried) -> Vec<Kind> {
        let spare = INNER.saturating_sub(to.fit.model.inner().len());
        let allowed = |kind: &Kind| {
            let (effect, states) = (kind.spec().effect, kind.spec().inner.len());
            let beside = |e: &Effect| name(e) != effect || repeats(*kind) && e.kind == *kind;
            states <= spare && to.added.iter().all(beside) && self.without.iter().all(|w| w != effect)
        };
        let all = candidates(self.nominal, self.comparison.is_quasi_static(), self.commanded);
        all.into_iter().filter(allowed).collect()
    }

    /// The fits that promise most on top of a model, at most `most` kinds.
    fn jobs(&self, from: &Tried, offered: &[Kind], most: usize) -> Result<Vec<Job>, InferError> {
        let Comparison::Motion(motion) = self.comparison else {
            return Ok(offered.iter().map(|&kind| self.unscreened(from, kind)).collect());
        };
        let screen = self.screen(motion, self.regions, most);
        let found = on_all_cores(self.watch, |watch| screen.of(&from.fit, offered, watch))?;
        let hopeful = |(rank, starts): &(usize, &Vec<Start>)| *rank < ALWAYS || starts[0].gain > HOPELESS;
        let kept = found.iter().take(most).enumerate().filter(hopeful);
        Ok(kept.map(|(_, starts)| job(from, starts)).collect())
    }

    fn screen<'a>(
        &'a self,
        motion: &'a MotionLikelihood,
        regions: &'a [Vec<[f64; 2]>],
        most: usize,
    ) -> Screen<'a> {
        Screen { motion, episodes: self.episodes, regions, starts: STARTS, most, seed: self.seed }
    }

    /// A fit from the simpler model's values, the new effect's drawn from its prior a few times.
    fn unscreened(&self, from: &Tried, kind: Kind) -> Job {
        use rand::SeedableRng;
        let mut added = from.added.clone();
        added.push(Effect::free(kind));
        let model = self.model(&added);
        let coordinates = Coordinates::new(&model);
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(self.seed);
        let median = coordinates.values(&vec![0.0; coordinates.free().len()]).0;
        let draws = (0..EXTRA_STARTS).map(|_| coordinates.values(&coordinates.draw(&mut rng)).0);
        let fills: Vec<_> = std::iter::once(median).chain(draws).collect();
        let warm = fills.iter().map(|fill| carried(&from.fit, &model, fill)).collect();
        Job { added, warm, from: from.fit.cost }
    }

    fn model(&self, added: &[Effect]) -> Model {
        let mut model = self.nominal.clone();
        model.effects.extend(added.iter().cloned());
        model
    }

    /// Try some models that were not tried yet: all of them a few steps far, to the end those that may yet be best.
    fn try_all(&self, what: &'static str, jobs: Vec<Job>, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let new = |job: &Job| tried.iter().all(|t| !same(&t.added, &job.added));
        let jobs: Vec<Job> = jobs.into_iter().filter(new).collect();
        if self.comparison.is_quasi_static() || jobs.len() < 2 {
            return self.make_all(what, jobs, tried);
        }
        let on = |t: Tried, from: f64| Job { warm: vec![t.fit.values], added: t.added, from };
        let thinned = self.comparison.thinned();
        let cheaper = Searcher { comparison: &thinned, ..*self };
        let near = cheaper.fitted(what, jobs.clone(), GLANCE)?;
        let near = near.into_iter().zip(&jobs).map(|(t, job)| on(t, job.from)).collect();
        let looked = self.fitted(what, near, SECOND_GLANCE)?;
        let best = looked.iter().map(|t| t.fit.cost).fold(f64::INFINITY, f64::min);
        let gained = jobs.iter().map(|job| job.from - best).fold(0.0, f64::max);
        let hopeful = |t: &Tried| t.fit.cost - STILL * t.fit.falling < best + NEAR.max(BEHIND * gained);
        let (ahead, behind): (Vec<Tried>, Vec<Tried>) = looked.into_iter().partition(hopeful);
        let on = |t: Tried| {
            let from = t.fit.cost;
            on(t, from)
        };
        let ended = self.fitted(what, ahead.into_iter().map(on).collect(), TO_THE_END)?;
        keep(tried, ended.into_iter().chain(behind));
        Ok(())
    }

    /// Fit some models to the end, whether such were tried or not.
    fn make_all(&self, what: &'static str, jobs: Vec<Job>, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        keep(tried, self.fitted(what, jobs, TO_THE_END)?);
        Ok(())
    }

    /// Some fits, on all cores.
    fn fitted(&self, what: &'static str, jobs: Vec<Job>, steps: usize) -> Result<Vec<Tried>, InferError> {
        self.watch.progress(what, 0.0);
        let (count, done) = (jobs.len(), std::sync::atomic::AtomicUsize::new(0));
        on_all_cores(self.watch, |watch| {
            let one = |job: Job| {
                let found = self.fit(job, steps, watch);
                let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                watch.progress(what, done as f64 / count as f64);
                found
            };
            jobs.into_par_iter().map(one).collect()
        })
    }

    fn fit(&self, job: Job, steps: usize, watch: &dyn Watch) -> Result<Tried, InferError> {
        let model = self.model(&job.added);
        let near = (!self.comparison.is_quasi_static()).then_some(steps);
        let options =
            FitOptions { starts: 0, seed: self.seed, from_afar: false, near, ..FitOptions::default() };
        Ok(Tried { fit: fit(self.comparison, &model, &job.warm, &options, watch)?, added: job.added })
    }

    /// One more effect on top of the best models with `size` of them.
    fn one_more(&self, size: usize, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let firsts: Vec<Tried> =
            tried.iter().filter(|t| t.added.len() == size).take(FIRSTS).cloned().collect();
        let mut jobs = Vec::new();
        for first in &firsts {
            jobs.extend(self.jobs(first, &self.offered(first), MORE)?);
        }
        let mut seen = BTreeSet::new();
        jobs.retain(|job| seen.insert(kinds(&job.added)));
        self.try_all("several effects", jobs, tried)
    }

    /// Whether an explained recording leaves more than laws that are a little wrong in shape do.
    fn asks_for_more(&self, best: &Tried) -> Result<bool, InferError> {
        let observations = self.comparison.observations() as f64;
        let left = remainder(self.comparison, &best.fit)?;
        Ok(left.is_none_or(|left| left.gain > ANOTHER * observations))
    }
}

/// The fit of a kind of effect on top of a model, from where its screen leads.
fn job(from: &Tried, starts: &[Start]) -> Job {
    let mut added = from.added.clone();
    added.extend(starts.first().map(|s| freed(&s.effect)));
    let with = |own: &[f64], effect: &Effect| -> Vec<f64> {
        own.iter().copied().chain(effect.values.iter().map(|v| v.unwrap_or(0.0))).collect()
    };
    let warm = starts.iter().flat_map(|s| [with(&s.base, &s.effect), with(&from.fit.values, &s.effect)]);
    Job { added, warm: warm.collect(), from: from.fit.cost }
}

/// Put models among those that were tried, sorted by weight; of one model, the best fit.
fn keep(tried: &mut Vec<Tried>, more: impl IntoIterator<Item = Tried>) {
    tried.extend(more);
    tried.sort_by(|a, b| b.log_weight().total_cmp(&a.log_weight()));
    let mut kept: Vec<Tried> = Vec::with_capacity(tried.len());
    for one in tried.drain(..) {
        if kept.iter().all(|k| !same(&k.added, &one.added)) {
            kept.push(one);
        }
    }
    *tried = kept;
}

/// An effect with every essential parameter free, its choices kept.
fn freed(effect: &Effect) -> Effect {
    let mut free = Effect::free(effect.kind);
    for ((param, value), free) in effect.kind.spec().params.iter().zip(&effect.values).zip(&mut free.values) {
        if param.choice {
            *free = *value;
        }
    }
    free
}

/// Whether two models have the same effects, each as often.
fn same(a: &[Effect], b: &[Effect]) -> bool {
    let count = |of: &[Effect], effect: &Effect| of.iter().filter(|e| *e == effect).count();
    a.len() == b.len() && a.iter().all(|effect| count(a, effect) == count(b, effect))
}

/// Kinds of some effects, in the catalogue's order, each as often as it is there.
fn kinds(effects: &[Effect]) -> Vec<Kind> {
    let mut kinds: Vec<Kind> = effects.iter().map(|e| e.kind).collect();
    kinds.sort_unstable();
    kinds
}

/// The effect with its refinements free, if it has any that are not.
fn finer(effect: &Effect) -> Option<Effect> {
    let free: Vec<_> =
        effect.kind.spec().params.iter().filter(|p| p.refinement.is_some() && !p.choice).collect();
    let finer = free.iter().fold(effect.clone(), |e, param| e.with(param.name, None));
    (finer != *effect).then_some(finer)
}

/// Probability of each model among those tried, the first `rejected` of which are out of the question.
pub(crate) fn probabilities(tried: &[Tried], rejected: usize) -> Vec<f64> {
    let best = tried.iter().skip(rejected).map(Tried::log_weight).fold(f64::NEG_INFINITY, f64::max);
    let weight = |(k, t): (usize, &Tried)| if k < rejected { 0.0 } else { (t.log_weight() - best).exp() };
    let weights: Vec<f64> = tried.iter().enumerate().map(weight).collect();
    let total: f64 = weights.iter().sum();
    weights.iter().map(|w| w / total).collect()
}

#[cfg(test)]
mod tests {
    use super::{kinds, same};
    use trundle_model::{Effect, Kind};

    #[test]
    fn two_points_of_friction_are_not_one() {
        let [rubs, slope] = [Kind::CoulombFriction, Kind::FloorSlope].map(Effect::free);
        let (twice, mixed) = ([rubs.clone(), rubs.clone()], [slope, rubs]);
        assert!(!same(&twice, &mixed) && !same(&mixed, &twice) && same(&twice, &twice));
        assert!(same(&mixed, &[mixed[1].clone(), mixed[0].clone()]));
        assert_eq!(kinds(&twice), [Kind::CoulombFriction; 2]);
    }
}
