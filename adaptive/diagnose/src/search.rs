//! Trying effects: alone, in pairs, and one more on top of the best, while the data ask for more.
//!
//! Every candidate is screened by its score; those that promise most are fitted in full, from where the screen's
//! step leads. A pair is screened on top of each of the best single effects, and the two halves of a pair that masks
//! itself are found from the screens of both.

use crate::adequacy::{Remainder, remainder};
use crate::candidates::{candidates, name};
use crate::locate::{Located, located};
use crate::screen::{Start, screen};
use rayon::prelude::*;
use std::collections::BTreeSet;
use trundle_infer::{
    Comparison, Coordinates, Fit, FitOptions, InferError, Watch, carried, fit, on_all_cores,
};
use trundle_model::{Effect, Kind, Model, patch_outline};
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
/// At most this many effects are added.
const MOST: usize = 3;
/// Gain, nats, below which a kind is not fitted unless it is among the first `ALWAYS`: what a prior costs at least.
pub(crate) const HOPELESS: f64 = 5.0;
const ALWAYS: usize = 3;
/// Kinds fitted in full on top of the simulation under test, and on top of a richer model.
const SINGLES: usize = 9;
const MORE: usize = 3;
/// Single effects on top of which a second is sought.
const FIRSTS: usize = 2;
/// Models of the best one's size whose finer forms are tried: dry friction has two forms, at a point and under a body.
const REFINED: usize = 2;
/// Starts of a kind.
const STARTS: usize = 2;
/// How often shapes are sought again, while that takes this share of what was left.
const AGAIN: usize = 4;
const SETTLED: f64 = 0.1;
/// Gain per sample that a remainder must promise for another effect to be sought beside one, nats.
const ANOTHER: f64 = 0.15;
/// Random starts of a candidate that cannot be screened, beside the carried-over one.
const EXTRA_STARTS: usize = 3;

pub(crate) struct Searcher<'a> {
    pub comparison: &'a Comparison,
    pub nominal: &'a Model,
    pub episodes: &'a [Prepared],
    /// Effects that are not offered, by their names in a diagnosis.
    pub without: &'a [String],
    /// Parts of the floor that seem to drag: convex polygons, world, m; known once the simulation under test is fitted.
    pub regions: &'a [Vec<[f64; 2]>],
    pub seed: u64,
    pub watch: &'a dyn Watch,
}

/// A fit that is to be made: effects to add, and values of all slots to start from.
struct Job {
    added: Vec<Effect>,
    warm: Vec<Vec<f64>>,
    starts: usize,
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

    /// Models with more and more effects, best first.
    fn over(&self, base: Tried) -> Result<Vec<Tried>, InferError> {
        let mut tried = vec![base.clone()];
        let offered = self.offered(&base);
        self.try_all("single effects", self.jobs(&base, &offered, SINGLES)?, &mut tried)?;
        self.shapes_again(&mut tried)?;
        self.refine(&mut tried)?;
        let mut size = 1;
        while size < MOST && tried[0].added.len() == size && self.asks_for_more(&tried[0])? {
            let before = tried[0].fit.cost;
            self.one_more(&mut tried, size)?;
            self.shapes_again(&mut tried)?;
            self.exchange(&mut tried)?;
            self.shapes_again(&mut tried)?;
            self.subsets(&mut tried)?;
            self.refine(&mut tried)?;
            // An effect that gains less than it leaves is none, and one more would be none either.
            let left = remainder(self.comparison, &tried[0].fit)?.map_or(0.0, |left| left.gain);
            if before - tried[0].fit.cost < left {
                break;
            }
            size += 1;
        }
        Ok(tried)
    }

    /// Kinds of effects that may be added to a model.
    fn offered(&self, to: &Tried) -> Vec<Kind> {
        let present: BTreeSet<_> = to.added.iter().map(name).collect();
        let allowed = |kind: &Kind| {
            let effect = kind.spec().effect;
            !present.contains(effect) && self.without.iter().all(|w| w != effect)
        };
        candidates(self.nominal, self.comparison.is_quasi_static()).into_iter().filter(allowed).collect()
    }

    /// The fits that promise most on top of a model, at most `most` kinds.
    fn jobs(&self, from: &Tried, offered: &[Kind], most: usize) -> Result<Vec<Job>, InferError> {
        let Comparison::Motion(motion) = self.comparison else {
            return Ok(offered.iter().map(|&kind| self.unscreened(from, kind)).collect());
        };
        let found = on_all_cores(self.watch, |watch| {
            screen(motion, &from.fit, offered, (self.episodes, self.regions), STARTS, self.seed, watch)
        })?;
        let hopeful = |(rank, starts): &(usize, &Vec<Start>)| *rank < ALWAYS || starts[0].gain > HOPELESS;
        let kept = found.iter().take(most).enumerate().filter(hopeful);
        Ok(kept.map(|(_, starts)| job(from, starts)).collect())
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
        Job { added, warm: fills.iter().map(|fill| carried(&from.fit, &model, fill)).collect(), starts: 0 }
    }

