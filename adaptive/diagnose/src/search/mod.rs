//! Trying effects: alone, and while the data ask for more, several together.
//!
//! Every candidate is screened by its score; those that promise most are fitted in full, from where the screen's
//! step leads. Where more is missing, sets of effects are screened together ([`sets`]), and one more effect on top of each of
//! the best models; effects that mask each other are found by exchanging each for others ([`again`]).

mod again;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod nested;
mod prior;
mod sets;
mod start;

use crate::adequacy::Remainder;
use crate::candidates::name;
use crate::engine::{Effort, Engine, Job, Tried};
use crate::locate::Located;
use crate::naming::of_kinds;
use crate::screen::{Start, Wanted};
use crate::thresholds::MATERIAL_RISE;
use prior::log_prior;
pub(crate) use prior::probabilities;
use rayon::prelude::*;
use start::{freed, job};
use std::collections::BTreeSet;
use trundle_infer::{Coordinates, InferError, Watch, on_all_cores, transferred_values};
use trundle_model::{Effect, INNER, Kind, Model};

impl Tried {
    /// Log evidence plus log prior, up to a constant.
    pub fn log_weight(&self) -> f64 {
        self.fit.log_evidence + self.log_prior
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

/// Gain, nats, below which a kind is not fitted unless it is among the first `ALWAYS`: what a prior costs at least.
pub(crate) const HOPELESS: f64 = 5.0;
const ALWAYS: usize = 3;
/// Kinds fitted in full on top of the simulation under test, and on top of a richer model.
const SINGLES: usize = 9;
const MORE: usize = 3;
/// Models of one size on top of which one more effect is sought.
const FIRSTS: usize = 2;
/// Effects that are added at most: each must earn its place, so that only the time of a search is bounded here.
const MAX_EFFECTS: usize = 4;
/// Starts of a kind.
const STARTS: usize = 2;
/// Gain per sample that a remainder must promise for another effect to be sought beside one, nats.
const ANOTHER: f64 = 0.15;
/// How far behind the best a model may be after a glance and still be followed: nats, and as a share of what the best
/// gained on the models that these go out from; and how many more steps like its last one it is given.
const NEAR: f64 = 30.0;
const BEHIND: f64 = 0.1;
const STILL: f64 = 10.0;
/// Random starts of a candidate that cannot be screened, beside the transferred_values-over one.
const EXTRA_STARTS: usize = 3;

#[derive(Clone, Copy)]
pub(crate) struct Searcher<'a> {
    pub engine: &'a dyn Engine,
    /// Effects that are not offered, by their names in a diagnosis.
    pub without: &'a [String],
    /// Parts of the floor that seem to drag: convex polygons, world, m; known once the simulation under test is fitted.
    pub regions: &'a [Vec<[f64; 2]>],
    pub seed: u64,
    pub watch: &'a dyn Watch,
}

impl Searcher<'_> {
    /// Try everything worth trying.
    pub fn run(&self) -> Result<Found, InferError> {
        self.watch.progress("the simulation under test", 0.0);
        let base = self.engine.base(self.seed, self.watch)?;
        let before = self.engine.remainder(&base)?;
        let located = self.engine.located(&base, before)?;
        let regions: Vec<_> = located.regions.iter().map(|r| r.polygon.clone()).collect();
        let upon = self.engine.upon(&base, before, self.watch)?;
        let tried = Searcher { engine: &*upon, regions: &regions, ..*self }.over(base)?;
        Ok(Found { tried, before, located })
    }

    /// Models with one effect and, while the data ask for it, with one more; best first.
    fn over(&self, base: Tried) -> Result<Vec<Tried>, InferError> {
        let mut tried = vec![base.clone()];
        let offered = self.offered(&base);
        self.try_all("single effects", self.jobs(&base, &offered, SINGLES)?, &mut tried)?;
        self.shapes_again(&mut tried)?;
        self.simpler(&mut tried)?;
        self.refine(&mut tried)?;
        let mut before = base;
        for _ in 1..MAX_EFFECTS {
            let best = tried[0].clone();
            let size = best.added.len();
            if size == 0 || size >= MAX_EFFECTS || !self.asks_for_more(&before, &best)? {
                break;
            }
            if before.added.is_empty() {
                self.sets(&before, &mut tried)?;
            }
            if tried[0].added.len() <= size {
                self.one_more(size, &mut tried)?;
            }
            self.shapes_again(&mut tried)?;
            self.exchange(&mut tried)?;
            self.shapes_again(&mut tried)?;
            self.simpler(&mut tried)?;
            self.subsets(&mut tried)?;
            self.refine(&mut tried)?;
            before = best;
        }
        self.parts(&mut tried)?;
        Ok(tried)
    }

