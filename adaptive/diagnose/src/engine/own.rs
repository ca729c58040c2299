//! Trundle's own plant as the simulation under test.

use super::{Effort, Engine, Job, Look, REFIT_STEPS, Tried, needs_courses};
use crate::adequacy::{Remainder, left_by, remainder};
use crate::answer::{Channels, Parameter};
use crate::candidates::candidates;
use crate::confirm::{Samples, predicted};
use crate::design::{Bench, Certificate, Experiment, Limits, Rival, certificate, experiment};
use crate::locate::{Located, channels, located};
use crate::nominal::{as_given, given_values, parameters, under_test};
use crate::outlook::{Outlook, outlook};
use crate::series::{Missing, Wrench, wrenches};
use crate::units;
use crate::unnamed::unnamed;
use std::collections::BTreeMap;
use trundle_infer::{
    Comparison, FitOptions, InferError, Likelihood, MotionLikelihood, Residual, Score, Watch, fit, open_loop,
    score_compared, unsmoothed,
};
use trundle_model::{Kind, Model, Scales};
use trundle_record::{Dataset, Prepared};

/// A model of trundle's, compared by its motion or by the wrench that it needs.
#[derive(Clone)]
pub(crate) struct Own<'a> {
    data: &'a Dataset,
    nominal: Model,
    given: Option<Model>,
    comparison: Comparison,
}

impl<'a> Own<'a> {
    /// The simulation under test: `model`, or the paper's.
    ///
    /// # Errors
    /// When there is not enough data.
    pub fn new(data: &'a Dataset, model: Option<&Model>) -> Result<Self, InferError> {
        let (nominal, given) = under_test(data, model);
        Ok(Self { data, nominal, given, comparison: Comparison::of(data)? })
    }

    fn with(&self, comparison: Comparison) -> Self {
        Self { comparison, ..self.clone() }
    }

    /// The comparison under the noise that suits a fit.
    fn under(&self, tried: &Tried) -> Comparison {
        self.comparison.with_channels(tried.fit.channels)
    }

    /// −log density of a fit in units in which its own cost is not known.
    pub fn cost(&self, tried: &Tried) -> Result<f64, InferError> {
        self.under(tried).cost(&tried.fit.model, &tried.fit.values)
    }

    /// Values that were fitted in other units, in SI units.
    pub fn restored(&self, given: &Tried, scales: &Scales, offset: f64) -> Result<Option<Tried>, InferError> {
        let of = |model: &Model| {
            let fit = units::fit(&given.fit, model, &[], scales, offset)?;
            Ok(Tried { fit, ..given.clone() })
        };
        self.given.as_ref().map(of).transpose()
    }

    fn simulated(&self) -> bool {
        !self.is_quasi_static()
    }
}

