//! Pushes that would tell two models of a foreign simulator with laws apart.
//!
//! Hundreds of pushes are compared for one that is proposed, each with derivatives: too many calls of somebody's simulator. So
//! trundle's own plant, fitted to the same recording with the same laws, stands in while pushes are compared. That is only to
//! say which push is worth a look; what it is worth the simulator itself says. It simulates the push with the laws of either
//! model, and along that motion it is linearised to see how much the other model could absorb. A push that tells nothing there
//! is not proposed.

use super::black_box::{BlackBox, on_object, plant};
use super::likelihood::Along;
use super::path::Path;
use crate::design::{Bench, Experiment, Limits, Moves, Rival, certified, experiment, unabsorbed};
use crate::engine::{Effort, Engine, FittedModel, Job, Own};
use trundle_infer::{Channels, InferError, Watch};
use trundle_record::{Noise, Prepared};

impl BlackBox<'_> {
    /// The push that tells two models apart by the simulator itself; `None` where none was found.
    pub(super) fn designed(
        &self,
        names: [&str; 2],
        models: [&FittedModel; 2],
        channels: &Channels,
        watch: &dyn Watch,
    ) -> Result<Option<Experiment>, InferError> {
        let bench = Bench::after(self.data, channels, Limits::seen(self.data)).hurried();
        let Some(rivals) = self.surrogates(names, models, watch)? else { return Ok(None) };
        let planned = experiment(&bench, &rivals[0], &rivals[1], 1, watch)?;
        let moves = models.map(|tried| move |episode: &Prepared| self.imagined(tried, episode));
        let moves: [&Moves<'_>; 2] = [&moves[0], &moves[1]];
        let noise = &bench.instruments.noise;
        let apart = |[first, second]: &[Prepared; 2]| {
            Ok([self.apart(models, first, noise)?, self.apart([models[1], models[0]], second, noise)?])
        };
        let recorded = models[1].fit.cost - models[0].fit.cost;
        certified(&planned, &bench, moves, apart, recorded).map(Some)
    }

    /// Trundle's own plant with the laws of two models, fitted to the recording; `None` where it cannot be.
    fn surrogates(
        &self,
        names: [&str; 2],
        models: [&FittedModel; 2],
        watch: &dyn Watch,
    ) -> Result<Option<[Rival; 2]>, InferError> {
        let own = Own::new(self.data, None)?;
        if own.is_quasi_static() {
            return Ok(None);
        }
        let base = own.base(self.seed, watch)?;
        let one = |tried: &FittedModel| {
            let effects = tried.fit.model.effects.iter();
            let values = effects.flat_map(|effect| effect.values.iter().map(|value| value.unwrap_or(0.0)));
            let start = base.fit.values.iter().copied().chain(values).collect();
            own.fit(Job::from(&base, tried.added.clone(), vec![start]), Effort::Full, self.seed, watch)
        };
        let fits = [one(models[0]), one(models[1])];
        if fits.iter().any(|fit| matches!(fit, Err(InferError::NoStart { .. }))) {
            return Ok(None);
        }
        let [first, second] = fits;
        Ok(Some([Rival::fitted(names[0], &first?.fit), Rival::fitted(names[1], &second?.fit)]))
    }

    /// Poses of an episode that nobody has seen.
    fn imagined(&self, tried: &FittedModel, episode: &Prepared) -> Result<Vec<[f64; 3]>, InferError> {
        let values = self.own(tried);
        let rollout = self.rollout(tried, &values)?;
        rollout.open_loop(&rollout.unseen(episode))
    }

    /// What the second of two models leaves of an episode of the first after a refit, more than the first itself, nats.
    fn apart(&self, models: [&FittedModel; 2], episode: &Prepared, noise: &Noise) -> Result<f64, InferError> {
        let path = Path::new(episode, noise)?;
        let left = |tried: &FittedModel| -> Result<f64, InferError> {
            let (own, plant) = (self.own(tried), plant(tried)?);
            let (channels, paths) = (Channels::of(noise), std::slice::from_ref(&path));
            let mut along = Along::new(self.foreign, &own, paths, channels, self.data.dof, self.watch)?;
            if on_object(&tried.fit.model) {
                along = along.doubting(&plant, &own);
            }
            let misfit = 0.5 * along.innovations(&plant, &own).iter().map(|e| e * e).sum::<f64>();
            Ok(unabsorbed(&along, &self.free_model(tried), &tried.fit, misfit)?.unwrap_or(0.0))
        };
        let [truth, other] = models;
        Ok((left(other)? - left(truth)?).max(0.0))
    }
}
