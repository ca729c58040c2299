//! The diagnosis engine of a black-box simulator.

use super::basis::Basis;
use super::laws::{body, can_be_added, has_laws_on_object, plant};
use super::likelihood::PathLikelihood;
use super::parameter_fit::fit_simulator;
use super::path::Path;
use super::rollout::Rollout;
use super::simulator::BlackBox;
use super::view::{LinearisedView, starts_from_prior};
use super::windows::windows;
use crate::answer::Channels;
use crate::block_bootstrap::PredictedSamples;
use crate::candidates::candidates;
use crate::design::{Certificate, Experiment};
use crate::engine::{Engine, Inspector};
use crate::fitted_model::{Effort, FittedModel, Job, MAX_REFIT_STEPS};
use crate::lack_of_fit::{LackOfFit, best_random_walk};
use crate::linearisation::Start;
use crate::locate::Located;
use crate::missing_wrenches::{MissingWrenches, Wrench};
use crate::parameter::Parameter;
use crate::predictive_check::PredictiveCheck;
use crate::proposals::needs_courses;
use crate::pushing_time::require_pushing_time;
use nalgebra::DVector;
use std::collections::BTreeMap;
use std::sync::Arc;
use trundle_infer::{
    Channels as Noise, Estimate, Fit, FitOptions, InferError, Likelihood, Quiet, Residual, Score, Watch, fit,
    is_quasi_static, unscored_time,
};
use trundle_model::{Kind, Model, Posterior, Slot};
use trundle_record::{Dataset, Prepared};

/// A black-box simulator with a recording.
#[derive(Clone)]
pub(crate) struct BlackBoxEngine<'a> {
    pub(super) data: &'a Dataset,
    pub(super) simulator: &'a BlackBox<'a>,
    pub(super) paths: Arc<[Path]>,
    /// Likelihood of the simulator, linearised at the values around which effects are screened.
    pub(super) likelihood: Arc<PathLikelihood>,
    /// Rigid body without laws, to which effects are added.
    pub(super) bare: Model,
    pub(super) seed: u64,
    /// Polled for cancellation in every step of a simulation on the calling thread.
    pub(super) watch: &'a dyn Watch,
}

impl<'a> BlackBoxEngine<'a> {
    /// Fits the simulator's parameters to the training episodes.
    ///
    /// # Errors
    /// If the recording has too few data or is quasi-static, or if the simulator fails.
    pub fn new(
        data: &'a Dataset,
        simulator: &'a BlackBox<'a>,
        seed: u64,
        watch: &'a dyn Watch,
    ) -> Result<Self, InferError> {
        require_pushing_time(data)?;
        if is_quasi_static(data) {
            return Err(InferError::NoData {
                recording: data.name.clone(),
                reason: "the pushes are quasi-static: their force does not determine the acceleration"
                    .to_owned(),
                remedy: "record faster pushes, or diagnose a model instead of `step`".to_owned(),
            });
        }
        let paths: Vec<Path> =
            data.training.iter().map(|e| Path::new(e, &data.noise)).collect::<Result<_, InferError>>()?;
        let body = body(data, None);
        let noise = Noise::of(&data.noise);
        let likelihood = fit_simulator(simulator, &paths, &simulator.start, noise, &body, seed, watch)?;
        let bare = super::laws::body(data, likelihood.apparent_mass());
        Ok(Self { data, simulator, paths: paths.into(), likelihood: Arc::new(likelihood), bare, seed, watch })
    }

    /// Linearised likelihood that belongs to a model.
    pub(super) fn likelihood_of<'t>(&'t self, fitted: &'t FittedModel) -> &'t Arc<PathLikelihood> {
        fitted.basis.as_ref().map_or(&self.likelihood, |basis| &basis.likelihood)
    }

    /// Linearised likelihood of a model that also counts the uncertainty of its laws' wrenches along the measured
    /// motion.
    pub(super) fn with_law_uncertainty(&self, fitted: &FittedModel) -> Result<PathLikelihood, InferError> {
        let likelihood = self.likelihood_of(fitted);
        if !has_laws_on_object(&fitted.fit.model) {
            return Ok((**likelihood).clone());
        }
        Ok(likelihood.with_law_uncertainty(&plant(fitted)?, &likelihood.parameter_values(&fitted.fit)))
    }

