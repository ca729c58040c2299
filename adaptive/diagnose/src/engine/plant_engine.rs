//! Trundle's own plant as the nominal model.

use super::{Engine, Inspector};
use crate::answer::Channels;
use crate::block_bootstrap::{PredictedSamples, predicted_samples};
use crate::candidates::candidates;
use crate::design::{Certificate, CompetingModel, Experiment, Limits, Setup, certificate, experiment};
use crate::discrepancy::fit_discrepancy;
use crate::fitted_model::{Effort, FittedModel, Job, MAX_REFIT_STEPS};
use crate::lack_of_fit::{LackOfFit, chi_squared_excess, lack_of_fit, motion_lack_of_fit};
use crate::locate::{Located, locate, misfit_shares};
use crate::missing_wrenches::{MissingWrenches, Wrench};
use crate::nominal::{as_given, given_values, parameters, under_test, undistorted};
use crate::parameter::Parameter;
use crate::predictive_check::{PredictiveCheck, predictive_check};
use crate::proposals::needs_courses;
use crate::series::wrenches;
use crate::thresholds::{MAX_MISFIT_PER_SAMPLE_NATS, MIN_MATERIAL_ERROR_RATIO};
use crate::units;
use std::collections::BTreeMap;
use trundle_infer::{
    Comparison, FitOptions, InferError, Likelihood, MotionLikelihood, Residual, Score, Watch, fit, open_loop,
    score_compared, unsmoothed,
};
use trundle_model::{Kind, Model, Scales};
use trundle_record::{Dataset, Prepared};

/// Most halvings of the random-walk wrench of a softened comparison.
const MAX_HALVINGS: i32 = 10;

/// Trundle's plant, compared by its motion or by the wrench that it needs.
#[derive(Clone)]
pub(crate) struct PlantEngine<'a> {
    data: &'a Dataset,
    nominal: Model,
    given: Option<Model>,
    comparison: Comparison,
}

impl<'a> PlantEngine<'a> {
    /// The engine for a nominal model: `model`, or the paper's.
    ///
    /// # Errors
    /// If there is not enough data.
    pub fn new(data: &'a Dataset, model: Option<&Model>) -> Result<Self, InferError> {
        let (nominal, given) = under_test(data, model);
        Ok(Self { data, nominal, given, comparison: Comparison::of(data)? })
    }

    fn with(&self, comparison: Comparison) -> Self {
        Self { comparison, ..self.clone() }
    }

    /// The comparison under the noise of a fit.
    fn under(&self, fitted: &FittedModel) -> Comparison {
        self.comparison.with_channels(fitted.fit.channels)
    }

    /// −log density of a fit whose cost is only known in other units, nats.
    pub fn cost(&self, fitted: &FittedModel) -> Result<f64, InferError> {
        self.under(fitted).cost(&fitted.fit.model, &fitted.fit.values)
    }

    /// A fit of the given values in other units, converted to SI units.
    pub fn restored(
        &self,
        given: &FittedModel,
        scales: &Scales,
        offset: f64,
    ) -> Result<Option<FittedModel>, InferError> {
        let of = |model: &Model| {
            let fit = units::fit(&given.fit, model, &[], scales, offset)?;
            Ok(FittedModel { fit, ..given.clone() })
        };
        self.given.as_ref().map(of).transpose()
    }

    fn simulated(&self) -> bool {
        !self.is_quasi_static()
    }
}

