//! Search over models: fit single effects, and several together while the data demand it.
//!
//! A score test screens every candidate. The candidates with the largest promised gain are fitted, starting
//! from the Newton step of the screen. If more is missing, sets of effects are screened together ([`sets`])
//! and one more effect is added to each of the best models. Backfitting ([`backfitting`]) then exchanges
//! effects that mask each other.

mod backfitting;
mod effects;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod nested;
mod prior;
mod sets;
mod start;

use crate::candidates::name;
use crate::engine::Engine;
use crate::fitted_model::with_kinds;
use crate::fitted_model::{Effort, FittedModel, Job};
use crate::lack_of_fit::LackOfFit;
use crate::linearisation::Start;
use crate::locate::Located;
use crate::screen::{MIN_SCREEN_GAIN_NATS, ScreenOptions};
use crate::thresholds::MIN_MATERIAL_ERROR_RATIO;
use effects::{have_same_effects, kinds, with_refinements};
use prior::log_prior;
pub(crate) use prior::probabilities;
use rayon::prelude::*;
use start::{job, with_free_parameters};
use std::collections::BTreeSet;
use trundle_infer::{Coordinates, InferError, Watch, on_all_cores, transferred_values};
use trundle_model::{Effect, Kind, MAX_INNER_STATES, Model};

/// Result of the search: the fitted models, best first.
pub(crate) struct SearchResult {
    pub tried: Vec<FittedModel>,
    /// Lack of fit of the nominal model.
    pub before: Option<LackOfFit>,
    /// Where the nominal model disagrees with the recording.
    pub located: Located,
}

/// Kinds that are always fitted, whatever their promised gain.
const ALWAYS_FITTED_KINDS: usize = 3;
/// Most kinds that are ranked in addition to the nominal model, and in addition to a larger model.
const MAX_FIRST_KINDS: usize = 9;
const MAX_FURTHER_KINDS: usize = 3;
/// Kinds that are fitted to thinned data for each one that is ranked. The screen linearises laws far from their
/// optimum, so that its order is less reliable than that of these fits.
const SCREENED_PER_RANKED_KIND: usize = 2;
/// Models of one size to which one more effect is added.
const MAX_PARENT_MODELS: usize = 2;
/// Most effects that are added. The evidence decides whether an effect is needed; this limit only bounds the
/// time.
const MAX_EFFECTS: usize = 4;
/// Starting points for each kind.
const STARTS_PER_KIND: usize = 2;
/// Gain of a random-walk wrench above which a further effect is sought, nats per sample.
const MIN_LACK_OF_FIT_PER_SAMPLE_NATS: f64 = 0.15;
/// Largest cost above that of the best model, after the ranking fit, at which a model is fitted to its
/// optimum: in nats, and as a share of the best model's gain. Each model is credited with
/// `EXTRAPOLATED_STEPS` further steps like its last one.
const MAX_COST_GAP_NATS: f64 = 30.0;
const MAX_COST_GAP_SHARE: f64 = 0.1;
const EXTRAPOLATED_STEPS: f64 = 10.0;
/// Draws from the prior that start a candidate without a screen, in addition to the prior median.
const PRIOR_DRAWS: usize = 3;

#[derive(Clone, Copy)]
pub(crate) struct Searcher<'a> {
    pub engine: &'a dyn Engine,
    /// Effects to exclude, by their names in a diagnosis.
    pub without: &'a [String],
    /// Parts of the floor that seem to add friction: convex polygons, world, m. They are known once the
    /// nominal model is fitted.
    pub regions: &'a [Vec<[f64; 2]>],
    pub seed: u64,
    pub watch: &'a dyn Watch,
}

