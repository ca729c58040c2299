//! Backfitting: revise the models of the first search.
//!
//! The first search places each effect while the other parameters are biased by the missing ones. Once most
//! of the misfit is explained, backfitting searches the effects' shapes again, exchanges each effect for
//! others, drops each effect once, and fits refinements.

use super::fitting::Stages;
use super::{MAX_FURTHER_KINDS, Searcher, job, kinds, with_refinements};
use crate::fitted_model::{FittedModel, Job, simpler_sets, with_kinds};
use crate::proposals::has_shape;
use crate::thresholds::MIN_SIGNIFICANT_GAIN_NATS;
use std::collections::BTreeSet;
use trundle_infer::{Coordinates, InferError, transferred_values};
use trundle_model::{Effect, Kind, Model};

/// Most rounds of the search for shapes, and the share of the lack of fit that a round must gain for another
/// one.
const MAX_BACKFITTING_ROUNDS: usize = 3;
const MIN_GAIN_SHARE: f64 = 0.1;
/// Largest number of effects for which all subsets are fitted. Of larger models only subsets without one or
/// two effects are fitted.
const MAX_EFFECTS_FOR_ALL_SUBSETS: usize = 4;
/// Models of the best one's size whose refinements are fitted. Dry friction has two forms, at a point and
/// under the whole body.
const MAX_REFINED_MODELS: usize = 2;