impl Engine for PlantEngine<'_> {
    fn data(&self) -> &Dataset {
        self.data
    }

    fn nominal(&self) -> &Model {
        &self.nominal
    }

    fn is_quasi_static(&self) -> bool {
        self.comparison.is_quasi_static()
    }

    fn observations(&self) -> usize {
        self.comparison.observations()
    }

    fn candidates(&self) -> Vec<Kind> {
        candidates(&self.nominal, self.is_quasi_static(), self.data.commanded)
    }

    fn base(&self, seed: u64, watch: &dyn Watch) -> Result<FittedModel, InferError> {
        let options = FitOptions { seed, measure_gradient: true, ..FitOptions::default() };
        let fit = fit(&self.comparison, &self.nominal, &[], &options, watch)?;
        Ok(FittedModel::new(vec![], fit, None))
    }

    fn undistorted(
        &self,
        base: &FittedModel,
        seed: u64,
        watch: &dyn Watch,
    ) -> Result<Option<FittedModel>, InferError> {
        let Some(fit) = undistorted(&self.comparison, &self.nominal, &base.fit, seed, watch)? else {
            return Ok(None);
        };
        let found = FittedModel { fit, ..base.clone() };
        let [before, after] = [base, &found].map(|fitted| self.predictive_check(fitted));
        Ok((after?.share * MIN_MATERIAL_ERROR_RATIO < before?.share).then_some(found))
    }

    /// If the recording does not state the noise, the search starts from that of the nominal model.
    fn for_added_effects<'b>(
        &'b self,
        base: &FittedModel,
        _: Option<LackOfFit>,
        _: &dyn Watch,
    ) -> Result<Box<dyn Engine + 'b>, InferError> {
        Ok(Box::new(self.with(self.under(base))))
    }

    fn thinned<'b>(&'b self) -> Option<Box<dyn Engine + 'b>> {
        self.simulated().then(|| -> Box<dyn Engine + 'b> { Box::new(self.with(self.comparison.thinned())) })
    }

    fn softened<'b>(&'b self, fitted: &FittedModel) -> Result<Option<Box<dyn Engine + 'b>>, InferError> {
        let Comparison::Motion(motion) = self.under(fitted) else { return Ok(None) };
        let most = MAX_MISFIT_PER_SAMPLE_NATS * self.observations() as f64;
        let is_moderate =
            |motion: &MotionLikelihood| Ok::<_, InferError>(chi_squared_excess(motion, &fitted.fit)? <= most);
        if is_moderate(&motion)? {
            return Ok(None);
        }
        let mut softened = motion.clone();
        for halvings in (0..=MAX_HALVINGS).rev() {
            softened = motion.softened(0.5f64.powi(halvings));
            if is_moderate(&softened)? {
                break;
            }
        }
        Ok(Some(Box::new(self.with(Comparison::Motion(softened)))))
    }

    fn inspect(
        &self,
        from: &FittedModel,
        kinds: &[Kind],
        at: &mut Inspector<'_>,
    ) -> Result<bool, InferError> {
        let Comparison::Motion(motion) = &self.comparison else { return Ok(false) };
        let motion = motion.thinned().with_channels(from.fit.channels);
        if let Some(seen) = motion.filtered(&from.fit.model, &from.fit.values)? {
            let courses = if needs_courses(kinds) { courses(&motion, from)? } else { vec![] };
            at(&seen, &courses)?;
        }
        Ok(true)
    }

    fn fit(&self, job: Job, effort: Effort, seed: u64, watch: &dyn Watch) -> Result<FittedModel, InferError> {
        let mut model = self.nominal.clone();
        model.effects.extend(job.added.iter().cloned());
        let near = self.simulated().then_some(effort.steps());
        let noise_rounds = effort.noise_rounds();
        let options = FitOptions {
            starts: 0,
            seed,
            distant_starts: false,
            local_steps: near,
            noise_rounds,
            ..FitOptions::default()
        };
        let from = self.comparison.with_channels(job.channels);
        let fit = fit(&from, &model, &job.warm, &options, watch)?;
        Ok(FittedModel::new(job.added, fit, None))
    }

    fn refitted(
        &self,
        fitted: &FittedModel,
        model: &Model,
        keep: &dyn Fn(usize) -> bool,
        watch: &dyn Watch,
    ) -> Result<FittedModel, InferError> {
        let near = Some(MAX_REFIT_STEPS);
        let options = FitOptions {
            starts: 0,
            distant_starts: false,
            local_steps: near,
            noise_rounds: 0,
            ..FitOptions::default()
        };
        let some = self.under(fitted).only(keep);
        let warm = std::slice::from_ref(&fitted.fit.values);
        Ok(FittedModel { fit: fit(&some, model, warm, &options, watch)?, ..fitted.clone() })
    }

    fn given(&self, watch: &dyn Watch) -> Result<Option<FittedModel>, InferError> {
        let fitted = |given: &Model| {
            let fit = as_given(&self.comparison, given, watch)?;
            Ok(FittedModel::new(vec![], fit, None))
        };
        self.given.as_ref().map(fitted).transpose()
    }

    fn given_values(&self, given: Option<&FittedModel>) -> BTreeMap<String, f64> {
        given.map_or_else(BTreeMap::new, |given| given_values(&given.fit))
    }

    fn lack_of_fit(&self, fitted: &FittedModel) -> Result<Option<LackOfFit>, InferError> {
        lack_of_fit(&self.comparison, &fitted.fit)
    }

    fn predicted(
        &self,
        fitted: &FittedModel,
        keep: &dyn Fn(usize) -> bool,
    ) -> Result<PredictedSamples, InferError> {
        predicted_samples(&self.comparison.only(keep), &fitted.fit)
    }

    fn located(&self, fitted: &FittedModel, lack: Option<LackOfFit>) -> Result<Located, InferError> {
        locate(&self.comparison, &fitted.fit, lack, &self.data.training)
    }

    fn channels(&self, fitted: &FittedModel) -> Result<Channels, InferError> {
        misfit_shares(&self.comparison, &fitted.fit)
    }

    fn predictive_check(&self, fitted: &FittedModel) -> Result<PredictiveCheck, InferError> {
        predictive_check(self.data, &fitted.fit)
    }

    fn score(
        &self,
        fitted: &FittedModel,
        compared_with: &FittedModel,
        episodes: &[Prepared],
    ) -> Result<Score, InferError> {
        let (fit, other) = (&fitted.fit, (&compared_with.fit.model, &compared_with.fit.values[..]));
        let (noise, quasi) = (&self.data.noise, self.is_quasi_static());
        score_compared(&fit.model, &fit.values, &fit.channels, episodes, noise, quasi, Some(other))
    }

    fn open_loop(
        &self,
        fitted: &FittedModel,
        episode: &Prepared,
    ) -> Result<Option<Vec<[f64; 3]>>, InferError> {
        let plant = fitted.fit.model.plant(&fitted.fit.values)?;
        Ok(self.simulated().then(|| open_loop(&plant, episode)))
    }

    fn missing_wrenches(
        &self,
        fitted: &FittedModel,
        lack: Option<LackOfFit>,
    ) -> Result<MissingWrenches, InferError> {
        let (Some(lack), Comparison::Motion(motion)) = (lack, &self.comparison) else {
            return Ok(MissingWrenches { training: None, held_out: None });
        };
        let over = |motion: &MotionLikelihood| {
            motion.with_channels(lack.channels).residuals(&fitted.fit.model, &fitted.fit.values)
        };
        let held_out = match Comparison::over(self.data, &self.data.held_out) {
            Ok(Comparison::Motion(held_out)) => over(&held_out)?,
            _ => None,
        };
        Ok(MissingWrenches { training: over(motion)?, held_out })
    }

    fn unsmoothed(&self, fitted: &FittedModel) -> Result<Vec<Vec<Residual>>, InferError> {
        if !self.simulated() {
            return Ok(vec![]);
        }
        let (model, values) = (&fitted.fit.model, &fitted.fit.values);
        let of = |episode| unsmoothed(model, values, episode, &self.data.noise);
        self.data.training.iter().map(of).collect()
    }

    fn wrenches(&self, episode: &Prepared, models: [&FittedModel; 2]) -> Result<Option<Wrench>, InferError> {
        if self.simulated() {
            return Ok(None);
        }
        wrenches(self.data, episode, models.map(|fitted| &fitted.fit))
    }

    fn residual_wrenches(&self, fitted: &FittedModel) -> Result<Option<Vec<[f64; 3]>>, InferError> {
        let Comparison::Wrench(slow) = &self.comparison else { return Ok(None) };
        let plant = fitted.fit.model.plant(&fitted.fit.values)?;
        Ok(Some(slow.samples().iter().map(|sample| sample.residual(&plant)).collect()))
    }

    fn certificate(&self, names: [&str; 2], models: [&FittedModel; 2]) -> Result<Certificate, InferError> {
        certificate(&self.comparison, names, models.map(|fitted| &fitted.fit))
    }

    fn experiment(
        &self,
        names: [&str; 2],
        models: [&FittedModel; 2],
        noise: &trundle_infer::Channels,
        watch: &dyn Watch,
    ) -> Result<Option<Experiment>, InferError> {
        if self.is_quasi_static() {
            return Ok(None);
        }
        let setup =
            Setup::from_recording(self.data, noise, Limits::from_recording(self.data)).with_short_search();
        let models = [0, 1].map(|k| CompetingModel::from_fit(names[k], &models[k].fit));
        experiment(&setup, &models[0], &models[1], 1, watch).map(Some)
    }

    fn discrepancy(
        &self,
        base: &FittedModel,
        lack: Option<LackOfFit>,
        watch: &dyn Watch,
    ) -> Result<Option<FittedModel>, InferError> {
        let found = fit_discrepancy((self.data, &self.nominal), &self.comparison, &base.fit, lack, watch)?;
        Ok(found.map(|fit| FittedModel::new(vec![], fit, None)))
    }

    fn likelihood(&self, fitted: &FittedModel) -> Result<Box<dyn Likelihood + '_>, InferError> {
        Ok(Box::new(self.under(fitted)))
    }

    fn parameters(&self, fitted: &FittedModel) -> BTreeMap<String, Parameter> {
        parameters(&fitted.fit, &self.nominal)
    }

    /// A mass that slow pushes do not identify is left free.
    fn model_toml(&self, fitted: &FittedModel) -> Result<String, InferError> {
        let mut model = fitted.fit.model.clone();
        if self.is_quasi_static() && fitted.fit.estimate("body.mass").is_some() {
            model.mass = None;
        }
        Ok(model.to_toml(fitted.fit.posterior().as_ref())?)
    }
}

