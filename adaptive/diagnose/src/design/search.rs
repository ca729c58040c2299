//! Search for the best push: a coarse grid, then repeated searches among the neighbours of the best push.

use super::competing_model::CompetingModel;
use super::library::{coarse_grid, neighbours};
use super::push::Push;
use super::separation::{QuadraticMisfit, refit};
use super::setup::{Instruments, Setup};
use super::synthetic::{RANKING_RATE_HZ, scaled_to_limits, simulate_push};
use rayon::prelude::*;
use trundle_infer::{InferError, Watch, open_loop};
use trundle_model::Plant;
use trundle_record::Prepared;

/// Shares of the maximum duration, tried until a push respects all limits.
const DURATION_SHARES: [f64; 3] = [1.0, 0.5, 0.25];
/// Minimum relative gain of utility for a neighbour to replace the best push.
const MIN_RELATIVE_GAIN: f64 = 0.02;
/// Separation below which a push is not informative, nats.
pub(super) const MIN_SEPARATION_NATS: f64 = 0.05;
/// Separation beyond which further separation has diminishing utility, nats: about what a reliable choice needs.
const SEPARATION_SCALE_NATS: f64 = 10.0;

/// Expected misfit of each model to a set of pushes if the other model is true.
#[derive(Clone, Debug)]
pub(super) struct MutualMisfit([QuadraticMisfit; 2]);

impl MutualMisfit {
    /// The misfits without any push.
    pub fn none(models: &[&CompetingModel; 2]) -> Self {
        Self([QuadraticMisfit::none(models[1]), QuadraticMisfit::none(models[0])])
    }

    fn plus(&self, other: &Self) -> Self {
        Self([self.0[0].plus(&other.0[0]), self.0[1].plus(&other.0[1])])
    }

    /// The separations if the first model is true and if the second is, nats.
    fn separations(&self, models: &[&CompetingModel; 2]) -> [f64; 2] {
        [self.0[0].separation(models[1]), self.0[1].separation(models[0])]
    }

    /// Mean of the two separations, nats.
    pub fn separation(&self, models: &[&CompetingModel; 2]) -> f64 {
        self.separations(models).iter().sum::<f64>() / 2.0
    }

    /// Utility of a set of pushes. Both separations count, since either model may be true.
    fn utility(&self, models: &[&CompetingModel; 2]) -> f64 {
        self.separations(models).iter().map(|separation| (separation / SEPARATION_SCALE_NATS).ln_1p()).sum()
    }
}

/// An evaluated push.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    pub push: Push,
    /// Separation by this push alone, nats.
    pub separation: f64,
    /// Additional utility over the previous pushes, weighted by simplicity.
    utility: f64,
    /// Separation together with the previous pushes, nats.
    pub cumulative: f64,
    pub misfit: MutualMisfit,
}

/// Search for pushes that discriminate between two models.
pub(super) struct PushSearch<'a> {
    setup: &'a Setup,
    models: [&'a CompetingModel; 2],
    plants: [Plant<f64>; 2],
    ranking: Instruments,
    watch: &'a dyn Watch,
}

impl<'a> PushSearch<'a> {
    pub fn new(
        setup: &'a Setup,
        models: [&'a CompetingModel; 2],
        watch: &'a dyn Watch,
    ) -> Result<Self, InferError> {
        let plants = [models[0].plant()?, models[1].plant()?];
        Ok(Self { setup, models, plants, ranking: setup.instruments.thinned(RANKING_RATE_HZ), watch })
    }

    /// The push that adds most to the previous pushes; `None` if no push is informative.
    pub fn best(&self, before: &MutualMisfit, ordinal: usize) -> Result<Option<Trial>, InferError> {
        let mut best = None;
        // An object that moves without a push may leave the workspace during a long push of any strength.
        for share in DURATION_SHARES {
            let shortened = |push: Push| Push { duration: share * push.duration, ..push };
            let pushes: Vec<Push> = coarse_grid(self.setup).into_iter().map(shortened).collect();
            best = self.best_of(best, &pushes, before, ordinal)?;
            if best.is_some() {
                break;
            }
        }
        for fine in [false, true] {
            for _ in 0..self.setup.max_search_rounds {
                let Some(current) = &best else { return Ok(None) };
                let near = neighbours(self.setup, &current.push, fine);
                let previous = current.utility;
                best = self.best_of(best, &near, before, ordinal)?;
                if best.as_ref().is_none_or(|b| b.utility == previous) {
                    break;
                }
            }
        }
        Ok(best.filter(|b| b.cumulative - before.separation(&self.models) > MIN_SEPARATION_NATS))
    }

    /// The best of `best` and some further pushes.
    fn best_of(
        &self,
        best: Option<Trial>,
        pushes: &[Push],
        before: &MutualMisfit,
        ordinal: usize,
    ) -> Result<Option<Trial>, InferError> {
        if self.watch.cancelled() {
            return Err(InferError::Interrupted);
        }
        let trials: Vec<Option<Trial>> =
            pushes.par_iter().map(|push| self.evaluate(push, before, ordinal)).collect::<Result<_, _>>()?;
        let best_so_far = |best: Option<Trial>, next: Trial| match best {
            Some(best) if next.utility <= (1.0 + MIN_RELATIVE_GAIN) * best.utility => Some(best),
            _ => Some(next),
        };
        Ok(trials.into_iter().flatten().fold(best, best_so_far))
    }

    fn evaluate(
        &self,
        push: &Push,
        before: &MutualMisfit,
        ordinal: usize,
    ) -> Result<Option<Trial>, InferError> {
        let [first, second] = &self.plants;
        let predictors = [first, second].map(|plant| |episode: &Prepared| Ok(open_loop(plant, episode)));
        let Some(push) = scaled_to_limits(&[&predictors[0], &predictors[1]], push, self.setup)? else {
            return Ok(None);
        };
        let errors = |truth: &Plant<f64>, other: &CompetingModel| {
            let episode = simulate_push(truth, &push, &self.ranking, ordinal);
            QuadraticMisfit::evaluate(other, other.point(), &[episode], &self.ranking.noise)
        };
        let (Some(of_second), Some(of_first)) =
            (errors(first, self.models[1])?, errors(second, self.models[0])?)
        else {
            return Ok(None);
        };
        let own = MutualMisfit([of_second, of_first]);
        let misfit = before.plus(&own);
        let (separation, cumulative) = (own.separation(&self.models), misfit.separation(&self.models));
        let gain = misfit.utility(&self.models) - before.utility(&self.models);
        let utility = push.simplicity(self.setup.start_pose[2]) * gain;
        Ok(utility.is_finite().then_some(Trial { push, separation, utility, cumulative, misfit }))
    }

    /// Separations of some pushes with a nonlinear refit of the other model: if the first model is true, and if the
    /// second is.
    pub fn separations_after_refit(&self, pushes: &[Push]) -> Result<[f64; 2], InferError> {
        let of = |truth: usize| {
            let one = |(k, push): (usize, &Push)| {
                simulate_push(
                    &self.plants[truth],
                    push,
                    &self.setup.instruments,
                    self.setup.recorded_episodes + k,
                )
            };
            let episodes: Vec<Prepared> = pushes.iter().enumerate().map(one).collect();
            refit(self.models[1 - truth], &episodes, &self.setup.instruments)
        };
        Ok([of(0)?, of(1)?])
    }
}