    fn model(&self, added: &[Effect]) -> Model {
        let mut model = self.nominal.clone();
        model.effects.extend(added.iter().cloned());
        model
    }

    /// Make some fits, on all cores, and sort all that was tried.
    fn try_all(&self, what: &'static str, jobs: Vec<Job>, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let new = |job: &Job| tried.iter().all(|t| !same(&t.added, &job.added));
        let jobs: Vec<Job> = jobs.into_iter().filter(new).collect();
        self.make_all(what, jobs, tried)
    }

    /// The same, whether such models were tried or not.
    fn make_all(&self, what: &'static str, jobs: Vec<Job>, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        self.watch.progress(what, 0.0);
        let (count, done) = (jobs.len(), std::sync::atomic::AtomicUsize::new(0));
        let found = on_all_cores(self.watch, |watch| {
            let one = |job: Job| {
                let found = self.fit(job, watch);
                let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                watch.progress(what, done as f64 / count as f64);
                found
            };
            jobs.into_par_iter().map(one).collect::<Result<Vec<_>, InferError>>()
        })?;
        tried.extend(found);
        tried.sort_by(|a, b| b.log_weight().total_cmp(&a.log_weight()));
        // Of one model, the best fit.
        let mut kept: Vec<Tried> = Vec::with_capacity(tried.len());
        for one in tried.drain(..) {
            if kept.iter().all(|k| !same(&k.added, &one.added)) {
                kept.push(one);
            }
        }
        *tried = kept;
        Ok(())
    }

    fn fit(&self, job: Job, watch: &dyn Watch) -> Result<Tried, InferError> {
        let model = self.model(&job.added);
        let near = !self.comparison.is_quasi_static();
        let options = FitOptions {
            starts: job.starts,
            seed: self.seed,
            from_afar: false,
            near,
            ..FitOptions::default()
        };
        Ok(Tried { fit: fit(self.comparison, &model, &job.warm, &options, watch)?, added: job.added })
    }

    /// Seek the shapes of the best model's effects again, each from what the fit says of all else: they were sought
    /// beside parameters that had bent to what was missing, and a fit finds no way across an edge.
    fn shapes_again(&self, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let kinds = |t: &Tried| t.added.iter().map(|e| e.kind).collect::<BTreeSet<_>>();
        let best = kinds(&tried[0]);
        self.shapes_of(&best, tried)?;
        // A rival that came close may only stand at the wrong place.
        let near = |t: &&Tried| t.added.len() == best.len() && kinds(t) != best;
        match tried.iter().find(near).map(kinds) {
            Some(rival) => self.shapes_of(&rival, tried),
            None => Ok(()),
        }
    }

