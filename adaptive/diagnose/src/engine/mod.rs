//! What a diagnosis asks of a simulation, whether it is trundle's own plant ([`Own`]) or anyone's function
//! ([`crate::black_box`]). Search, decision and answer know nothing else of what simulates.

mod own;

use crate::adequacy::Remainder;
use crate::answer::{Channels, Parameter};
use crate::black_box::Basis;
use crate::confirm::Samples;
use crate::design::{Certificate, Experiment};
use crate::locate::Located;
use crate::outlook::Outlook;
use crate::periods::in_position;
use crate::proposals::Hints;
use crate::screen::{Screen, Start, View, Wanted};
use crate::series::{Missing, Wrench};
use crate::subset::{Set, best_sets};
use crate::touch::touches;
use std::collections::BTreeMap;
use trundle_infer::{Fit, InferError, Likelihood, Residual, Score, Watch, on_all_cores};
use trundle_model::{Effect, Kind, Model, Proposal};
use trundle_record::{Dataset, Prepared};

pub(crate) use own::Own;

/// A model that was tried: the simulation under test with some effects added.
#[derive(Clone)]
pub(crate) struct Tried {
    pub added: Vec<Effect>,
    pub fit: Fit,
    /// What a black box was replaced by for this fit; `None` for trundle's own plant.
    pub basis: Option<Basis>,
    /// Log prior probability of its effects, less that of none.
    pub log_prior: f64,
    /// Whether its effects' places were sought again, all else as it is here, and no better ones found.
    pub settled: bool,
}

impl Tried {
    /// A model that was just fitted; the search knows the prior of effects.
    pub fn new(added: Vec<Effect>, fit: Fit, basis: Option<Basis>) -> Self {
        Self { added, fit, basis, log_prior: 0.0, settled: false }
    }
}

/// A fit that is to be made: effects to add, and values of all slots to start from.
#[derive(Clone)]
pub(crate) struct Job {
    pub added: Vec<Effect>,
    pub warm: Vec<Vec<f64>>,
    /// Cost of the model that it goes out from.
    pub from: f64,
    /// The noise that suits that model.
    pub channels: trundle_infer::Channels,
    /// Of that model.
    pub basis: Option<Basis>,
}

impl Job {
    /// A fit that goes out from a model.
    pub fn from(model: &Tried, added: Vec<Effect>, warm: Vec<Vec<f64>>) -> Self {
        let (fit, basis) = (&model.fit, model.basis.clone());
        Self { added, warm, from: fit.cost, channels: fit.channels, basis }
    }
}

/// Steps of a search that ends, and of a refit: it starts a fraction of a standard deviation from its optimum.
pub(crate) const TO_THE_END: usize = 60;
pub(crate) const REFIT_STEPS: usize = 6;

/// How far a fit is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effort {
    /// A few steps: enough to see what leads nowhere.
    Glance,
    /// A step or two more: enough to rank models.
    Look,
    /// To its optimum.
    Full,
}

impl Effort {
    /// Steps at most.
    pub fn steps(self) -> usize {
        match self {
            Self::Glance => 8,
            Self::Look => 2,
            Self::Full => TO_THE_END,
        }
    }

    /// How often noise that is not stated is estimated at most. What is missing passes for noise: a law that acts for a
    /// moment shows its worth only once the noise is estimated anew.
    pub fn noise_rounds(self) -> usize {
        if self == Self::Full { 2 } else { 1 }
    }
}

/// A function that inspects a fitted model and the missing wrench along the episodes.
pub(crate) type Look<'l> = dyn FnMut(&dyn View, &[Vec<Residual>]) -> Result<(), InferError> + 'l;

/// Whether kinds are proposed from the missing wrench along the episodes.
pub(crate) fn needs_courses(kinds: &[Kind]) -> bool {
    kinds.iter().any(|kind| matches!(kind.proposal(), Proposal::Touched | Proposal::Period))
}

/// A simulation, and how it is compared with a recording's training episodes.
pub(crate) trait Engine: Sync {
    /// The recording.
    fn data(&self) -> &Dataset;