impl Searcher<'_> {
    /// Run the whole search.
    pub fn run(&self) -> Result<SearchResult, InferError> {
        self.watch.progress("the simulation under test", 0.0);
        let base = self.engine.base(self.seed, self.watch)?;
        let before = self.engine.lack_of_fit(&base)?;
        let located = self.engine.located(&base, before)?;
        let regions: Vec<_> = located.regions.iter().map(|r| r.polygon.clone()).collect();
        let engine_for_effects = self.engine.for_added_effects(&base, before, self.watch)?;
        let tried =
            Searcher { engine: &*engine_for_effects, regions: &regions, ..*self }.with_added_effects(base)?;
        Ok(SearchResult { tried, before, located })
    }

    /// Models with one effect, and with more while the data demand it; best first.
    fn with_added_effects(&self, base: FittedModel) -> Result<Vec<FittedModel>, InferError> {
        let mut tried = vec![base.clone()];
        let offered = self.offered(&base);
        let jobs = self.jobs(&base, &offered, MAX_FIRST_KINDS)?;
        self.try_all("single effects", jobs, MAX_FIRST_KINDS, &mut tried)?;
        self.backfit_shapes(&mut tried)?;
        self.simpler(&mut tried)?;
        self.fit_refinements(&mut tried)?;
        let mut before = base;
        for _ in 1..MAX_EFFECTS {
            let best = tried[0].clone();
            let size = best.added.len();
            if size == 0 || size >= MAX_EFFECTS || !self.needs_more_effects(&before, &best)? {
                break;
            }
            if before.added.is_empty() {
                self.sets(&before, &mut tried)?;
            }
            if tried[0].added.len() <= size {
                self.one_more(size, &mut tried)?;
            }
            self.backfit_shapes(&mut tried)?;
            self.exchange_effects(&mut tried)?;
            self.backfit_shapes(&mut tried)?;
            self.simpler(&mut tried)?;
            self.drop_each_effect(&mut tried)?;
            self.fit_refinements(&mut tried)?;
            before = best;
        }
        self.fit_subsets(&mut tried)?;
        Ok(tried)
    }

    /// Kinds of effects that may be added to a model.
    fn offered(&self, to: &FittedModel) -> Vec<Kind> {
        let free_states = MAX_INNER_STATES.saturating_sub(to.fit.model.inner().len());
        let allowed = |kind: &Kind| {
            let (effect, states) = (kind.spec().effect, kind.spec().inner_states.len());
            let is_compatible = |e: &Effect| name(e) != effect || kind.may_repeat() && e.kind == *kind;
            states <= free_states && to.added.iter().all(is_compatible) && self.is_allowed(*kind)
        };
        self.engine.candidates().into_iter().filter(allowed).collect()
    }

    fn is_allowed(&self, kind: Kind) -> bool {
        self.without.iter().all(|name| name != kind.spec().effect)
    }

    /// The most promising fits of one more effect, of which at most `most` kinds will be ranked.
    fn jobs(&self, from: &FittedModel, offered: &[Kind], most: usize) -> Result<Vec<Job>, InferError> {
        let Some(found) =
            self.engine.starts(from, offered, &self.screen_options(self.regions, most), self.watch)?
        else {
            return Ok(offered.iter().map(|&kind| self.unscreened(from, kind)).collect());
        };
        let is_promising = |(rank, starts): &(usize, &Vec<Start>)| {
            *rank < ALWAYS_FITTED_KINDS || starts[0].gain > MIN_SCREEN_GAIN_NATS
        };
        let screened = if self.engine.thinned().is_some() { SCREENED_PER_RANKED_KIND * most } else { most };
        let kept = found.iter().take(screened).enumerate().filter(is_promising);
        Ok(kept.map(|(_, starts)| job(from, starts)).collect())
    }

    fn screen_options<'a>(&self, regions: &'a [Vec<[f64; 2]>], most: usize) -> ScreenOptions<'a> {
        ScreenOptions { regions, starts: STARTS_PER_KIND, most, seed: self.seed }
    }

    /// A fit from the smaller model's values, with the new effect's parameters at the prior median and at
    /// draws from the prior.
    fn unscreened(&self, from: &FittedModel, kind: Kind) -> Job {
        use rand::SeedableRng;
        let mut added = from.added.clone();
        added.push(Effect::free(kind));
        let model = self.model(&added);
        let coordinates = Coordinates::new(&model);
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(self.seed);
        let median = coordinates.values(&vec![0.0; coordinates.free().len()]).0;
        let draws = (0..PRIOR_DRAWS).map(|_| coordinates.values(&coordinates.draw(&mut rng)).0);
        let fills: Vec<_> = std::iter::once(median).chain(draws).collect();
        let warm = fills.iter().map(|fill| transferred_values(&from.fit, &model, fill)).collect();
        Job::from(from, added, warm)
    }

    fn model(&self, added: &[Effect]) -> Model {
        let mut model = self.engine.nominal().clone();
        model.effects.extend(added.iter().cloned());
        model
    }

    /// Fit models that were not fitted before, of which at most `most` are ranked. Only those that may still become
    /// the best are fitted to their optimum.
    fn try_all(
        &self,
        what: &'static str,
        jobs: Vec<Job>,
        most: usize,
        tried: &mut Vec<FittedModel>,
    ) -> Result<(), InferError> {
        let is_new = |job: &Job| tried.iter().all(|t| !have_same_effects(&t.added, &job.added));
        let jobs: Vec<Job> = jobs.into_iter().filter(is_new).collect();
        let (known, from) = (lowest(tried.iter().map(|t| t.fit.cost)), lowest(jobs.iter().map(|j| j.from)));
        self.fit_in_stages(what, jobs, most, tried, |ranked| {
            let best = lowest(ranked.iter().map(|t| t.fit.cost)).min(known);
            best + MAX_COST_GAP_NATS.max(MAX_COST_GAP_SHARE * (from - best))
        })
    }

    /// Fit models in three stages: on thinned data, a few steps on all data for the best `most` of them, and to the
    /// optimum if the cost may still fall below `bound` of the ranked models.
    fn fit_in_stages(
        &self,
        what: &'static str,
        jobs: Vec<Job>,
        most: usize,
        tried: &mut Vec<FittedModel>,
        bound: impl Fn(&[FittedModel]) -> f64,
    ) -> Result<(), InferError> {
        let Some(thinned) = self.engine.thinned() else { return self.fit_all(what, jobs, tried) };
        let continued = |t: &FittedModel| Job::from(t, t.added.clone(), vec![t.fit.values.clone()]);
        let cheaper = Searcher { engine: &*thinned, ..*self };
        let given = jobs.clone();
        let mut screened = cheaper.fitted(what, jobs, Effort::Screening)?;
        screened.sort_by(|a, b| b.log_weight().total_cmp(&a.log_weight()));
        screened.truncate(most);
        let mut ranked = vec![];
        let once = screened.iter().map(continued).collect();
        insert_models(&mut ranked, self.fitted(what, once, Effort::Ranking)?);
        // The fit to thinned data may have increased the cost. Such a model is ranked from its first starts too.
        let with_first_starts = |t: &FittedModel| {
            let first = given.iter().find(|job| job.added == t.added)?;
            let is_lower = |r: &FittedModel| r.added == t.added && r.fit.cost < first.from;
            let warm = [vec![t.fit.values.clone()], first.warm.clone()].concat();
            (!ranked.iter().any(is_lower)).then(|| Job::from(t, t.added.clone(), warm))
        };
        let repeated = screened.iter().filter_map(with_first_starts).collect();
        insert_models(&mut ranked, self.fitted(what, repeated, Effort::Ranking)?);
        let bound = bound(&ranked);
        let is_promising = |t: &FittedModel| t.fit.cost - EXTRAPOLATED_STEPS * t.fit.last_decrease < bound;
        let (promising, others): (Vec<FittedModel>, Vec<FittedModel>) =
            ranked.into_iter().partition(is_promising);
        let optima = self.fitted(what, promising.iter().map(continued).collect(), Effort::Full)?;
        insert_models(tried, optima.into_iter().chain(others));
        Ok(())
    }

    /// Fit models to their optimum, including models that were fitted before.
    fn fit_all(
        &self,
        what: &'static str,
        jobs: Vec<Job>,
        tried: &mut Vec<FittedModel>,
    ) -> Result<(), InferError> {
        insert_models(tried, self.fitted(what, jobs, Effort::Full)?);
        Ok(())
    }

    /// Fit models in parallel. Models that cannot be evaluated at any starting point are left out; this
    /// happens under noise that was fitted with more effects.
    fn fitted(
        &self,
        what: &'static str,
        jobs: Vec<Job>,
        effort: Effort,
    ) -> Result<Vec<FittedModel>, InferError> {
        self.watch.progress(what, 0.0);
        let offered = self.engine.candidates().iter().filter(|kind| self.is_allowed(**kind)).count();
        let (count, done) = (jobs.len(), std::sync::atomic::AtomicUsize::new(0));
        on_all_cores(self.watch, |watch| {
            let one = |job: Job| {
                let prior = log_prior(job.added.len(), offered);
                let found = self.engine.fit(job, effort, self.seed, watch);
                let found = found.map(|tried| FittedModel { log_prior: prior, ..tried });
                let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                watch.progress(what, done as f64 / count as f64);
                found
            };
            let all: Vec<_> = jobs.into_par_iter().map(one).collect();
            all.into_iter().filter(|found| !matches!(found, Err(InferError::NoStart { .. }))).collect()
        })
    }

    /// Add one more effect to the best models with `size` effects.
    fn one_more(&self, size: usize, tried: &mut Vec<FittedModel>) -> Result<(), InferError> {
        let mut parents: Vec<FittedModel> =
            tried.iter().filter(|t| t.added.len() == size).take(MAX_PARENT_MODELS).cloned().collect();
        let simpler = |t: &FittedModel| {
            with_kinds(tried, t.added.iter().map(|e| e.kind.limiting_kind().unwrap_or(e.kind)).collect())
        };
        let with_simpler: Vec<FittedModel> = parents
            .iter()
            .filter(|t| t.added.iter().any(|e| e.kind.limiting_kind().is_some()))
            .filter_map(simpler)
            .cloned()
            .collect();
        parents.extend(with_simpler);
        let mut jobs = Vec::new();
        for first in &parents {
            jobs.extend(self.jobs(first, &self.offered(first), MAX_FURTHER_KINDS)?);
        }
        let mut seen = BTreeSet::new();
        jobs.retain(|job| seen.insert(kinds(&job.added)));
        self.try_all("several effects", jobs, MAX_FURTHER_KINDS * parents.len(), tried)
    }

    /// Whether the lack of fit under the instruments' noise is larger than that of a law with a slightly
    /// wrong shape, or the prediction errors are material. Fitted noise would absorb unmodelled effects.
    fn is_inadequate(&self, tried: &FittedModel) -> Result<bool, InferError> {
        let observations = self.engine.observations() as f64;
        let Some(lack) = self.engine.lack_of_fit(&self.with_instrument_noise(tried))? else {
            return Ok(true);
        };
        Ok(lack.gain > MIN_LACK_OF_FIT_PER_SAMPLE_NATS * observations
            || self.engine.predictive_check(tried)?.is_material())
    }

    /// Whether to seek one more effect after `best` replaced the smaller model `before`.
    ///
    /// The new model must be inadequate, and its errors must exceed the instruments' noise; otherwise any
    /// further effect would be immaterial. Its last effect must have gained its [`fair_share`] of the
    /// previous lack of fit. If the remaining lack of fit is not significant, the last effect must have
    /// improved the predictions by a material share.
    fn needs_more_effects(&self, before: &FittedModel, best: &FittedModel) -> Result<bool, InferError> {
        let is_inadequate = self.is_inadequate(best)? && self.engine.errs_beyond_noise(best)?;
        if !is_inadequate || before.added.is_empty() {
            return Ok(is_inadequate);
        }
        let [previous, current] = [before, best].map(|tried| self.engine.lack_of_fit(tried));
        let (Some(previous), Some(current)) = (previous?, current?) else { return Ok(true) };
        if current.is_significant(self.engine.observations()) {
            return Ok(before.fit.cost - best.fit.cost >= fair_share(before.added.len()) * previous.misfit());
        }
        let [previous, current] = [before, best].map(|tried| self.engine.predictive_check(tried));
        Ok(current?.share * MIN_MATERIAL_ERROR_RATIO < previous?.share)
    }
}