    /// Kinds of effects that may be added to a model.
    fn offered(&self, to: &Tried) -> Vec<Kind> {
        let spare = INNER.saturating_sub(to.fit.model.inner().len());
        let allowed = |kind: &Kind| {
            let (effect, states) = (kind.spec().effect, kind.spec().inner.len());
            let beside = |e: &Effect| name(e) != effect || kind.repeats() && e.kind == *kind;
            states <= spare && to.added.iter().all(beside) && self.offers(*kind)
        };
        self.engine.candidates().into_iter().filter(allowed).collect()
    }

    fn offers(&self, kind: Kind) -> bool {
        self.without.iter().all(|name| name != kind.spec().effect)
    }

    /// The fits that promise most on top of a model, at most `most` kinds.
    fn jobs(&self, from: &Tried, offered: &[Kind], most: usize) -> Result<Vec<Job>, InferError> {
        let Some(found) = self.engine.starts(from, offered, &self.wanted(self.regions, most), self.watch)?
        else {
            return Ok(offered.iter().map(|&kind| self.unscreened(from, kind)).collect());
        };
        let hopeful = |(rank, starts): &(usize, &Vec<Start>)| *rank < ALWAYS || starts[0].gain > HOPELESS;
        let kept = found.iter().take(most).enumerate().filter(hopeful);
        Ok(kept.map(|(_, starts)| job(from, starts)).collect())
    }

    fn wanted<'a>(&self, regions: &'a [Vec<[f64; 2]>], most: usize) -> Wanted<'a> {
        Wanted { regions, starts: STARTS, most, seed: self.seed }
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
        let warm = fills.iter().map(|fill| transferred_values(&from.fit, &model, fill)).collect();
        Job::from(from, added, warm)
    }

    fn model(&self, added: &[Effect]) -> Model {
        let mut model = self.engine.nominal().clone();
        model.effects.extend(added.iter().cloned());
        model
    }

    /// Try some models that were not tried yet: all of them a few steps far, to the end those that may yet be best.
    fn try_all(&self, what: &'static str, jobs: Vec<Job>, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let new = |job: &Job| tried.iter().all(|t| !same(&t.added, &job.added));
        let jobs: Vec<Job> = jobs.into_iter().filter(new).collect();
        let (known, from) = (lowest(tried.iter().map(|t| t.fit.cost)), lowest(jobs.iter().map(|j| j.from)));
        self.try_these(what, jobs, tried, |looked| {
            let best = lowest(looked.iter().map(|t| t.fit.cost)).min(known);
            best + NEAR.max(BEHIND * (from - best))
        })
    }

    /// Try some models, whether such were tried or not: all of them a few steps far, to the end those that may yet cost
    /// less than the `bound` on what the first steps led to.
    fn try_these(
        &self,
        what: &'static str,
        jobs: Vec<Job>,
        tried: &mut Vec<Tried>,
        bound: impl Fn(&[Tried]) -> f64,
    ) -> Result<(), InferError> {
        let Some(thinned) = self.engine.thinned() else { return self.make_all(what, jobs, tried) };
        let on = |t: &Tried| Job::from(t, t.added.clone(), vec![t.fit.values.clone()]);
        let cheaper = Searcher { engine: &*thinned, ..*self };
        let starts: Vec<_> = jobs.iter().map(|job| (job.added.clone(), job.warm.clone())).collect();
        let near = cheaper.fitted(what, jobs, Effort::Glance)?;
        // The thinned recording may have led uphill.
        let also = |t: &Tried| {
            let begun = starts.iter().find(|(added, _)| *added == t.added);
            let mut job = on(t);
            job.warm.extend(begun.iter().flat_map(|(_, warm)| warm.iter().cloned()));
            job
        };
        let looked = self.fitted(what, near.iter().map(also).collect(), Effort::Look)?;
        let bound = bound(&looked);
        let hopeful = |t: &Tried| t.fit.cost - STILL * t.fit.last_decrease < bound;
        let (ahead, behind): (Vec<Tried>, Vec<Tried>) = looked.into_iter().partition(hopeful);
        let ended = self.fitted(what, ahead.iter().map(on).collect(), Effort::Full)?;
        keep(tried, ended.into_iter().chain(behind));
        Ok(())
    }

    /// Fit some models to the end, whether such were tried or not.
    fn make_all(&self, what: &'static str, jobs: Vec<Job>, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        keep(tried, self.fitted(what, jobs, Effort::Full)?);
        Ok(())
    }

    /// Some fits, on all cores. A model that cannot be evaluated where it would start, as under noise that suits a fuller
    /// model, is left out.
    fn fitted(&self, what: &'static str, jobs: Vec<Job>, effort: Effort) -> Result<Vec<Tried>, InferError> {
        self.watch.progress(what, 0.0);
        let offered = self.engine.candidates().iter().filter(|kind| self.offers(**kind)).count();
        let (count, done) = (jobs.len(), std::sync::atomic::AtomicUsize::new(0));
        on_all_cores(self.watch, |watch| {
            let one = |job: Job| {
                let prior = log_prior(job.added.len(), offered);
                let found = self.engine.fit(job, effort, self.seed, watch);
                let found = found.map(|tried| Tried { log_prior: prior, ..tried });
                let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                watch.progress(what, done as f64 / count as f64);
                found
            };
            let all: Vec<_> = jobs.into_par_iter().map(one).collect();
            all.into_iter().filter(|found| !matches!(found, Err(InferError::NoStart { .. }))).collect()
        })
    }

    /// One more effect on top of the best models with `size` of them.
    fn one_more(&self, size: usize, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let mut firsts: Vec<Tried> =
            tried.iter().filter(|t| t.added.len() == size).take(FIRSTS).cloned().collect();
        let simpler =
            |t: &Tried| of_kinds(tried, t.added.iter().map(|e| e.kind.simpler().unwrap_or(e.kind)).collect());
        let with_simpler: Vec<Tried> = firsts
            .iter()
            .filter(|t| t.added.iter().any(|e| e.kind.simpler().is_some()))
            .filter_map(simpler)
            .cloned()
            .collect();
        firsts.extend(with_simpler);
        let mut jobs = Vec::new();
        for first in &firsts {
            jobs.extend(self.jobs(first, &self.offered(first), MORE)?);
        }
        let mut seen = BTreeSet::new();
        jobs.retain(|job| seen.insert(kinds(&job.added)));
        self.try_all("several effects", jobs, tried)
    }

    /// Whether a model leaves more than laws that are a little wrong in shape do, by the noise that the instruments show, or
    /// predicts so badly that nothing could be named. Noise that is fitted holds unmodelled effects.
    fn leaves_much(&self, tried: &Tried) -> Result<bool, InferError> {
        let observations = self.engine.observations() as f64;
        let Some(left) = self.engine.remainder(&self.as_read(tried))? else { return Ok(true) };
        Ok(left.gain > ANOTHER * observations || self.engine.outlook(tried)?.is_material())
    }

    /// Whether one more effect is worth seeking, after the best model `before` was replaced by a larger one. That must leave
    /// much and err by more than the instruments, or any further effect would be immaterial. Its last effect must have gained
    /// its [`fair_share`] of what a random-walk wrench would have, or, where such a wrench gains no more than chance, have
    /// improved the predictions by a material share.
    fn asks_for_more(&self, before: &Tried, best: &Tried) -> Result<bool, InferError> {
        let much = self.leaves_much(best)? && self.engine.errs(best)?;
        if !much || before.added.is_empty() {
            return Ok(much);
        }
        let [was, left] = [before, best].map(|tried| self.engine.remainder(tried));
        let (Some(was), Some(left)) = (was?, left?) else { return Ok(true) };
        if left.matters(self.engine.observations()) {
            return Ok(before.fit.cost - best.fit.cost >= fair_share(before.added.len()) * was.misfit());
        }
        let [was, ahead] = [before, best].map(|tried| self.engine.outlook(tried));
        Ok(ahead?.share * MATERIAL_RISE < was?.share)
    }
}