impl Engine for Own<'_> {
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

    fn base(&self, seed: u64, watch: &dyn Watch) -> Result<Tried, InferError> {
        let options = FitOptions { seed, measure_gradient: true, ..FitOptions::default() };
        let fit = fit(&self.comparison, &self.nominal, &[], &options, watch)?;
        Ok(Tried::new(vec![], fit, None))
    }

    /// Where the noise is not stated, the next searches start from what suits the simulation under test.
    fn upon<'b>(
        &'b self,
        base: &Tried,
        _: Option<Remainder>,
        _: &dyn Watch,
    ) -> Result<Box<dyn Engine + 'b>, InferError> {
        Ok(Box::new(self.with(self.under(base))))
    }

    fn thinned<'b>(&'b self) -> Option<Box<dyn Engine + 'b>> {
        self.simulated().then(|| -> Box<dyn Engine + 'b> { Box::new(self.with(self.comparison.thinned())) })
    }

    fn look(&self, from: &Tried, kinds: &[Kind], at: &mut Look<'_>) -> Result<bool, InferError> {
        let Comparison::Motion(motion) = &self.comparison else { return Ok(false) };
        let motion = motion.thinned().with_channels(from.fit.channels);
        if let Some(seen) = motion.filtered(&from.fit.model, &from.fit.values)? {
            let courses = if needs_courses(kinds) { courses(&motion, from)? } else { vec![] };
            at(&seen, &courses)?;
        }
        Ok(true)
    }

    fn fit(&self, job: Job, effort: Effort, seed: u64, watch: &dyn Watch) -> Result<Tried, InferError> {
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
        Ok(Tried::new(job.added, fit, None))
    }

    fn refitted(
        &self,
        tried: &Tried,
        model: &Model,
        keep: &dyn Fn(usize) -> bool,
        watch: &dyn Watch,
    ) -> Result<Tried, InferError> {
        let near = Some(REFIT_STEPS);
        let options = FitOptions {
            starts: 0,
            distant_starts: false,
            local_steps: near,
            noise_rounds: 0,
            ..FitOptions::default()
        };
        let some = self.under(tried).only(keep);
        let warm = std::slice::from_ref(&tried.fit.values);
        Ok(Tried { fit: fit(&some, model, warm, &options, watch)?, ..tried.clone() })
    }

    fn given(&self, watch: &dyn Watch) -> Result<Option<Tried>, InferError> {
        let fitted = |given: &Model| {
            let fit = as_given(&self.comparison, given, watch)?;
            Ok(Tried::new(vec![], fit, None))
        };
        self.given.as_ref().map(fitted).transpose()
    }

    fn given_values(&self, given: Option<&Tried>) -> BTreeMap<String, f64> {
        given.map_or_else(BTreeMap::new, |given| given_values(&given.fit))
    }

    fn remainder(&self, tried: &Tried) -> Result<Option<Remainder>, InferError> {
        remainder(&self.comparison, &tried.fit)
    }

    fn predicted(&self, tried: &Tried, keep: &dyn Fn(usize) -> bool) -> Result<Samples, InferError> {
        predicted(&self.comparison.only(keep), &tried.fit)
    }

    fn located(&self, tried: &Tried, left: Option<Remainder>) -> Result<Located, InferError> {
        located(&self.comparison, &tried.fit, left, &self.data.training)
    }

    fn channels(&self, tried: &Tried) -> Result<Channels, InferError> {
        channels(&self.comparison, &tried.fit)
    }

    fn outlook(&self, tried: &Tried) -> Result<Outlook, InferError> {
        outlook(self.data, &tried.fit)
    }

    fn score(&self, tried: &Tried, beside: &Tried, episodes: &[Prepared]) -> Result<Score, InferError> {
        let (fit, other) = (&tried.fit, (&beside.fit.model, &beside.fit.values[..]));
        let (noise, quasi) = (&self.data.noise, self.is_quasi_static());
        score_compared(&fit.model, &fit.values, &fit.channels, episodes, noise, quasi, Some(other))
    }

    fn open_loop(&self, tried: &Tried, episode: &Prepared) -> Result<Option<Vec<[f64; 3]>>, InferError> {
        let plant = tried.fit.model.plant(&tried.fit.values)?;
        Ok(self.simulated().then(|| open_loop(&plant, episode)))
    }

    fn missing(&self, tried: &Tried, left: Option<Remainder>) -> Result<Missing, InferError> {
        let (Some(left), Comparison::Motion(motion)) = (left, &self.comparison) else {
            return Ok(Missing { training: None, held_out: None });
        };
        let over = |motion: &MotionLikelihood| {
            motion.with_channels(left.channels).residuals(&tried.fit.model, &tried.fit.values)
        };
        let held_out = match Comparison::over(self.data, &self.data.held_out) {
            Ok(Comparison::Motion(held_out)) => over(&held_out)?,
            _ => None,
        };
        Ok(Missing { training: over(motion)?, held_out })
    }

    fn unsmoothed(&self, tried: &Tried) -> Result<Vec<Vec<Residual>>, InferError> {
        if !self.simulated() {
            return Ok(vec![]);
        }
        let (model, values) = (&tried.fit.model, &tried.fit.values);
        let of = |episode| unsmoothed(model, values, episode, &self.data.noise);
        self.data.training.iter().map(of).collect()
    }

    fn wrenches(&self, episode: &Prepared, models: [&Tried; 2]) -> Result<Option<Wrench>, InferError> {
        if self.simulated() {
            return Ok(None);
        }
        wrenches(self.data, episode, models.map(|tried| &tried.fit))
    }

    fn residual_wrenches(&self, tried: &Tried) -> Result<Option<Vec<[f64; 3]>>, InferError> {
        let Comparison::Wrench(slow) = &self.comparison else { return Ok(None) };
        let plant = tried.fit.model.plant(&tried.fit.values)?;
        Ok(Some(slow.samples().iter().map(|sample| sample.residual(&plant)).collect()))
    }

    fn certificate(&self, names: [&str; 2], models: [&Tried; 2]) -> Result<Certificate, InferError> {
        certificate(&self.comparison, names, models.map(|tried| &tried.fit))
    }

    fn experiment(
        &self,
        names: [&str; 2],
        models: [&Tried; 2],
        noise: &trundle_infer::Channels,
        watch: &dyn Watch,
    ) -> Result<Option<Experiment>, InferError> {
        if self.is_quasi_static() {
            return Ok(None);
        }
        let bench = Bench::after(self.data, noise, Limits::seen(self.data)).hurried();
        let rivals = [0, 1].map(|k| Rival::fitted(names[k], &models[k].fit));
        experiment(&bench, &rivals[0], &rivals[1], 1, watch).map(Some)
    }

    fn unnamed(
        &self,
        base: &Tried,
        left: Option<Remainder>,
        watch: &dyn Watch,
    ) -> Result<Option<Tried>, InferError> {
        let found = unnamed((self.data, &self.nominal), &self.comparison, &base.fit, left, watch)?;
        Ok(found.map(|fit| Tried::new(vec![], fit, None)))
    }

    fn likelihood(&self, tried: &Tried) -> Result<Box<dyn Likelihood + '_>, InferError> {
        Ok(Box::new(self.under(tried)))
    }

    fn parameters(&self, tried: &Tried) -> BTreeMap<String, Parameter> {
        parameters(&tried.fit, &self.nominal)
    }

    /// A mass that slow pushes do not hold is left free.
    fn file(&self, tried: &Tried) -> Result<String, InferError> {
        let mut model = tried.fit.model.clone();
        if self.is_quasi_static() && tried.fit.estimate("body.mass").is_some() {
            model.mass = None;
        }
        Ok(model.to_toml(tried.fit.posterior().as_ref())?)
    }
}

/// The missing wrench along the episodes.
fn courses(motion: &MotionLikelihood, from: &Tried) -> Result<Vec<Vec<Residual>>, InferError> {
    let wandering = motion.with_channels(left_by(motion, &from.fit)?.channels);
    Ok(wandering.residuals(&from.fit.model, &from.fit.values)?.unwrap_or_default())
}