    /// The same of the best model of some kinds.
    fn shapes_of(&self, kinds: &BTreeSet<Kind>, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let Comparison::Motion(motion) = self.comparison else { return Ok(()) };
        let of_kinds = |t: &&Tried| t.added.iter().map(|e| e.kind).collect::<BTreeSet<_>>() == *kinds;
        for _ in 0..AGAIN {
            let Some(best) = tried.iter().find(of_kinds).cloned() else { return Ok(()) };
            let left = remainder(self.comparison, &best.fit)?.map_or(0.0, |left| left.misfit());
            if left < ANOTHER * self.comparison.observations() as f64 {
                return Ok(());
            }
            let mut jobs = Vec::new();
            for k in 0..best.added.len() {
                let (rest, effect) = self.apart(&best, k);
                let kind = best.added[k].kind;
                let outline = (kind == Kind::FloorPatch).then(|| patch_outline(&effect));
                let regions: Vec<_> = outline.into_iter().chain(self.regions.iter().cloned()).collect();
                let found = on_all_cores(self.watch, |watch| {
                    screen(motion, &rest.fit, &[kind], (self.episodes, &regions), STARTS, self.seed, watch)
                })?;
                jobs.extend(found.iter().map(|starts| job(&rest, starts)));
            }
            self.make_all("places again", jobs, tried)?;
            let now = tried.iter().find(of_kinds).map_or(best.fit.cost, |t| t.fit.cost);
            if now > best.fit.cost - left * SETTLED {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Other effects in place of each of the best model's: one that was found beside the wrong other may be wrong itself.
    fn exchange(&self, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let best = tried[0].clone();
        if best.added.len() < 2 {
            return Ok(());
        }
        let mut jobs = Vec::new();
        for k in 0..best.added.len() {
            let (rest, _) = self.apart(&best, k);
            jobs.extend(self.jobs(&rest, &self.offered(&rest), MORE)?);
        }
        self.try_all("in place of each", jobs, tried)
    }

    /// A model without its effect number `k`, all else as it was fitted, and that effect's values.
    fn apart(&self, from: &Tried, k: usize) -> (Tried, Vec<f64>) {
        let mut rest = from.clone();
        rest.added.remove(k);
        let effect = rest.fit.model.effects.remove(self.nominal.effects.len() + k);
        let slots = rest.fit.model.slots();
        rest.fit.values = slots.iter().map(|s| s.value.unwrap_or(0.0)).collect();
        rest.fit.estimates.retain(|e| slots.iter().any(|s| s.name == e.name));
        (rest, effect.values.iter().map(|v| v.unwrap_or(0.0)).collect())
    }

    /// One more effect on top of the best models of a size.
    fn one_more(&self, tried: &mut Vec<Tried>, size: usize) -> Result<(), InferError> {
        let firsts: Vec<Tried> =
            tried.iter().filter(|t| t.added.len() == size).take(FIRSTS).cloned().collect();
        let mut jobs = Vec::new();
        for first in &firsts {
            jobs.extend(self.jobs(first, &self.offered(first), MORE)?);
        }
        let mut seen = BTreeSet::new();
        jobs.retain(|job| seen.insert(job.added.iter().map(|e| e.kind).collect::<BTreeSet<_>>()));
        self.try_all(if size == 1 { "pairs" } else { "one more effect" }, jobs, tried)
    }

    /// The models that the best one becomes when one of its effects is dropped, each of which must earn its place.
    /// They are fitted again from where the fuller model ended: a search of theirs alone may have stopped elsewhere.
    fn subsets(&self, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let best = tried[0].clone();
        if best.added.len() < 2 {
            return Ok(());
        }
        let without = |k: usize| {
            let mut added = best.added.clone();
            added.remove(k);
            let model = self.model(&added);
            let warm = carried(&best.fit, &model, &vec![0.0; model.slots().len()]);
            Job { added, warm: vec![warm], starts: 0 }
        };
        self.make_all("without each", (0..best.added.len()).map(without).collect(), tried)?;
        // Dropped one by one: what is left over may have been a single effect all along.
        if tried[0].added.len() < best.added.len() { self.subsets(tried) } else { Ok(()) }
    }

    /// Where the best model leaves something, try the finer forms of its effects: stiction, a drift. Not for slow
    /// pushes: nothing says there that more is needed, and one speed does not tell stiction from sliding.
    fn refine(&self, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let size = tried[0].added.len();
        if size == 0 || self.comparison.is_quasi_static() {
            return Ok(());
        }
        let observations = self.comparison.observations();
        if remainder(self.comparison, &tried[0].fit)?.is_some_and(|left| !left.matters(observations)) {
            return Ok(());
        }
        // Rivals are refined too, and then once more from where the best one's refinements ended: which of two models is
        // better must not hang on whose stiction was found.
        self.make_all("finer forms", self.finer_jobs(tried, size, None), tried)?;
        let best = tried[0].clone();
        self.make_all("finer forms", self.finer_jobs(tried, size, Some(&best)), tried)
    }

    /// Fits of finer forms of the best models of a size, each of other kinds, from where `like` ended or from medians.
    fn finer_jobs(&self, tried: &[Tried], size: usize, like: Option<&Tried>) -> Vec<Job> {
        let mut seen = BTreeSet::new();
        let kinds = |t: &Tried| t.added.iter().map(|e| e.kind).collect::<BTreeSet<_>>();
        if let Some(like) = like {
            seen.insert(kinds(like));
        }
        let mut jobs = Vec::new();
        let coarse = |t: &&Tried| t.added.len() == size && t.added.iter().any(|e| finer(e).is_some());
        for best in tried.iter().filter(coarse).filter(|t| seen.insert(kinds(t))).take(REFINED) {
            for (k, effect) in best.added.iter().enumerate() {
                let Some(finer) = finer(effect) else { continue };
                if like.is_some_and(|like| !like.added.contains(&finer)) {
                    continue;
                }
                let mut added = best.added.clone();
                added[k] = finer;
                let model = self.model(&added);
                let coordinates = Coordinates::new(&model);
                let median = coordinates.values(&vec![0.0; coordinates.free().len()]).0;
                let fill = like.map_or_else(|| median.clone(), |like| carried(&like.fit, &model, &median));
                jobs.push(Job { warm: vec![self.refined(best, &model, &fill)], added, starts: 0 });
            }
        }
        jobs
    }

    /// Values of a model with finer effects: those of the simpler fit, the refinements' from `fill`.
    fn refined(&self, best: &Tried, model: &Model, fill: &[f64]) -> Vec<f64> {
        let simple: BTreeSet<String> = best.fit.estimates.iter().map(|e| e.name.clone()).collect();
        let mut values = carried(&best.fit, model, fill);
        for ((slot, value), fill) in model.slots().iter().zip(&mut values).zip(fill) {
            if slot.value.is_none() && !simple.contains(&slot.name) {
                *value = *fill;
            }
        }
        values
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
    Job { added, warm: warm.collect(), starts: 0 }
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

fn same(a: &[Effect], b: &[Effect]) -> bool {
    a.len() == b.len() && a.iter().all(|effect| b.contains(effect))
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