/// The missing wrench along the episodes.
fn courses(motion: &MotionLikelihood, from: &FittedModel) -> Result<Vec<Vec<Residual>>, InferError> {
    let with_walk = motion.with_channels(motion_lack_of_fit(motion, &from.fit)?.channels);
    Ok(with_walk.residuals(&from.fit.model, &from.fit.values)?.unwrap_or_default())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::PlantEngine;
    use crate::engine::Engine;
    use crate::lack_of_fit::chi_squared_excess;
    use crate::thresholds::MAX_MISFIT_PER_SAMPLE_NATS;
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::{Comparison, Quiet};
    use trundle_model::{Kind, Model};

    #[test]
    fn with_a_random_walk_wrench_the_misfit_is_moderate() {
        let softened = |truth: Model| {
            let data = World::of(truth).recording(1);
            let engine = PlantEngine::new(&data, None).unwrap();
            let base = engine.base(0, &Quiet).unwrap();
            let softened = engine.softened(&base).unwrap()?;
            let channels = softened.likelihood(&base).unwrap().channels();
            let Comparison::Motion(motion) = Comparison::of(&data).unwrap() else { return None };
            let excess = chi_squared_excess(&motion.with_channels(channels), &base.fit).unwrap();
            Some((excess / engine.observations() as f64, channels.wander))
        };
        assert!(softened(locked()).is_none());
        let dry = effect(Kind::CoulombFriction, &[("x", 0.45), ("y", 0.31), ("force", 15.0)]);
        let (excess, wander) = softened(locked().with(dry)).unwrap();
        assert!(excess <= MAX_MISFIT_PER_SAMPLE_NATS, "{excess} with {wander:?}");
    }
}