/// Share of what a model with so many effects leaves that one more must gain for a further one to be sought. If effects that
/// may still be added explain all of it, the largest explains at least its equal share: one that gains less only soaks up
/// what no law of the catalogue explains.
fn fair_share(effects: usize) -> f64 {
    1.0 / MAX_EFFECTS.saturating_sub(effects).max(1) as f64
}

/// The lowest of some costs.
fn lowest(costs: impl Iterator<Item = f64>) -> f64 {
    costs.fold(f64::INFINITY, f64::min)
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
        effect.kind.spec().params.iter().filter(|p| p.refinement.is_some() && !p.role.is_choice()).collect();
    let finer = free.iter().fold(effect.clone(), |e, param| e.with(param.name, None));
    (finer != *effect).then_some(finer)
}

#[cfg(test)]
mod tests {
    use super::{MAX_EFFECTS, fair_share, kinds, same};
    use trundle_model::{Effect, Kind};

    #[test]
    fn an_equal_share_of_what_is_left_is_asked_of_each_effect() {
        let shares: Vec<f64> = (0..MAX_EFFECTS).map(fair_share).collect();
        let mut left = 1.0;
        for share in shares {
            assert!((left * share - 1.0 / MAX_EFFECTS as f64).abs() < 1e-12);
            left *= 1.0 - share;
        }
        assert!(left.abs() < 1e-12);
    }

    #[test]
    fn two_points_of_friction_are_not_one() {
        let [rubs, slope] = [Kind::CoulombFriction, Kind::FloorSlope].map(Effect::free);
        let (twice, mixed) = ([rubs.clone(), rubs.clone()], [slope, rubs]);
        assert!(!same(&twice, &mixed) && !same(&mixed, &twice) && same(&twice, &twice));
        assert!(same(&mixed, &[mixed[1].clone(), mixed[0].clone()]));
        assert_eq!(kinds(&twice), [Kind::CoulombFriction; 2]);
    }
}