    /// The simulation under test as a model, to which effects are added.
    fn nominal(&self) -> &Model;

    /// Whether the wrench is compared, because inertia plays no part.
    fn is_quasi_static(&self) -> bool;

    /// Number of samples compared.
    fn observations(&self) -> usize;

    /// Kinds of effects that the simulation under test may lack.
    fn candidates(&self) -> Vec<Kind>;

    /// The simulation under test, refitted.
    fn base(&self, seed: u64, watch: &dyn Watch) -> Result<Tried, InferError>;

    /// The same engine for effects on top of the refitted simulation.
    fn upon<'a>(
        &'a self,
        base: &Tried,
        before: Option<Remainder>,
        watch: &dyn Watch,
    ) -> Result<Box<dyn Engine + 'a>, InferError>;

    /// A cheaper engine for a first glance; `None` where there is none.
    fn thinned<'a>(&'a self) -> Option<Box<dyn Engine + 'a>>;

    /// Pass a fitted model to `at` as the score test sees it, with the missing wrench where `kinds` are proposed from it.
    /// `at` is not called for a model that cannot be evaluated. `false` where kinds cannot be screened.
    fn look(&self, from: &Tried, kinds: &[Kind], at: &mut Look<'_>) -> Result<bool, InferError>;

    /// Further starts of a kind on top of a model, in addition to those of the score test.
    fn elsewhere(&self, kind: Kind, from: &Tried, seed: u64) -> Vec<Start> {
        let _ = (kind, from, seed);
        vec![]
    }

    /// Starts of every kind that promises something on top of a model, the best first; `None` where kinds cannot be
    /// screened.
    fn starts(
        &self,
        from: &Tried,
        kinds: &[Kind],
        wanted: &Wanted<'_>,
        watch: &dyn Watch,
    ) -> Result<Option<Vec<Vec<Start>>>, InferError> {
        on_all_cores(watch, |watch| {
            let mut found = vec![];
            let screens = self.look(from, kinds, &mut |view, courses| {
                let touched = touches(courses, &from.fit.model.body);
                let lines = in_position(courses, self.nominal().on_rail());
                let hints = Hints { touched: &touched, regions: wanted.regions, lines: &lines };
                let screen = Screen { view, episodes: &self.data().training, hints: &hints, wanted };
                found = screen.of(&from.fit, kinds, watch)?;
                Ok(())
            })?;
            for starts in &mut found {
                starts.extend(self.elsewhere(starts[0].effect.kind, from, wanted.seed));
            }
            Ok(screens.then_some(found))
        })
    }

    /// Sets of two kinds up to `most` that together promise most on top of a model; none where sets cannot be screened.
    fn sets(
        &self,
        from: &Tried,
        kinds: &[Kind],
        wanted: &Wanted<'_>,
        most: usize,
        watch: &dyn Watch,
    ) -> Result<Vec<Set>, InferError> {
        let Some(starts) = self.starts(from, kinds, wanted, watch)? else { return Ok(vec![]) };
        on_all_cores(watch, |_| {
            let mut found = vec![];
            self.look(from, &[], &mut |view, _| {
                found = best_sets(view, &from.fit, &starts, most)?;
                Ok(())
            })?;
            Ok(found)
        })
    }

    /// Fit a model with effects.
    fn fit(&self, job: Job, effort: Effort, seed: u64, watch: &dyn Watch) -> Result<Tried, InferError>;

    /// The model refitted, in a few steps, to the training episodes that are to be kept; `model` has its moments of
    /// events held.
    fn refitted(
        &self,
        tried: &Tried,
        model: &Model,
        keep: &dyn Fn(usize) -> bool,
        watch: &dyn Watch,
    ) -> Result<Tried, InferError>;

    /// The values with which the simulation is used, if such were given.
    fn given(&self, watch: &dyn Watch) -> Result<Option<Tried>, InferError>;

    /// Those values by name; with what every simulation of this kind has fixed.
    fn given_values(&self, given: Option<&Tried>) -> BTreeMap<String, f64>;

    /// What a wandering wrench would gain on top of a model; `None` where only wrenches are compared.
    fn remainder(&self, tried: &Tried) -> Result<Option<Remainder>, InferError>;

    /// How a model predicts each sample of the training episodes that are to be kept.
    fn predicted(&self, tried: &Tried, keep: &dyn Fn(usize) -> bool) -> Result<Samples, InferError>;

    /// Where a model leaves something.
    fn located(&self, tried: &Tried, left: Option<Remainder>) -> Result<Located, InferError>;

    /// Shares of the standardised misfit.
    fn channels(&self, tried: &Tried) -> Result<Channels, InferError>;

    /// Prediction errors one second ahead.
    fn outlook(&self, tried: &Tried) -> Result<Outlook, InferError>;

    /// Whether a model errs by more than the instruments explain, so that a further effect could improve its predictions.
    /// Slow pushes are judged by the wrench alone.
    fn errs(&self, tried: &Tried) -> Result<bool, InferError> {
        Ok(self.is_quasi_static() || self.outlook(tried)?.is_beyond_noise())
    }

    /// Figures on some episodes. What is not judged of the model `beside` is not judged of this one.
    fn score(&self, tried: &Tried, beside: &Tried, episodes: &[Prepared]) -> Result<Score, InferError>;

    /// Simulated poses of an episode, one for each recorded one; `None` where inertia plays no part.
    fn open_loop(&self, tried: &Tried, episode: &Prepared) -> Result<Option<Vec<[f64; 3]>>, InferError>;

    /// The missing wrench along every episode.
    fn missing(&self, tried: &Tried, left: Option<Remainder>) -> Result<Missing, InferError>;

    /// The missing wrench along every training episode, not smoothed; none where inertia plays no part.
    fn unsmoothed(&self, tried: &Tried) -> Result<Vec<Vec<Residual>>, InferError> {
        let _ = tried;
        Ok(vec![])
    }

    /// The wrenches that two models need in an episode, where wrenches are compared.
    fn wrenches(&self, episode: &Prepared, models: [&Tried; 2]) -> Result<Option<Wrench>, InferError>;

    /// Residual wrenches of the training episodes, where wrenches are compared.
    fn residual_wrenches(&self, tried: &Tried) -> Result<Option<Vec<[f64; 3]>>, InferError>;

    /// How alike two models are on what was recorded.
    fn certificate(&self, names: [&str; 2], models: [&Tried; 2]) -> Result<Certificate, InferError>;

    /// A push that would tell two models apart; `None` where none can be designed.
    fn experiment(
        &self,
        names: [&str; 2],
        models: [&Tried; 2],
        noise: &trundle_infer::Channels,
        watch: &dyn Watch,
    ) -> Result<Option<Experiment>, InferError>;

    /// The simulation under test with a wrench that no law names; `None` where none predicts.
    fn unnamed(
        &self,
        base: &Tried,
        left: Option<Remainder>,
        watch: &dyn Watch,
    ) -> Result<Option<Tried>, InferError>;

    /// A model as it was fitted, with its parameters free.
    fn free(&self, tried: &Tried) -> Model {
        let mut model = self.nominal().clone();
        model.mass = model.mass.and(tried.fit.model.mass);
        model.effects.extend(tried.added.iter().cloned());
        model
    }

    /// What a model was fitted with.
    fn likelihood(&self, tried: &Tried) -> Result<Box<dyn Likelihood + '_>, InferError>;

    /// The same model with standard deviations that include model error, from the spread between episodes where there are
    /// enough of them.
    fn widened(&self, tried: &Tried) -> Result<Tried, InferError> {
        let found = tried.fit.sandwiched(&self.free(tried), &[&*self.likelihood(tried)?])?;
        Ok(found.map_or_else(
            || tried.clone(),
            |(fit, basis)| Tried { fit: fit.as_normal(basis), ..tried.clone() },
        ))
    }

    /// Parameters of the simulation under test within a fit.
    fn parameters(&self, tried: &Tried) -> BTreeMap<String, Parameter>;

    /// `model.toml`.
    fn file(&self, tried: &Tried) -> Result<String, InferError>;
}