/// Share of a model's lack of fit that the next effect must gain for a further one to be sought, where
/// `effects` is the number of effects in the model. If the effects that may still be added explain
/// everything, the largest explains at least an equal share. An effect that gains less only compensates for
/// physics outside the catalogue.
fn fair_share(effects: usize) -> f64 {
    1.0 / MAX_EFFECTS.saturating_sub(effects).max(1) as f64
}

/// The lowest of some costs.
fn lowest(costs: impl Iterator<Item = f64>) -> f64 {
    costs.fold(f64::INFINITY, f64::min)
}

/// Insert models into the tried ones, sorted by weight. Of models with the same effects only the best is
/// kept.
fn insert_models(tried: &mut Vec<FittedModel>, more: impl IntoIterator<Item = FittedModel>) {
    tried.extend(more);
    tried.sort_by(|a, b| b.log_weight().total_cmp(&a.log_weight()));
    let mut kept: Vec<FittedModel> = Vec::with_capacity(tried.len());
    for one in tried.drain(..) {
        if kept.iter().all(|k| !have_same_effects(&k.added, &one.added)) {
            kept.push(one);
        }
    }
    *tried = kept;
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{MAX_EFFECTS, Searcher, fair_share, kinds};
    use crate::engine::Engine;
    use crate::engine::own::Own;
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::Quiet;
    use trundle_model::Kind;

    #[test]
    fn more_kinds_are_fitted_to_thinned_data_than_ranked() {
        let slope = effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]);
        let data = World::of(locked().with(slope)).recording(3);
        let engine = Own::new(&data, None).unwrap();
        let base = engine.base(0, &Quiet).unwrap();
        let searcher = Searcher { engine: &engine, without: &[], regions: &[], seed: 0, watch: &Quiet };
        let jobs = searcher.jobs(&base, &searcher.offered(&base), 4).unwrap();
        assert_eq!(jobs.len(), 8);
        let mut tried = vec![base];
        searcher.try_all("single effects", jobs, 4, &mut tried).unwrap();
        assert_eq!(tried.len(), 1 + 4);
        assert_eq!(kinds(&tried[0].added), [Kind::FloorSlope]);
    }

    #[test]
    fn the_fair_share_is_equal_for_all_effects() {
        let shares: Vec<f64> = (0..MAX_EFFECTS).map(fair_share).collect();
        let mut remaining = 1.0;
        for share in shares {
            assert!((remaining * share - 1.0 / MAX_EFFECTS as f64).abs() < 1e-12);
            remaining *= 1.0 - share;
        }
        assert!(remaining.abs() < 1e-12);
    }
}
