//! Interface between a diagnosis and a simulation: trundle's own plant ([`PlantEngine`]) or a black-box simulator
//! ([`crate::black_box`]). Search, decision and answer use no other property of the simulation.

pub(crate) mod plant_engine;

use crate::answer::Channels;
use crate::best_subset::{EffectSet, best_sets};
use crate::block_bootstrap::PredictedSamples;
use crate::contact_candidates::contact_candidates;
use crate::design::{Certificate, Experiment};
use crate::fitted_model::{Effort, FittedModel, Job};
use crate::lack_of_fit::LackOfFit;
use crate::linearisation::{Linearisation, Start};
use crate::locate::Located;
use crate::missing_wrenches::{MissingWrenches, Wrench};
use crate::parameter::Parameter;
use crate::periods::in_position;
use crate::predictive_check::PredictiveCheck;
use crate::proposals::Hints;
use crate::ridge_candidates::ridge_candidates;
use crate::screen::{Screen, ScreenOptions};
use std::collections::BTreeMap;
use trundle_infer::{InferError, Likelihood, Residual, Score, Watch, on_all_cores};
use trundle_model::{Kind, Model, Proposal};
use trundle_record::{Dataset, Prepared};

/// A callback that receives a linearised model and the missing wrench along the episodes.
pub(crate) type Inspector<'l> =
    dyn FnMut(&dyn Linearisation, &[Vec<Residual>]) -> Result<(), InferError> + 'l;

/// A simulation, and its comparison with the training episodes of a recording.
pub(crate) trait Engine: Sync {
    /// The recording.
    fn data(&self) -> &Dataset;

    /// The nominal model, to which effects are added.
    fn nominal(&self) -> &Model;

    /// Whether wrenches are compared instead of motion, because inertia is negligible.
    fn is_quasi_static(&self) -> bool;

    /// Number of samples that are compared.
    fn observations(&self) -> usize;

    /// Kinds of effects that may be missing.
    fn candidates(&self) -> Vec<Kind>;

    /// The nominal model, refitted.
    fn base(&self, seed: u64, watch: &dyn Watch) -> Result<FittedModel, InferError>;

    /// The nominal model with parameters to which unexplained physics contributes less, if it predicts the training
    /// episodes better than `base`.
    fn undistorted(
        &self,
        base: &FittedModel,
        seed: u64,
        watch: &dyn Watch,
    ) -> Result<Option<FittedModel>, InferError> {
        let _ = (base, seed, watch);
        Ok(None)
    }

