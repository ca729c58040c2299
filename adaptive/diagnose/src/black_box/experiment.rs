//! Discriminating experiments for two models of a black-box simulator with laws.
//!
//! A search compares hundreds of pushes with their derivatives, which needs too many calls of the simulator. A
//! surrogate replaces it during the search: trundle's own plant with the same laws, fitted to the same recording.
//! The simulator then verifies the best push: it simulates the push with the laws of either model and is
//! linearised along that motion, which shows how much the other model could absorb. A push whose separation is
//! not confirmed is not proposed.

use super::engine::BlackBoxEngine;
use super::laws::{has_laws_on_object, plant};
use super::likelihood::PathLikelihood;
use super::path::Path;
use crate::design::{
    CompetingModel, Experiment, Limits, PosePredictor, Setup, experiment, misfit_after_refit, verify,
};
use crate::engine::Engine;
use crate::engine::plant_engine::PlantEngine;
use crate::fitted_model::{Effort, FittedModel, Job};
use trundle_infer::{Channels, InferError, Watch};
use trundle_record::{Noise, Prepared};

impl BlackBoxEngine<'_> {
    /// Returns the push that best separates two models according to the simulator; `None` if no surrogate can be
    /// fitted.
    pub(super) fn design_experiment(
        &self,
        names: [&str; 2],
        models: [&FittedModel; 2],
        channels: &Channels,
        watch: &dyn Watch,
    ) -> Result<Option<Experiment>, InferError> {
        let setup =
            Setup::from_recording(self.data, channels, Limits::from_recording(self.data)).with_short_search();
        let Some(surrogates) = self.surrogates(names, models, watch)? else { return Ok(None) };
        let planned = experiment(&setup, &surrogates[0], &surrogates[1], 1, watch)?;
        let predictors = models.map(|fitted| move |episode: &Prepared| self.simulated_poses(fitted, episode));
        let predictors: [&PosePredictor<'_>; 2] = [&predictors[0], &predictors[1]];
        let noise = &setup.instruments.noise;
        let separation = |[first, second]: &[Prepared; 2]| {
            Ok([
                self.separation(models, first, noise)?,
                self.separation([models[1], models[0]], second, noise)?,
            ])
        };
        let recorded = models[1].fit.cost - models[0].fit.cost;
        verify(&planned, &setup, predictors, separation, recorded).map(Some)
    }

    /// Trundle's own plant with the laws of two models, fitted to the recording; `None` if a fit has no valid start.
    fn surrogates(
        &self,
        names: [&str; 2],
        models: [&FittedModel; 2],
        watch: &dyn Watch,
    ) -> Result<Option<[CompetingModel; 2]>, InferError> {
        let plant = PlantEngine::new(self.data, None)?;
        if plant.is_quasi_static() {
            return Ok(None);
        }
        let base = plant.base(self.seed, watch)?;
        let one = |fitted: &FittedModel| {
            let effects = fitted.fit.model.effects.iter();
            let values = effects.flat_map(|effect| effect.values.iter().map(|value| value.unwrap_or(0.0)));
            let start = base.fit.values.iter().copied().chain(values).collect();
            plant.fit(Job::from(&base, fitted.added.clone(), vec![start]), Effort::Full, self.seed, watch)
        };
        let fits = [one(models[0]), one(models[1])];
        if fits.iter().any(|fit| matches!(fit, Err(InferError::NoStart { .. }))) {
            return Ok(None);
        }
        let [first, second] = fits;
        Ok(Some([
            CompetingModel::from_fit(names[0], &first?.fit),
            CompetingModel::from_fit(names[1], &second?.fit),
        ]))
    }

    /// Simulated poses of an episode that was not recorded.
    fn simulated_poses(&self, fitted: &FittedModel, episode: &Prepared) -> Result<Vec<[f64; 3]>, InferError> {
        let values = self.simulator_values(fitted);
        let rollout = self.rollout(fitted, &values)?;
        rollout.open_loop(&rollout.without_poses(episode))
    }

    /// Lack of fit of the second model to an episode of the first after a refit, less that of the first model, nats.
    fn separation(
        &self,
        models: [&FittedModel; 2],
        episode: &Prepared,
        noise: &Noise,
    ) -> Result<f64, InferError> {
        let path = Path::new(episode, noise)?;
        let lack_of_fit = |fitted: &FittedModel| -> Result<f64, InferError> {
            let (values, plant) = (self.simulator_values(fitted), plant(fitted)?);
            let (channels, paths) = (Channels::of(noise), std::slice::from_ref(&path));
            let mut likelihood =
                PathLikelihood::new(self.simulator, &values, paths, channels, self.data.dof, self.watch)?;
            if has_laws_on_object(&fitted.fit.model) {
                likelihood = likelihood.with_law_uncertainty(&plant, &values);
            }
            let misfit = 0.5 * likelihood.innovations(&plant, &values).iter().map(|e| e * e).sum::<f64>();
            Ok(misfit_after_refit(&likelihood, &self.free_model(fitted), &fitted.fit, misfit)?.unwrap_or(0.0))
        };
        let [truth, other] = models;
        Ok((lack_of_fit(other)? - lack_of_fit(truth)?).max(0.0))
    }
}
