//! Search over models: fit single effects, and several together while the data demand it.
//!
//! A score test screens every candidate. The candidates with the largest promised gain are fitted, starting
//! from the Newton step of the screen. If more is missing, sets of effects are screened together ([`sets`])
//! and one more effect is added to each of the best models. Backfitting ([`backfitting`]) then exchanges
//! effects that mask each other.

mod backfitting;
mod effects;
mod fitting;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod nested;
mod prior;
mod sets;
mod softened;
mod start;

use crate::answer::Verdict;
use crate::candidates::name;
use crate::engine::Engine;
use crate::fitted_model::{FittedModel, Job, simpler_sets, with_kinds};
use crate::lack_of_fit::LackOfFit;
use crate::linearisation::Start;
use crate::locate::Located;
use crate::screen::{MIN_SCREEN_GAIN_NATS, ScreenOptions};
use crate::thresholds::MIN_MATERIAL_ERROR_RATIO;
use crate::verdict::verdict_of;
use effects::{have_same_effects, kinds, with_refinements};
pub(crate) use prior::probabilities;
use start::{job, with_free_parameters};
use std::collections::BTreeSet;
use trundle_infer::{Coordinates, InferError, Watch, transferred_values};
use trundle_model::{Effect, Kind, MAX_INNER_STATES, Model};

/// Result of the search: the fitted models, best first.
pub(crate) struct SearchResult {
    pub models: Vec<FittedModel>,
    /// Lack of fit of the nominal model.
    pub before: Option<LackOfFit>,
    /// Where the nominal model disagrees with the recording.
    pub located: Located,
    /// Whether even the best model leaves more than a named model may. It is then not compared with simpler ones.
    pub has_large_residual: bool,
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
/// Successive effects without a material gain after which a further one is still sought. Effects can mask each
/// other, so that only two of them together gain what is missing.
const LOOK_AHEAD: usize = 1;
/// Starting points for each kind.
const STARTS_PER_KIND: usize = 2;
/// Gain of a random-walk wrench above which a further effect is sought, nats per sample.
const MIN_LACK_OF_FIT_PER_SAMPLE_NATS: f64 = 0.15;
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
    /// Whether the engine adds a random-walk wrench, with which errors of predictions are not judged.
    pub is_softened: bool,
    pub seed: u64,
    pub watch: &'a dyn Watch,
}

impl<'a> Searcher<'a> {
    /// A search without regions, which follow from the nominal fit.
    pub fn new(engine: &'a dyn Engine, without: &'a [String], seed: u64, watch: &'a dyn Watch) -> Self {
        Self { engine, without, regions: &[], is_softened: false, seed, watch }
    }
}

