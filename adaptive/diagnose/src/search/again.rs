//! Second thoughts: what the search found is sought again from where it now stands.
//!
//! A first search looks beside parameters that have bent to what is missing. Once most of it is explained, shapes are
//! sought again, other effects are tried in place of each, each is dropped once, and finer forms are tried.

use super::{MORE, Searcher, finer, job, kinds};
use crate::engine::{Job, Tried};
use crate::naming::of_kinds;
use crate::proposals::has_shape;
use crate::thresholds::CHANCE;
use std::collections::BTreeSet;
use trundle_infer::{Coordinates, InferError, transferred_values};
use trundle_model::{Effect, Kind, Model};

/// How often shapes are sought again, while that takes this share of what was left, and more than chance would.
const AGAIN: usize = 3;
const SETTLED: f64 = 0.1;
/// Effects of a model of which every part is fitted; of more, those that lack one or two.
const WHOLLY: usize = 4;
/// Models of the best one's size whose finer forms are tried: dry friction has two forms, at a point and under a body.
const REFINED: usize = 2;

impl Searcher<'_> {
    /// Seek the shapes of the best model's effects again, each from what the fit says of all else: they were sought
    /// beside parameters that had bent to what was missing, and a fit finds no way across an edge.
    pub(super) fn shapes_again(&self, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let best = kinds(&tried[0].added);
        self.shapes_of(&best, tried)?;
        // A rival that comes as close as the best one leaves may only stand at the wrong place.
        let left = self.engine.remainder(&tried[0])?.map_or(0.0, |left| left.misfit());
        let near = |t: &&Tried| {
            t.added.len() == best.len() && kinds(&t.added) != best && t.fit.cost < tried[0].fit.cost + left
        };
        match tried.iter().find(near).map(|t| kinds(&t.added)) {
            Some(rival) => self.shapes_of(&rival, tried),
            None => Ok(()),
        }
    }

    /// The same of the best model of some kinds.
    fn shapes_of(&self, of: &[Kind], tried: &mut Vec<Tried>) -> Result<(), InferError> {
        for _ in 0..AGAIN {
            let Some(index) = tried.iter().position(|t| kinds(&t.added) == of) else { return Ok(()) };
            let best = tried[index].clone();
            let Some(left) = self.engine.remainder(&best)?.map(|left| left.misfit()) else { return Ok(()) };
            if best.settled || !self.leaves_much(&best)? {
                return Ok(());
            }
            let Some(jobs) = self.shape_jobs(&best)? else { return Ok(()) };
            let enough = best.fit.cost - (left * SETTLED).max(CHANCE);
            self.try_these("places again", jobs, tried, |_| enough)?;
            match tried.iter_mut().find(|t| kinds(&t.added) == of) {
                Some(now) if now.fit.cost > enough => now.settled = true,
                _ => {}
            }
        }
        Ok(())
    }

    /// Fits from the best shapes of each of a model's effects, all else as it was fitted; `None` where shapes cannot be
    /// screened.
    fn shape_jobs(&self, best: &Tried) -> Result<Option<Vec<Job>>, InferError> {
        let mut jobs = Vec::new();
        for k in 0..best.added.len() {
            let kind = best.added[k].kind;
            if !has_shape(self.engine.nominal(), kind) {
                continue;
            }
            let (rest, effect) = self.apart(best, k);
            let outline = kind.region(&effect);
            let regions: Vec<_> = outline.into_iter().chain(self.regions.iter().cloned()).collect();
            let wanted = self.wanted(&regions, 1);
            let Some(found) = self.engine.starts(&rest, &[kind], &wanted, self.watch)? else {
                return Ok(None);
            };
            jobs.extend(found.iter().map(|starts| job(&rest, starts)));
        }
        Ok(Some(jobs))
    }

    /// Other effects in place of each of the best model's: one that was found beside the wrong other may be wrong itself.
    pub(super) fn exchange(&self, tried: &mut Vec<Tried>) -> Result<(), InferError> {
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
        let effect = rest.fit.model.effects.remove(self.engine.nominal().effects.len() + k);
        let slots = rest.fit.model.slots();
        rest.fit.values = slots.iter().map(|s| s.value.unwrap_or(0.0)).collect();
        rest.fit.estimates.retain(|e| slots.iter().any(|s| s.name == e.name));
        (rest, effect.values.iter().map(|v| v.unwrap_or(0.0)).collect())
    }

    /// The models that the best one becomes when one of its effects is dropped, each of which must earn its place.
    /// They are fitted again from where the fuller model ended: a search of theirs alone may have stopped elsewhere.
    pub(super) fn subsets(&self, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let best = tried[0].clone();
        if best.added.len() < 2 {
            return Ok(());
        }
        let without = |k: usize| {
            let mut added = best.added.clone();
            added.remove(k);
            let model = self.model(&added);
            let warm = transferred_values(&best.fit, &model, &vec![0.0; model.slots().len()]);
            Job::from(&best, added, vec![warm])
        };
        let jobs: Vec<Job> = (0..best.added.len()).map(without).collect();
        let parts: Vec<_> = jobs.iter().map(|job| kinds(&job.added)).collect();
        self.make_all("without each", jobs, tried)?;
        // What was dropped may have stood for the wrong place of another.
        for part in parts {
            self.shapes_of(&part, tried)?;
        }
        // Dropped one by one: what is left over may have been a single effect all along.
        if tried[0].added.len() < best.added.len() { self.subsets(tried) } else { Ok(()) }
    }

    /// The simpler law in place of each of the best model's effects that has one: whether the richer one is needed is for
    /// left-out episodes to say.
    pub(super) fn simpler(&self, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let best = tried[0].clone();
        let mut jobs = vec![];
        for (k, effect) in best.added.iter().enumerate() {
            let (rest, _) = self.apart(&best, k);
            let offered = self.offered(&rest);
            let simpler: Vec<Kind> =
                effect.kind.simpler().into_iter().filter(|s| offered.contains(s)).collect();
            jobs.extend(self.jobs(&rest, &simpler, 1)?);
        }
        self.make_all("simpler laws", jobs, tried)
    }

    /// Fit every part of the best model, so that each effect can be judged together with any of the others; and of the same
    /// with a simpler law in place of one of its effects, which may turn out to be the one to name. A part
    /// is fitted from where each model with one effect more ended: a search of its own may have stopped elsewhere, and what
    /// is added to a model at a wrong place seems to be needed.
    pub(super) fn parts(&self, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let best = tried[0].clone();
        let with_simpler = best.added.iter().enumerate().filter_map(|(k, effect)| {
            let mut kinds: Vec<Kind> = best.added.iter().map(|e| e.kind).collect();
            kinds[k] = effect.kind.simpler()?;
            of_kinds(tried, kinds).cloned()
        });
        let wholes: Vec<Tried> = std::iter::once(best.clone()).chain(with_simpler).collect();
        let count = best.added.len();
        for size in (1..count).rev().take_while(|size| count <= WHOLLY || size + 2 >= count) {
            let of = |whole| {
                let parts = (1..(1usize << count) - 1).filter(|part| part.count_ones() as usize == size);
                parts.map(|part| self.part(whole, part, tried)).collect::<Vec<Job>>()
            };
            let mut seen = BTreeSet::new();
            let jobs = wholes.iter().flat_map(of).filter(|job| seen.insert(kinds(&job.added))).collect();
            self.make_all("parts of the best", jobs, tried)?;
        }
        Ok(())
    }

    /// The fit of some effects of a model, those whose bits are set in `part`.
    fn part(&self, whole: &Tried, part: usize, tried: &[Tried]) -> Job {
        let effects = |bits: usize| -> Vec<Effect> {
            let held = whole.added.iter().enumerate().filter(|(k, _)| bits >> k & 1 == 1);
            held.map(|(_, effect)| effect.clone()).collect()
        };
        let model = self.model(&effects(part));
        let fill = vec![0.0; model.slots().len()];
        let larger = (0..whole.added.len()).map(|k| part | 1 << k).filter(|bits| *bits != part);
        let ended = larger.filter_map(|bits| of_kinds(tried, effects(bits).iter().map(|e| e.kind).collect()));
        let warm = ended.map(|larger| transferred_values(&larger.fit, &model, &fill)).collect();
        Job::from(whole, effects(part), warm)
    }

    /// Where the best model leaves something, try the finer forms of its effects: stiction, a drift. Not for slow
    /// pushes: nothing says there that more is needed, and one speed does not tell stiction from sliding.
    pub(super) fn refine(&self, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let size = tried[0].added.len();
        if size == 0 || self.engine.is_quasi_static() {
            return Ok(());
        }
        // Noise that is fitted holds what a coarse form leaves.
        let observations = self.engine.observations();
        let left = self.engine.remainder(&self.as_read(&tried[0]))?;
        if left.is_some_and(|left| !left.matters(observations)) {
            return Ok(());
        }
        // Rivals are refined too, and then once more from where the best one's refinements ended: which of two models is
        // better must not hang on whose stiction was found.
        self.make_all("finer forms", self.finer_jobs(tried, size, None), tried)?;
        let best = tried[0].clone();
        self.make_all("finer forms", self.finer_jobs(tried, size, Some(&best)), tried)
    }

    /// Fits of finer forms of the best models of a size, each of other kinds, and of the best one less an effect, which may
    /// only make up for a form that is too coarse; from where `like` ended or from medians.
    fn finer_jobs(&self, tried: &[Tried], size: usize, like: Option<&Tried>) -> Vec<Job> {
        let mut seen = BTreeSet::new();
        if let Some(like) = like {
            seen.insert(kinds(&like.added));
        }
        let mut jobs = Vec::new();
        let coarse = |t: &&Tried| t.added.iter().any(|e| finer(e).is_some());
        let of_size = tried.iter().filter(|t| t.added.len() == size).filter(coarse);
        let rivals: Vec<_> = of_size.filter(|t| seen.insert(kinds(&t.added))).take(REFINED).collect();
        let best = &tried[0];
        let less = (0..best.added.len()).filter_map(|k| {
            let kept = best.added.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, e)| e.kind);
            of_kinds(tried, kept.collect()).filter(coarse)
        });
        let less: Vec<_> = less.filter(|t| seen.insert(kinds(&t.added))).collect();
        for best in rivals.into_iter().chain(less) {
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
                let fill = like
                    .map_or_else(|| median.clone(), |like| transferred_values(&like.fit, &model, &median));
                let warm = vec![self.refined(best, &model, &fill)];
                jobs.push(Job::from(best, added, warm));
            }
        }
        jobs
    }

    /// Values of a model with finer effects: those of the simpler fit, the refinements' from `fill`.
    fn refined(&self, best: &Tried, model: &Model, fill: &[f64]) -> Vec<f64> {
        let simple: BTreeSet<String> = best.fit.estimates.iter().map(|e| e.name.clone()).collect();
        let mut values = transferred_values(&best.fit, model, fill);
        for ((slot, value), fill) in model.slots().iter().zip(&mut values).zip(fill) {
            if slot.value.is_none() && !simple.contains(&slot.name) {
                *value = *fill;
            }
        }
        values
    }
}