    pub(super) fn simulator_values(&self, fitted: &FittedModel) -> Vec<f64> {
        self.likelihood_of(fitted).parameter_values(&fitted.fit)
    }

    pub(super) fn rollout<'s>(
        &'s self,
        fitted: &FittedModel,
        values: &'s [f64],
    ) -> Result<Rollout<'s>, InferError> {
        let plant = plant(fitted)?;
        // Only the calling thread may poll the watch. Work on other threads polls it between its parts.
        let watch = if rayon::current_thread_index().is_some() { &Quiet } else { self.watch };
        Ok(Rollout { simulator: self.simulator, values, plant, data: self.data, watch })
    }

    pub(super) fn residuals(
        &self,
        fitted: &FittedModel,
        channels: Noise,
    ) -> Result<Vec<Vec<Residual>>, InferError> {
        let plant = plant(fitted)?;
        Ok(self.with_law_uncertainty(fitted)?.residuals(&plant, &self.simulator_values(fitted), channels))
    }
}

impl Engine for BlackBoxEngine<'_> {
    fn data(&self) -> &Dataset {
        self.data
    }

    fn nominal(&self) -> &Model {
        &self.bare
    }

    fn is_quasi_static(&self) -> bool {
        false
    }

    fn observations(&self) -> usize {
        self.likelihood.observations()
    }

    fn candidates(&self) -> Vec<Kind> {
        let wheel = (!self.bare.on_rail()).then_some(Kind::ViscousWheel);
        let known = candidates(&self.bare, false, self.data.commanded);
        known.into_iter().chain(wheel).filter(can_be_added).collect()
    }

    fn base(&self, seed: u64, watch: &dyn Watch) -> Result<FittedModel, InferError> {
        let options = FitOptions { starts: 0, seed, distant_starts: false, ..FitOptions::default() };
        let start: Vec<f64> =
            std::iter::once(self.bare.body.mass).chain(self.likelihood.values.iter().copied()).collect();
        let fit = fit(&*self.likelihood, &self.bare, &[start], &options, watch)?;
        let values = self.likelihood.parameter_values(&fit);
        let basis = Basis { likelihood: self.likelihood.clone(), parameters: values, is_biased: true };
        Ok(FittedModel::new(vec![], fit, Some(basis)))
    }

    /// If an effect is missing, it biases the refitted parameters of the simulator. Laws are therefore screened
    /// around parameters that are fitted together with a random-walk wrench.
    fn for_added_effects<'b>(
        &'b self,
        _: &FittedModel,
        before: Option<LackOfFit>,
        watch: &dyn Watch,
    ) -> Result<Box<dyn Engine + 'b>, InferError> {
        let Some(before) = before.filter(|left| left.is_significant(self.observations())) else {
            return Ok(Box::new(self.clone()));
        };
        let (from, bare) = (&self.likelihood.values, &self.bare);
        let unbiased =
            fit_simulator(self.simulator, &self.paths, from, before.channels, bare, self.seed, watch)?;
        let likelihood = Arc::new(unbiased.with_channels(self.likelihood.channels).with_subset());
        Ok(Box::new(Self { bare: body(self.data, likelihood.apparent_mass()), likelihood, ..self.clone() }))
    }

    fn thinned<'b>(&'b self) -> Option<Box<dyn Engine + 'b>> {
        Some(Box::new(self.clone()))
    }

    fn inspect(
        &self,
        from: &FittedModel,
        kinds: &[Kind],
        at: &mut Inspector<'_>,
    ) -> Result<bool, InferError> {
        let is_biased = from.basis.as_ref().is_none_or(|basis| basis.is_biased);
        let (likelihood, values) = if is_biased {
            ((*self.likelihood).clone(), self.likelihood.values.clone())
        } else {
            (self.with_law_uncertainty(from)?, self.simulator_values(from))
        };
        let residual = DVector::from_vec(likelihood.innovations(&plant(from)?, &values));
        let courses = match self.lack_of_fit(from)? {
            Some(left) if needs_courses(kinds) => self.residuals(from, left.channels)?,
            _ => vec![],
        };
        at(&LinearisedView { likelihood, sim_values: values, residual }, &courses)?;
        Ok(true)
    }

    fn extra_starts(&self, kind: Kind, from: &FittedModel, seed: u64) -> Vec<Start> {
        starts_from_prior(&self.bare, kind, &from.fit.values, seed)
    }

    fn fit(&self, job: Job, effort: Effort, seed: u64, watch: &dyn Watch) -> Result<FittedModel, InferError> {
        self.fit_laws(job, effort, seed, watch)
    }

    fn refitted(
        &self,
        fitted: &FittedModel,
        model: &Model,
        keep: &dyn Fn(usize) -> bool,
        watch: &dyn Watch,
    ) -> Result<FittedModel, InferError> {
        let options = FitOptions {
            starts: 0,
            distant_starts: false,
            local_steps: Some(MAX_REFIT_STEPS),
            ..FitOptions::default()
        };
        let likelihood = self.with_law_uncertainty(fitted)?.only(keep);
        let model = &Model { mass: model.mass.and(fitted.fit.model.mass), ..model.clone() };
        let at: Vec<f64> = fitted.fit.values.iter().copied().chain(self.simulator_values(fitted)).collect();
        Ok(FittedModel { fit: fit(&likelihood, model, &[at], &options, watch)?, ..fitted.clone() })
    }

    fn given(&self, watch: &dyn Watch) -> Result<Option<FittedModel>, InferError> {
        if !self.simulator.given {
            return Ok(None);
        }
        let fixed = |(slot, &value): (&Slot, &f64)| Slot { value: Some(value), ..slot.clone() };
        let parameters = self.simulator.parameters.iter().zip(&self.simulator.start).map(fixed).collect();
        let fixed = BlackBox { parameters, start: self.simulator.start.clone(), ..*self.simulator };
        let (start, channels) = (&self.simulator.start, self.likelihood.channels);
        let likelihood = PathLikelihood::new(&fixed, start, &self.paths, channels, self.bare.dof, watch)?;
        let at: Vec<f64> = std::iter::once(self.bare.body.mass).chain(start.iter().copied()).collect();
        let fit =
            fit(&likelihood, &self.bare, &[at], &FitOptions { starts: 0, ..FitOptions::default() }, watch)?;
        let basis = Basis { likelihood: Arc::new(likelihood), parameters: start.clone(), is_biased: false };
        Ok(Some(FittedModel::new(vec![], fit, Some(basis))))
    }

    fn given_values(&self, given: Option<&FittedModel>) -> BTreeMap<String, f64> {
        let pairs = self.simulator.parameters.iter().zip(&self.simulator.start);
        let reported = pairs.filter(|(p, _)| given.is_some() || p.value.is_some());
        reported.map(|(p, v)| (p.name.clone(), *v)).collect()
    }

    fn lack_of_fit(&self, fitted: &FittedModel) -> Result<Option<LackOfFit>, InferError> {
        let (likelihood, sim_values) = (self.with_law_uncertainty(fitted)?, self.simulator_values(fitted));
        let Fit { model, values, .. } = &fitted.fit;
        let innovations = likelihood.innovations(&model.plant(values)?, &sim_values);
        let directions = self.data.dof.iter().filter(|d| **d).count() * likelihood.observations();
        let excess = 0.5 * (innovations.iter().map(|e| e * e).sum::<f64>() - directions as f64).max(0.0);
        let at: Vec<f64> = values.iter().copied().chain(sim_values).collect();
        let cost = |channels: Noise| likelihood.with_channels(channels).cost(model, &at);
        best_random_walk(likelihood.channels, model.body.gyration, excess, cost).map(Some)
    }

    fn predicted(
        &self,
        fitted: &FittedModel,
        keep: &dyn Fn(usize) -> bool,
    ) -> Result<PredictedSamples, InferError> {
        Ok(self
            .with_law_uncertainty(fitted)?
            .only(keep)
            .predicted(&plant(fitted)?, &self.simulator_values(fitted)))
    }

    fn located(&self, fitted: &FittedModel, left: Option<LackOfFit>) -> Result<Located, InferError> {
        let Some(left) = left else { return Ok(Located::default()) };
        let residuals = self.residuals(fitted, left.channels)?;
        let found = windows(&residuals, self.likelihood_of(fitted));
        Ok(Located::from_residuals(&residuals, found, &self.bare.body))
    }

    fn channels(&self, fitted: &FittedModel) -> Result<Channels, InferError> {
        let plant = plant(fitted)?;
        let mut sum = [0.0; 3];
        let innovations = self.likelihood_of(fitted).innovations(&plant, &self.simulator_values(fitted));
        for (k, innovation) in innovations.iter().enumerate() {
            sum[k % 3] += innovation * innovation;
        }
        let total: f64 = sum.iter().sum();
        let [x, y, theta] = sum.map(|s| if total > 0.0 { s / total } else { 0.0 });
        Ok(Channels { x, y, theta })
    }

    fn predictive_check(&self, fitted: &FittedModel) -> Result<PredictiveCheck, InferError> {
        self.predictions(fitted)
    }

    fn score(
        &self,
        fitted: &FittedModel,
        compared_with: &FittedModel,
        episodes: &[Prepared],
    ) -> Result<Score, InferError> {
        let settling = unscored_time(&compared_with.fit.model).max(unscored_time(&fitted.fit.model));
        self.rollout(fitted, &self.simulator_values(fitted))?.score(episodes, settling)
    }

    fn open_loop(
        &self,
        fitted: &FittedModel,
        episode: &Prepared,
    ) -> Result<Option<Vec<[f64; 3]>>, InferError> {
        let values = self.simulator_values(fitted);
        let rollout = self.rollout(fitted, &values)?;
        rollout.open_loop(&rollout.episode_states(episode)?).map(Some)
    }

    fn missing_wrenches(
        &self,
        fitted: &FittedModel,
        left: Option<LackOfFit>,
    ) -> Result<MissingWrenches, InferError> {
        let training = left.map(|left| self.residuals(fitted, left.channels)).transpose()?;
        Ok(MissingWrenches { training, held_out: None })
    }

    fn wrenches(&self, _: &Prepared, _: [&FittedModel; 2]) -> Result<Option<Wrench>, InferError> {
        Ok(None)
    }

    fn residual_wrenches(&self, _: &FittedModel) -> Result<Option<Vec<[f64; 3]>>, InferError> {
        Ok(None)
    }

    fn certificate(&self, names: [&str; 2], models: [&FittedModel; 2]) -> Result<Certificate, InferError> {
        self.simulation_certificate(names, models)
    }

    fn experiment(
        &self,
        names: [&str; 2],
        models: [&FittedModel; 2],
        noise: &Noise,
        watch: &dyn Watch,
    ) -> Result<Option<Experiment>, InferError> {
        self.design_experiment(names, models, noise, watch)
    }

    fn discrepancy(
        &self,
        _: &FittedModel,
        _: Option<LackOfFit>,
        _: &dyn Watch,
    ) -> Result<Option<FittedModel>, InferError> {
        Ok(None)
    }

    fn likelihood(&self, fitted: &FittedModel) -> Result<Box<dyn Likelihood + '_>, InferError> {
        Ok(Box::new(self.with_law_uncertainty(fitted)?))
    }

    fn parameters(&self, fitted: &FittedModel) -> BTreeMap<String, Parameter> {
        let of_simulator = |e: &&Estimate| self.simulator.parameters.iter().any(|p| p.name == e.name);
        let one = |e: &Estimate| {
            let kept = |value: f64| e.identified.then_some(value);
            let (mean, sd) = (kept(e.mean), kept(e.sd));
            (e.name.clone(), Parameter { mean, sd, unit: e.unit, identifiable: e.identified })
        };
        fitted.fit.estimates.iter().filter(of_simulator).map(one).collect()
    }

    /// `model.toml` with the posterior of the laws' parameters. The simulator's parameters do not belong to the
    /// model.
    fn model_toml(&self, fitted: &FittedModel) -> Result<String, InferError> {
        let law_innovations = |all: Posterior| {
            let named = |name: &String| self.simulator.parameters.iter().all(|p| p.name != *name);
            let kept: Vec<usize> = (0..all.names.len()).filter(|&k| named(&all.names[k])).collect();
            let row = |i: usize| kept.iter().map(|&j| all.covariance[i][j]).collect();
            (!kept.is_empty()).then(|| Posterior {
                names: kept.iter().map(|&k| all.names[k].clone()).collect(),
                mean: kept.iter().map(|&k| all.mean[k]).collect(),
                covariance: kept.iter().map(|&i| row(i)).collect(),
            })
        };
        Ok(fitted.fit.model.to_toml(fitted.fit.posterior().and_then(law_innovations).as_ref())?)
    }
}