impl Searcher<'_> {
    /// Run the whole search.
    pub fn run(&self) -> Result<SearchResult, InferError> {
        self.watch.progress("the simulation under test", 0.0);
        let base = self.with_softened_start(self.engine.base(self.seed, self.watch)?)?;
        let before = self.engine.lack_of_fit(&base)?;
        let located = self.engine.located(&base, before)?;
        let regions: Vec<_> = located.regions.iter().map(|r| r.polygon.clone()).collect();
        let engine_for_effects = self.engine.for_added_effects(&base, before, self.watch)?;
        let searcher = Searcher { engine: &*engine_for_effects, regions: &regions, ..*self };
        let mut models = vec![base.clone()];
        searcher.add_single_effects(&base, &mut models)?;
        let improved = searcher.search_softened(&base, &mut models)?;
        searcher.add_effects(&base, &improved, &mut models)?;
        let has_large_residual = !models[0].added.is_empty()
            && verdict_of(&*engine_for_effects, before, &base, &models[0])?.0 == Verdict::Unexplained;
        if !has_large_residual {
            searcher.simplify(&mut models)?;
        }
        Ok(SearchResult { models, before, located, has_large_residual })
    }

    /// Models with one effect.
    fn add_single_effects(
        &self,
        base: &FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<(), InferError> {
        let jobs = self.jobs(base, &self.offered(base), MAX_FIRST_KINDS, SCREENED_PER_RANKED_KIND)?;
        self.fit_new("single effects", jobs, MAX_FIRST_KINDS, models)
    }

    /// Models with one effect, unless there are some, and with more while the data demand it; best first. `improved` is
    /// the model on which the best one with several effects improved.
    fn add_effects(
        &self,
        base: &FittedModel,
        improved: &FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<(), InferError> {
        if models.iter().all(|t| t.added.is_empty()) {
            self.add_single_effects(base, models)?;
        }
        self.backfit_shapes(models)?;
        self.fit_simpler_laws(models)?;
        self.fit_refinements(models)?;
        let (mut before, mut without_gain) = (improved.clone(), 0);
        for size in models[0].added.len()..MAX_EFFECTS {
            let best = models[0].clone();
            if best.added.is_empty()
                || !self.is_inadequate(&best)?
                || !self.engine.errs_beyond_noise(&best)?
            {
                break;
            }
            without_gain = if self.is_material_gain(&before, &best)? { 0 } else { without_gain + 1 };
            if without_gain > self.look_ahead(&best)? {
                break;
            }
            if size == 1 {
                self.fit_effect_sets(base, models)?;
            }
            self.add_one_effect(size, models)?;
            if !have_same_effects(&models[0].added, &best.added) {
                self.revise(models)?;
            }
            before = best;
        }
        Ok(())
    }

    /// Successive effects without a material gain after which a further one is still sought. There are none where the
    /// misfit is large or a random-walk wrench softens it: most fits stop far from their optimum, and the walk of the
    /// next round is smaller.
    fn look_ahead(&self, best: &FittedModel) -> Result<usize, InferError> {
        let is_large = self.is_softened || self.engine.softened(best)?.is_some();
        Ok(if is_large { 0 } else { LOOK_AHEAD })
    }

    /// Search the shapes of the best model's effects again, exchange the effects for others, and try refined laws.
    fn revise(&self, models: &mut Vec<FittedModel>) -> Result<(), InferError> {
        self.backfit_shapes(models)?;
        self.exchange_effects(models)?;
        self.backfit_shapes(models)?;
        self.fit_refinements(models)
    }

    /// Fit the simpler models with which the best one of several effects is compared before it is named.
    fn simplify(&self, models: &mut Vec<FittedModel>) -> Result<(), InferError> {
        let best = models[0].added.clone();
        if best.len() < 2 {
            return Ok(());
        }
        self.fit_simpler_laws(models)?;
        self.drop_each_effect(models)?;
        if !have_same_effects(&models[0].added, &best) {
            self.fit_refinements(models)?;
        }
        self.fit_subsets(models)
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

    /// The most promising fits of one more effect, of which at most `most` kinds will be ranked, and `per_ranked_kind`
    /// times as many fitted to thinned data.
    fn jobs(
        &self,
        from: &FittedModel,
        offered: &[Kind],
        most: usize,
        per_ranked_kind: usize,
    ) -> Result<Vec<Job>, InferError> {
        let Some(found) =
            self.engine.starts(from, offered, &self.screen_options(self.regions, most), self.watch)?
        else {
            return Ok(offered.iter().map(|&kind| self.unscreened(from, kind)).collect());
        };
        let is_promising = |(rank, starts): &(usize, &Vec<Start>)| {
            *rank < ALWAYS_FITTED_KINDS || starts[0].gain > MIN_SCREEN_GAIN_NATS
        };
        let screened = if self.engine.thinned().is_some() { per_ranked_kind * most } else { most };
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

    /// Add one more effect to the best models with `size` effects, once their shapes were searched again.
    fn add_one_effect(&self, size: usize, models: &mut Vec<FittedModel>) -> Result<(), InferError> {
        let best = |models: &[FittedModel]| -> Vec<FittedModel> {
            models.iter().filter(|t| t.added.len() == size).take(MAX_PARENT_MODELS).cloned().collect()
        };
        for parent in best(models) {
            self.backfit_shapes_of(&kinds(&parent.added), models)?;
        }
        let mut parents = best(models);
        let simpler = |t: &FittedModel| simpler_sets(&t.added).find_map(|kinds| with_kinds(models, kinds));
        let with_simpler: Vec<FittedModel> = parents.iter().filter_map(simpler).cloned().collect();
        parents.extend(with_simpler);
        let mut jobs = Vec::new();
        for first in &parents {
            jobs.extend(self.jobs(
                first,
                &self.offered(first),
                MAX_FURTHER_KINDS,
                SCREENED_PER_RANKED_KIND,
            )?);
        }
        let mut seen = BTreeSet::new();
        jobs.retain(|job| seen.insert(kinds(&job.added)));
        self.fit_new("several effects", jobs, MAX_FURTHER_KINDS * parents.len(), models)
    }

    /// Whether the lack of fit under the instruments' noise is larger than that of a law with a slightly
    /// wrong shape, or the prediction errors are material. Fitted noise would absorb unmodelled effects.
    fn is_inadequate(&self, fitted: &FittedModel) -> Result<bool, InferError> {
        let observations = self.engine.observations() as f64;
        let Some(lack) = self.engine.lack_of_fit(&self.with_instrument_noise(fitted))? else {
            return Ok(true);
        };
        Ok(lack.gain > MIN_LACK_OF_FIT_PER_SAMPLE_NATS * observations
            || !self.is_softened && self.engine.predictive_check(fitted)?.is_material())
    }

    /// Whether the effects of `best` improve on the smaller model `before` so much that a further effect is likely.
    ///
    /// The last effect must have gained its [`fair_share`] of the previous lack of fit. If the remaining lack of fit
    /// is not significant, it must have improved the predictions by a material share.
    pub(super) fn is_material_gain(
        &self,
        before: &FittedModel,
        best: &FittedModel,
    ) -> Result<bool, InferError> {
        if before.added.is_empty() {
            return Ok(true);
        }
        let [previous, current] = [before, best].map(|fitted| self.engine.lack_of_fit(fitted));
        let (Some(previous), Some(current)) = (previous?, current?) else { return Ok(true) };
        if current.is_significant(self.engine.observations()) {
            return Ok(before.fit.cost - best.fit.cost >= fair_share(before.added.len()) * previous.misfit());
        }
        let [previous, current] = [before, best].map(|fitted| self.engine.predictive_check(fitted));
        Ok(current?.share * MIN_MATERIAL_ERROR_RATIO < previous?.share)
    }
}

/// Share of a model's lack of fit that the next effect must gain for a further one to be likely, where
/// `effects` is the number of effects in the model. If the effects that may still be added explain
/// everything, the largest explains at least an equal share. An effect that gains less only compensates for
/// physics outside the catalogue, unless two effects gain more together than the sum of what each gains alone.
fn fair_share(effects: usize) -> f64 {
    1.0 / MAX_EFFECTS.saturating_sub(effects).max(1) as f64
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{LOOK_AHEAD, MAX_EFFECTS, Searcher, fair_share, kinds};
    use crate::engine::Engine;
    use crate::engine::plant_engine::PlantEngine;
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::Quiet;
    use trundle_model::{Kind, State};

    #[test]
    fn more_kinds_are_fitted_to_thinned_data_than_ranked() {
        let slope = effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]);
        let data = World::of(locked().with(slope)).recording(3);
        let engine = PlantEngine::new(&data, None).unwrap();
        let base = engine.base(0, &Quiet).unwrap();
        let searcher = Searcher::new(&engine, &[], 0, &Quiet);
        let jobs = searcher.jobs(&base, &searcher.offered(&base), 4, 2).unwrap();
        assert_eq!(jobs.len(), 8);
        let mut models = vec![base];
        searcher.fit_new("single effects", jobs, 4, &mut models).unwrap();
        assert_eq!(models.len(), 1 + 4);
        assert_eq!(kinds(&models[0].added), [Kind::FloorSlope]);
    }

    #[test]
    fn no_further_effect_is_sought_in_vain_where_the_misfit_is_large() {
        let force = |state: &State<f64>| [40.0 * (9.0 * state.pose[0]).sin(), 0.0, 0.0];
        let look_ahead = |world: &World, is_softened: bool| {
            let data = world.recording(3);
            let engine = PlantEngine::new(&data, None).unwrap();
            let base = engine.base(0, &Quiet).unwrap();
            let searcher = Searcher { is_softened, ..Searcher::new(&engine, &[], 0, &Quiet) };
            searcher.look_ahead(&base).unwrap()
        };
        let known = World::of(locked());
        assert_eq!([false, true].map(|softened| look_ahead(&known, softened)), [LOOK_AHEAD, 0]);
        assert_eq!(look_ahead(&World { out_of_catalogue: force, ..known }, false), 0);
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

    #[test]
    fn a_model_that_leaves_too_much_is_not_simplified() {
        let force = |state: &State<f64>| {
            let beat = (9.0 * state.pose[0]).sin() * (7.0 * state.pose[1]).cos();
            [12.0 * beat, 0.0, 5.0 * beat]
        };
        let slope = effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]);
        let search = |world: &World| {
            let data = world.recording(5);
            let engine = PlantEngine::new(&data, None).unwrap();
            let searcher = Searcher::new(&engine, &[], 0, &Quiet);
            searcher.run().unwrap()
        };
        let unknown = search(&World { out_of_catalogue: force, ..World::of(locked()) });
        assert!(!unknown.models[0].added.is_empty() && unknown.has_large_residual);
        let known = search(&World::of(locked().with(slope)));
        assert_eq!(kinds(&known.models[0].added), [Kind::FloorSlope]);
        assert!(!known.has_large_residual);
    }
}
