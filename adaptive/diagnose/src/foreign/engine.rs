//! A black box as a diagnosis asks it.

use super::black_box::{Basis, BlackBox, body, plant, usable};
use super::likelihood::Along;
use super::nominal::settle;
use super::simulator::Foreign;
use super::view::{Linear, elsewhere};
use super::windows::windows;
use crate::adequacy::{Remainder, best_walk};
use crate::answer::{Channels, Parameter};
use crate::candidates::candidates;
use crate::confirm::Samples;
use crate::design::{Certificate, Experiment};
use crate::engine::{Effort, Engine, Job, Look, REFIT_STEPS, Tried, needs_courses};
use crate::locate::Located;
use crate::outlook::Outlook;
use crate::screen::Start;
use crate::series::{Missing, Wrench};
use nalgebra::DVector;
use std::collections::BTreeMap;
use std::sync::Arc;
use trundle_infer::{
    Channels as Noise, Estimate, Fit, FitOptions, InferError, Likelihood, Score, Watch, fit, unscored_time,
};
use trundle_model::{Kind, Model, Posterior, Slot};
use trundle_record::{Dataset, Prepared};

impl Engine for BlackBox<'_> {
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
        self.along.observations()
    }

    fn candidates(&self) -> Vec<Kind> {
        let wheel = (!self.bare.on_rail()).then_some(Kind::ViscousWheel);
        let known = candidates(&self.bare, false, self.data.commanded);
        known.into_iter().chain(wheel).filter(usable).collect()
    }

    fn base(&self, seed: u64, watch: &dyn Watch) -> Result<Tried, InferError> {
        let options = FitOptions { starts: 0, seed, distant_starts: false, ..FitOptions::default() };
        let start: Vec<f64> =
            std::iter::once(self.bare.body.mass).chain(self.along.values.iter().copied()).collect();
        let fit = fit(&*self.along, &self.bare, &[start], &options, watch)?;
        let own = self.along.own(&fit);
        let basis = Basis { along: self.along.clone(), own, biased: true };
        Ok(Tried::new(vec![], fit, Some(basis)))
    }

    /// Where something is missing, the simulator's refitted parameters are biased by it. Laws are tried around parameters that
    /// are fitted together with a random-walk wrench.
    fn upon<'b>(
        &'b self,
        _: &Tried,
        before: Option<Remainder>,
        watch: &dyn Watch,
    ) -> Result<Box<dyn Engine + 'b>, InferError> {
        let Some(before) = before.filter(|left| left.matters(self.observations())) else {
            return Ok(Box::new(self.clone()));
        };
        let (from, bare) = (&self.along.values, &self.bare);
        let robust = settle(self.foreign, &self.paths, from, before.channels, bare, self.seed, watch)?;
        let along = Arc::new(robust.with_channels(self.along.channels).sketched());
        Ok(Box::new(Self { bare: body(self.data, along.felt_mass()), along, ..self.clone() }))
    }

    fn thinned<'b>(&'b self) -> Option<Box<dyn Engine + 'b>> {
        Some(Box::new(self.clone()))
    }

    fn look(&self, from: &Tried, kinds: &[Kind], at: &mut Look<'_>) -> Result<bool, InferError> {
        let biased = from.basis.as_ref().is_none_or(|basis| basis.biased);
        let (along, own) = if biased {
            ((*self.along).clone(), self.along.values.clone())
        } else {
            (self.doubting(from)?, self.own(from))
        };
        let residual = DVector::from_vec(along.innovations(&plant(from)?, &own));
        let courses = match self.remainder(from)? {
            Some(left) if needs_courses(kinds) => self.residuals(from, left.channels)?,
            _ => vec![],
        };
        at(&Linear { along, own, residual }, &courses)?;
        Ok(true)
    }

    fn elsewhere(&self, kind: Kind, from: &Tried, seed: u64) -> Vec<Start> {
        elsewhere(&self.bare, kind, &from.fit.values, seed)
    }

    fn fit(&self, job: Job, effort: Effort, seed: u64, watch: &dyn Watch) -> Result<Tried, InferError> {
        self.fit_laws(job, effort, seed, watch)
    }

    fn refitted(
        &self,
        tried: &Tried,
        model: &Model,
        keep: &dyn Fn(usize) -> bool,
        watch: &dyn Watch,
    ) -> Result<Tried, InferError> {
        let options = FitOptions {
            starts: 0,
            distant_starts: false,
            local_steps: Some(REFIT_STEPS),
            ..FitOptions::default()
        };
        let some = self.doubting(tried)?.only(keep);
        let model = &Model { mass: model.mass.and(tried.fit.model.mass), ..model.clone() };
        let at: Vec<f64> = tried.fit.values.iter().copied().chain(self.own(tried)).collect();
        Ok(Tried { fit: fit(&some, model, &[at], &options, watch)?, ..tried.clone() })
    }

    fn given(&self, watch: &dyn Watch) -> Result<Option<Tried>, InferError> {
        if !self.foreign.given {
            return Ok(None);
        }
        let fixed = |(slot, &value): (&Slot, &f64)| Slot { value: Some(value), ..slot.clone() };
        let parameters = self.foreign.parameters.iter().zip(&self.foreign.start).map(fixed).collect();
        let fixed = Foreign { parameters, start: self.foreign.start.clone(), ..*self.foreign };
        let (start, channels) = (&self.foreign.start, self.along.channels);
        let along = Along::new(&fixed, start, &self.paths, channels, self.bare.dof, watch)?;
        let at: Vec<f64> = std::iter::once(self.bare.body.mass).chain(start.iter().copied()).collect();
        let fit = fit(&along, &self.bare, &[at], &FitOptions { starts: 0, ..FitOptions::default() }, watch)?;
        let basis = Basis { along: Arc::new(along), own: start.clone(), biased: false };
        Ok(Some(Tried::new(vec![], fit, Some(basis))))
    }

    fn given_values(&self, given: Option<&Tried>) -> BTreeMap<String, f64> {
        let pairs = self.foreign.parameters.iter().zip(&self.foreign.start);
        let told = pairs.filter(|(p, _)| given.is_some() || p.value.is_some());
        told.map(|(p, v)| (p.name.clone(), *v)).collect()
    }

    fn remainder(&self, tried: &Tried) -> Result<Option<Remainder>, InferError> {
        let (along, own) = (self.doubting(tried)?, self.own(tried));
        let Fit { model, values, .. } = &tried.fit;
        let innovations = along.innovations(&model.plant(values)?, &own);
        let directions = self.data.dof.iter().filter(|d| **d).count() * along.observations();
        let excess = 0.5 * (innovations.iter().map(|e| e * e).sum::<f64>() - directions as f64).max(0.0);
        let at: Vec<f64> = values.iter().copied().chain(own).collect();
        let cost = |channels: Noise| along.with_channels(channels).cost(model, &at);
        best_walk(along.channels, model.body.gyration, excess, cost).map(Some)
    }

    fn predicted(&self, tried: &Tried, keep: &dyn Fn(usize) -> bool) -> Result<Samples, InferError> {
        Ok(self.doubting(tried)?.only(keep).predicted(&plant(tried)?, &self.own(tried)))
    }

    fn located(&self, tried: &Tried, left: Option<Remainder>) -> Result<Located, InferError> {
        let Some(left) = left else { return Ok(Located::default()) };
        let residuals = self.residuals(tried, left.channels)?;
        let found = windows(&residuals, self.along(tried));
        Ok(Located::of_courses(&residuals, found, &self.bare.body))
    }

    fn channels(&self, tried: &Tried) -> Result<Channels, InferError> {
        let plant = plant(tried)?;
        let mut sum = [0.0; 3];
        let innovations = self.along(tried).innovations(&plant, &self.own(tried));
        for (k, innovation) in innovations.iter().enumerate() {
            sum[k % 3] += innovation * innovation;
        }
        let total: f64 = sum.iter().sum();
        let [x, y, theta] = sum.map(|s| if total > 0.0 { s / total } else { 0.0 });
        Ok(Channels { x, y, theta })
    }

    fn outlook(&self, tried: &Tried) -> Result<Outlook, InferError> {
        self.predictions(tried)
    }

    fn score(&self, tried: &Tried, beside: &Tried, episodes: &[Prepared]) -> Result<Score, InferError> {
        let settling = unscored_time(&beside.fit.model).max(unscored_time(&tried.fit.model));
        self.rollout(tried, &self.own(tried))?.score(episodes, settling)
    }

    fn open_loop(&self, tried: &Tried, episode: &Prepared) -> Result<Option<Vec<[f64; 3]>>, InferError> {
        let values = self.own(tried);
        let rollout = self.rollout(tried, &values)?;
        rollout.open_loop(&rollout.seen(episode)?).map(Some)
    }

    fn missing(&self, tried: &Tried, left: Option<Remainder>) -> Result<Missing, InferError> {
        let training = left.map(|left| self.residuals(tried, left.channels)).transpose()?;
        Ok(Missing { training, held_out: None })
    }

    fn wrenches(&self, _: &Prepared, _: [&Tried; 2]) -> Result<Option<Wrench>, InferError> {
        Ok(None)
    }

    fn residual_wrenches(&self, _: &Tried) -> Result<Option<Vec<[f64; 3]>>, InferError> {
        Ok(None)
    }

    fn certificate(&self, names: [&str; 2], models: [&Tried; 2]) -> Result<Certificate, InferError> {
        self.compared(names, models)
    }

    fn experiment(
        &self,
        names: [&str; 2],
        models: [&Tried; 2],
        noise: &Noise,
        watch: &dyn Watch,
    ) -> Result<Option<Experiment>, InferError> {
        self.designed(names, models, noise, watch)
    }

    fn unnamed(&self, _: &Tried, _: Option<Remainder>, _: &dyn Watch) -> Result<Option<Tried>, InferError> {
        Ok(None)
    }

    fn likelihood(&self, tried: &Tried) -> Result<Box<dyn Likelihood + '_>, InferError> {
        Ok(Box::new(self.doubting(tried)?))
    }

    fn parameters(&self, tried: &Tried) -> BTreeMap<String, Parameter> {
        let own = |e: &&Estimate| self.foreign.parameters.iter().any(|p| p.name == e.name);
        let one = |e: &Estimate| {
            let kept = |value: f64| e.identified.then_some(value);
            let (mean, sd) = (kept(e.mean), kept(e.sd));
            (e.name.clone(), Parameter { mean, sd, unit: e.unit, identifiable: e.identified })
        };
        tried.fit.estimates.iter().filter(own).map(one).collect()
    }

    /// With the posterior of the laws' parameters: the simulator's are not the model's.
    fn file(&self, tried: &Tried) -> Result<String, InferError> {
        let of_laws = |all: Posterior| {
            let named = |name: &String| self.foreign.parameters.iter().all(|p| p.name != *name);
            let kept: Vec<usize> = (0..all.names.len()).filter(|&k| named(&all.names[k])).collect();
            let row = |i: usize| kept.iter().map(|&j| all.covariance[i][j]).collect();
            (!kept.is_empty()).then(|| Posterior {
                names: kept.iter().map(|&k| all.names[k].clone()).collect(),
                mean: kept.iter().map(|&k| all.mean[k]).collect(),
                covariance: kept.iter().map(|&i| row(i)).collect(),
            })
        };
        Ok(tried.fit.model.to_toml(tried.fit.posterior().and_then(of_laws).as_ref())?)
    }
}