impl Searcher<'_> {
    /// Search the shapes of the best model's effects again. The first search found them while other
    /// parameters were biased, and a fit does not cross edges.
    pub(super) fn backfit_shapes(&self, models: &mut Vec<FittedModel>) -> Result<(), InferError> {
        let best = kinds(&models[0].added);
        self.backfit_shapes_of(&best, models)?;
        // A competing model within the best one's lack of fit may only have a wrong place.
        let lack = self.engine.lack_of_fit(&models[0])?.map_or(0.0, |lack| lack.misfit());
        let near = |t: &&FittedModel| {
            t.added.len() == best.len() && kinds(&t.added) != best && t.fit.cost < models[0].fit.cost + lack
        };
        match models.iter().find(near).map(|t| kinds(&t.added)) {
            Some(competitor) => self.backfit_shapes_of(&competitor, models),
            None => Ok(()),
        }
    }

    /// Search the shapes of the best model with the given kinds again.
    pub(super) fn backfit_shapes_of(
        &self,
        of: &[Kind],
        models: &mut Vec<FittedModel>,
    ) -> Result<(), InferError> {
        for _ in 0..MAX_BACKFITTING_ROUNDS {
            let Some(index) = models.iter().position(|t| kinds(&t.added) == of) else { return Ok(()) };
            let best = models[index].clone();
            let Some(lack) = self.engine.lack_of_fit(&best)?.map(|lack| lack.misfit()) else { return Ok(()) };
            if best.is_settled || !self.is_inadequate(&best)? {
                return Ok(());
            }
            let Some(jobs) = self.shape_jobs(&best)? else { return Ok(()) };
            let target_cost = best.fit.cost - (lack * MIN_GAIN_SHARE).max(MIN_SIGNIFICANT_GAIN_NATS);
            let stages =
                Stages { what: "backfitting of shapes", most: jobs.len(), compared_with: Some(&best) };
            self.fit_in_stages(stages, jobs, models, |_| target_cost)?;
            match models.iter_mut().find(|t| kinds(&t.added) == of) {
                Some(now) if now.fit.cost > target_cost => now.is_settled = true,
                _ => {}
            }
        }
        Ok(())
    }

    /// Fits from the best shapes of each of a model's effects, with all else as fitted; `None` if shapes
    /// cannot be screened.
    fn shape_jobs(&self, best: &FittedModel) -> Result<Option<Vec<Job>>, InferError> {
        let mut jobs = Vec::new();
        for k in 0..best.added.len() {
            let kind = best.added[k].kind;
            if !has_shape(self.engine.nominal(), kind) {
                continue;
            }
            let (rest, effect) = self.split_off(best, k);
            let outline = kind.region(&effect);
            let regions: Vec<_> = outline.into_iter().chain(self.regions.iter().cloned()).collect();
            let options = self.screen_options(&regions, 1);
            let Some(found) = self.engine.starts(&rest, &[kind], &options, self.watch)? else {
                return Ok(None);
            };
            jobs.extend(found.iter().map(|starts| job(&rest, starts)));
        }
        Ok(Some(jobs))
    }

    /// Replace each effect of the best model by others. An effect that was found together with a wrong one
    /// may be wrong too.
    pub(super) fn exchange_effects(&self, models: &mut Vec<FittedModel>) -> Result<(), InferError> {
        let best = models[0].clone();
        if best.added.len() < 2 {
            return Ok(());
        }
        let mut jobs = Vec::new();
        for k in 0..best.added.len() {
            let (rest, _) = self.split_off(&best, k);
            jobs.extend(self.jobs(&rest, &self.offered(&rest), MAX_FURTHER_KINDS, 1)?);
        }
        self.fit_new("exchange of effects", jobs, MAX_FURTHER_KINDS * best.added.len(), models)
    }

    /// A model without effect number `k`, with all else as fitted, and the values of that effect. The cost of this
    /// model is not evaluated.
    fn split_off(&self, from: &FittedModel, k: usize) -> (FittedModel, Vec<f64>) {
        let mut rest = from.clone();
        rest.added.remove(k);
        rest.fit.cost = f64::INFINITY;
        let effect = rest.fit.model.effects.remove(self.engine.nominal().effects.len() + k);
        let slots = rest.fit.model.slots();
        rest.fit.values = slots.iter().map(|s| s.value.unwrap_or(0.0)).collect();
        rest.fit.estimates.retain(|e| slots.iter().any(|s| s.name == e.name));
        (rest, effect.values.iter().map(|v| v.unwrap_or(0.0)).collect())
    }

    /// Fit the best model without each of its effects, starting from the full model's values. A separate
    /// search may have stopped at another optimum.
    pub(super) fn drop_each_effect(&self, models: &mut Vec<FittedModel>) -> Result<(), InferError> {
        let best = models[0].clone();
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
        let subsets: Vec<_> = jobs.iter().map(|job| kinds(&job.added)).collect();
        self.fit_all("models without one effect", jobs, models)?;
        // The dropped effect may have compensated the wrong place of another.
        for subset in subsets {
            self.backfit_shapes_of(&subset, models)?;
        }
        // If a smaller model is now the best, drop its effects as well.
        if models[0].added.len() < best.added.len() { self.drop_each_effect(models) } else { Ok(()) }
    }

    /// Replace effects of the best model by the simpler laws that they contain. Left-out episodes decide
    /// which laws are needed.
    pub(super) fn fit_simpler_laws(&self, models: &mut Vec<FittedModel>) -> Result<(), InferError> {
        let best = models[0].clone();
        // A set of laws starts from the fit of its first ones.
        for size in 1.. {
            let (mut jobs, mut is_last) = (vec![], true);
            for (k, effect) in best.added.iter().enumerate() {
                let (rest, _) = self.split_off(&best, k);
                for limit in effect.kind.limiting_kinds() {
                    is_last &= limit.len() <= size;
                    if limit.len() == size {
                        jobs.extend(self.limit_job(&rest, limit, models)?);
                    }
                }
            }
            self.fit_all("simpler laws", jobs, models)?;
            if is_last {
                break;
            }
        }
        Ok(())
    }

    /// The fit of a model with further laws, of which the last is added to the fitted model with the others. It also
    /// starts from the values of the model without these laws.
    fn limit_job(
        &self,
        rest: &FittedModel,
        laws: &[Kind],
        models: &[FittedModel],
    ) -> Result<Option<Job>, InferError> {
        let Some((&last, others)) = laws.split_last() else { return Ok(None) };
        let fitted = with_kinds(models, [&kinds(&rest.added), others].concat());
        let parent = if others.is_empty() { Some(rest) } else { fitted };
        let Some(parent) = parent.filter(|parent| self.offered(parent).contains(&last)) else {
            return Ok(None);
        };
        // Far from its optimum, a screen may find no gain of a law.
        let screened = self.jobs(parent, &[last], 1, 1)?.pop();
        let mut job = screened.unwrap_or_else(|| self.unscreened(parent, last));
        let from_rest =
            job.warm.first().map(|fill| transferred_values(&rest.fit, &self.model(&job.added), fill));
        job.warm.extend(from_rest);
        Ok(Some(job))
    }

    /// Fit every subset of the best model's effects, so that each effect can be judged in combination with
    /// any others. The same applies to models with a simpler law in place of one effect.
    ///
    /// Each subset starts from the models with one effect more. A separate search may have stopped at another
    /// optimum, and an effect that is added to a badly placed one seems to be needed.
    pub(super) fn fit_subsets(&self, models: &mut Vec<FittedModel>) -> Result<(), InferError> {
        let best = models[0].clone();
        let with_simpler = simpler_sets(&best.added).filter_map(|kinds| with_kinds(models, kinds).cloned());
        let full_models: Vec<FittedModel> = std::iter::once(best.clone()).chain(with_simpler).collect();
        let largest = full_models.iter().map(|full| full.added.len()).max().unwrap_or(0);
        for size in (1..largest).rev() {
            let of = |full: &FittedModel| {
                let count = full.added.len();
                let is_fitted = count <= MAX_EFFECTS_FOR_ALL_SUBSETS || size + 2 >= count;
                let every = 1..(1usize << count) - 1;
                let subsets = every.filter(|subset| is_fitted && subset.count_ones() as usize == size);
                subsets.map(|subset| self.subset_job(full, subset, models)).collect::<Vec<Job>>()
            };
            let mut seen = BTreeSet::new();
            let jobs = full_models.iter().flat_map(of).filter(|job| seen.insert(kinds(&job.added))).collect();
            self.fit_all("subsets of the best model", jobs, models)?;
        }
        Ok(())
    }

    /// The fit of the effects of a model whose bits are set in `subset`.
    fn subset_job(&self, full: &FittedModel, subset: usize, models: &[FittedModel]) -> Job {
        let effects = |bits: usize| -> Vec<Effect> {
            let kept_effects = full.added.iter().enumerate().filter(|(k, _)| bits >> k & 1 == 1);
            kept_effects.map(|(_, effect)| effect.clone()).collect()
        };
        let model = self.model(&effects(subset));
        let fill = vec![0.0; model.slots().len()];
        let larger = (0..full.added.len()).map(|k| subset | 1 << k).filter(|bits| *bits != subset);
        let ended =
            larger.filter_map(|bits| with_kinds(models, effects(bits).iter().map(|e| e.kind).collect()));
        let warm = ended.map(|larger| transferred_values(&larger.fit, &model, &fill)).collect();
        Job::from(full, effects(subset), warm)
    }

    /// Fit the refinements of effects, such as static friction or a drift, if the best model has a
    /// significant lack of fit. Slow pushes are excluded: they have no lack-of-fit test, and a single speed
    /// does not distinguish static from sliding friction.
    pub(super) fn fit_refinements(&self, models: &mut Vec<FittedModel>) -> Result<(), InferError> {
        let size = models[0].added.len();
        if size == 0 || self.engine.is_quasi_static() {
            return Ok(());
        }
        // Fitted noise would absorb the misfit of a coarse form.
        let observations = self.engine.observations();
        let lack = self.engine.lack_of_fit(&self.with_instrument_noise(&models[0]))?;
        if lack.is_some_and(|lack| !lack.is_significant(observations)) {
            return Ok(());
        }
        // Competing models are refined too, and once more from the best one's refinements, so that the
        // comparison does not depend on which refinement was found.
        self.fit_all("refinements", self.refinement_jobs(models, size, None), models)?;
        let best = models[0].clone();
        self.fit_all("refinements", self.refinement_jobs(models, size, Some(&best)), models)
    }

    /// Fits of refinements of the best models of a size and of the best model without one effect, which may
    /// only compensate a coarse form. They start from the values of `like`, or from prior medians.
    fn refinement_jobs(&self, models: &[FittedModel], size: usize, like: Option<&FittedModel>) -> Vec<Job> {
        let mut seen = BTreeSet::new();
        if let Some(like) = like {
            seen.insert(kinds(&like.added));
        }
        let mut jobs = Vec::new();
        let coarse = |t: &&FittedModel| t.added.iter().any(|e| with_refinements(e).is_some());
        let of_size = models.iter().filter(|t| t.added.len() == size).filter(coarse);
        let competitors: Vec<_> =
            of_size.filter(|t| seen.insert(kinds(&t.added))).take(MAX_REFINED_MODELS).collect();
        let best = &models[0];
        let less = (0..best.added.len()).filter_map(|k| {
            let kept = best.added.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, e)| e.kind);
            with_kinds(models, kept.collect()).filter(coarse)
        });
        let less: Vec<_> = less.filter(|t| seen.insert(kinds(&t.added))).collect();
        for best in competitors.into_iter().chain(less) {
            for (k, effect) in best.added.iter().enumerate() {
                let Some(with_refinements) = with_refinements(effect) else { continue };
                if like.is_some_and(|like| !like.added.contains(&with_refinements)) {
                    continue;
                }
                let mut added = best.added.clone();
                added[k] = with_refinements;
                let model = self.model(&added);
                let coordinates = Coordinates::new(&model);
                let median = coordinates.values(&vec![0.0; coordinates.free().len()]).0;
                let fill = like
                    .map_or_else(|| median.clone(), |like| transferred_values(&like.fit, &model, &median));
                let warm = vec![self.refined_values(best, &model, &fill)];
                jobs.push(Job::from(best, added, warm));
            }
        }
        jobs
    }

    /// Values of a model with refinements: the simpler fit's values, and `fill` for the refinements.
    fn refined_values(&self, best: &FittedModel, model: &Model, fill: &[f64]) -> Vec<f64> {
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