    /// The engine for effects that are added to the refitted nominal model.
    fn for_added_effects<'a>(
        &'a self,
        base: &FittedModel,
        before: Option<LackOfFit>,
        watch: &dyn Watch,
    ) -> Result<Box<dyn Engine + 'a>, InferError>;

    /// A cheaper engine for screening fits; `None` if there is none.
    fn thinned<'a>(&'a self) -> Option<Box<dyn Engine + 'a>>;

    /// The engine with a random-walk wrench in every model, the smallest with which the misfit of `fitted` is moderate; `None`
    /// if the misfit is moderate without it, or if there is no such engine.
    fn softened<'a>(&'a self, fitted: &FittedModel) -> Result<Option<Box<dyn Engine + 'a>>, InferError> {
        let _ = fitted;
        Ok(None)
    }

    /// Call `at` with a linearised model, and with the missing wrench if any of `kinds` is proposed from it.
    /// `at` is not called for a model that cannot be evaluated. Returns `false` if kinds cannot be screened.
    fn inspect(&self, from: &FittedModel, kinds: &[Kind], at: &mut Inspector<'_>)
    -> Result<bool, InferError>;

    /// Starting points of a kind in addition to those of the score test.
    fn extra_starts(&self, kind: Kind, from: &FittedModel, seed: u64) -> Vec<Start> {
        let _ = (kind, from, seed);
        vec![]
    }

    /// Starting points of every promising kind that may be added to a model, the best first; `None` if kinds
    /// cannot be screened.
    fn starts(
        &self,
        from: &FittedModel,
        kinds: &[Kind],
        options: &ScreenOptions<'_>,
        watch: &dyn Watch,
    ) -> Result<Option<Vec<Vec<Start>>>, InferError> {
        on_all_cores(watch, |watch| {
            let mut found = vec![];
            let screens = self.inspect(from, kinds, &mut |view, courses| {
                let contacts = contact_candidates(courses, &from.fit.model.body);
                let lines = in_position(courses, self.nominal().on_rail());
                let is_ridge = |kind: &Kind| kind.proposal() == Proposal::Ridge;
                let ridges = match kinds.iter().any(is_ridge) {
                    true => ridge_candidates(courses, &from.fit.model.body),
                    false => vec![],
                };
                let hints =
                    Hints { contacts: &contacts, regions: options.regions, ridges: &ridges, lines: &lines };
                let screen = Screen { view, episodes: &self.data().training, hints: &hints, options };
                found = screen.of(&from.fit, kinds, watch)?;
                Ok(())
            })?;
            for starts in &mut found {
                starts.extend(self.extra_starts(starts[0].effect.kind, from, options.seed));
            }
            Ok(screens.then_some(found))
        })
    }

    /// The most promising sets of two to `most` kinds that may be added to a model; empty if sets cannot be
    /// screened.
    fn sets(
        &self,
        from: &FittedModel,
        kinds: &[Kind],
        options: &ScreenOptions<'_>,
        most: usize,
        watch: &dyn Watch,
    ) -> Result<Vec<EffectSet>, InferError> {
        let Some(starts) = self.starts(from, kinds, options, watch)? else { return Ok(vec![]) };
        on_all_cores(watch, |_| {
            let mut found = vec![];
            self.inspect(from, &[], &mut |view, _| {
                found = best_sets(view, &from.fit, &starts, most)?;
                Ok(())
            })?;
            Ok(found)
        })
    }

    /// Fit a model with effects.
    fn fit(&self, job: Job, effort: Effort, seed: u64, watch: &dyn Watch) -> Result<FittedModel, InferError>;

    /// The model refitted in a few steps to the training episodes that `keep` selects. `model` may have
    /// parameters of its effects fixed.
    fn refitted(
        &self,
        fitted: &FittedModel,
        model: &Model,
        keep: &dyn Fn(usize) -> bool,
        watch: &dyn Watch,
    ) -> Result<FittedModel, InferError>;

    /// The model with the given values; `None` if none are given.
    fn given(&self, watch: &dyn Watch) -> Result<Option<FittedModel>, InferError>;

    /// The given values by name, including those that are fixed for every simulation of this kind.
    fn given_values(&self, given: Option<&FittedModel>) -> BTreeMap<String, f64>;

    /// The lack-of-fit test of a model; `None` if wrenches are compared.
    fn lack_of_fit(&self, fitted: &FittedModel) -> Result<Option<LackOfFit>, InferError>;

    /// A model's prediction of each sample of the training episodes that `keep` selects.
    fn predicted(
        &self,
        fitted: &FittedModel,
        keep: &dyn Fn(usize) -> bool,
    ) -> Result<PredictedSamples, InferError>;

    /// Where a model disagrees with the recording.
    fn located(&self, fitted: &FittedModel, lack: Option<LackOfFit>) -> Result<Located, InferError>;

    /// Shares of the standardised misfit by direction.
    fn channels(&self, fitted: &FittedModel) -> Result<Channels, InferError>;

    /// The predictive check one second ahead.
    fn predictive_check(&self, fitted: &FittedModel) -> Result<PredictiveCheck, InferError>;

    /// Whether a model's errors exceed the instruments' noise, so that a further effect could improve its
    /// predictions. Slow pushes are judged by the wrench alone.
    fn errs_beyond_noise(&self, fitted: &FittedModel) -> Result<bool, InferError> {
        Ok(self.is_quasi_static() || self.predictive_check(fitted)?.is_beyond_noise())
    }

    /// Error metrics on some episodes. Samples that are not scored for `compared_with` are excluded here too.
    fn score(
        &self,
        fitted: &FittedModel,
        compared_with: &FittedModel,
        episodes: &[Prepared],
    ) -> Result<Score, InferError>;

    /// Simulated poses of an episode, one for each recorded pose; `None` if inertia is negligible.
    fn open_loop(
        &self,
        fitted: &FittedModel,
        episode: &Prepared,
    ) -> Result<Option<Vec<[f64; 3]>>, InferError>;

    /// The missing wrench along every episode.
    fn missing_wrenches(
        &self,
        fitted: &FittedModel,
        lack: Option<LackOfFit>,
    ) -> Result<MissingWrenches, InferError>;

    /// The unsmoothed missing wrench along every training episode; empty if inertia is negligible.
    fn unsmoothed(&self, fitted: &FittedModel) -> Result<Vec<Vec<Residual>>, InferError> {
        let _ = fitted;
        Ok(vec![])
    }

    /// The wrenches that two models need in an episode, if wrenches are compared.
    fn wrenches(&self, episode: &Prepared, models: [&FittedModel; 2]) -> Result<Option<Wrench>, InferError>;

    /// Residual wrenches of the training episodes, if wrenches are compared.
    fn residual_wrenches(&self, fitted: &FittedModel) -> Result<Option<Vec<[f64; 3]>>, InferError>;

    /// Certificate of how well the recording distinguishes two models.
    fn certificate(&self, names: [&str; 2], models: [&FittedModel; 2]) -> Result<Certificate, InferError>;

    /// A discriminating experiment for two models; `None` if none can be designed.
    fn experiment(
        &self,
        names: [&str; 2],
        models: [&FittedModel; 2],
        noise: &trundle_infer::Channels,
        watch: &dyn Watch,
    ) -> Result<Option<Experiment>, InferError>;

    /// The nominal model with a model discrepancy; `None` if none predicts better.
    fn discrepancy(
        &self,
        base: &FittedModel,
        lack: Option<LackOfFit>,
        watch: &dyn Watch,
    ) -> Result<Option<FittedModel>, InferError>;

    /// A fitted model with its parameters free.
    fn free_model(&self, fitted: &FittedModel) -> Model {
        let mut model = self.nominal().clone();
        model.mass = model.mass.and(fitted.fit.model.mass);
        model.effects.extend(fitted.added.iter().cloned());
        model
    }

    /// The likelihood of a fit.
    fn likelihood(&self, fitted: &FittedModel) -> Result<Box<dyn Likelihood + '_>, InferError>;

    /// The same model with standard deviations that include model error, from the variation between episodes
    /// if there are enough of them.
    fn widened(&self, fitted: &FittedModel) -> Result<FittedModel, InferError> {
        let found = fitted.fit.sandwiched(&self.free_model(fitted), &[&*self.likelihood(fitted)?])?;
        Ok(found.map_or_else(
            || fitted.clone(),
            |(fit, basis)| FittedModel { fit: fit.as_normal(basis), ..fitted.clone() },
        ))
    }

    /// Parameters of the nominal model within a fit.
    fn parameters(&self, fitted: &FittedModel) -> BTreeMap<String, Parameter>;

    /// `model.toml`.
    fn model_toml(&self, fitted: &FittedModel) -> Result<String, InferError>;
}
