//! A black box as a diagnosis asks it.

use super::gains::Ahead;
use super::likelihood::Along;
use super::nominal::settle;
use super::path::Path;
use super::rollout::Rollout;
use super::simulator::Foreign;
use super::view::{Linear, elsewhere};
use super::windows::windows;
use crate::adequacy::{Remainder, best_walk};
use crate::answer::{Channels, Parameter};
use crate::candidates::candidates;
use crate::confirm::Samples;
use crate::design::{BLIND, Certificate, Experiment, Simulated, of_simulations};
use crate::engine::{Effort, Engine, Job, REFIT_STEPS, Tried, needs_courses};
use crate::enough::enough;
use crate::locate::Located;
use crate::outlook::{End, Outlook};
use crate::periods::in_position;
use crate::proposals::Hints;
use crate::screen::{Screen, Start, Wanted};
use crate::series::{Missing, Wrench};
use crate::touch::touches;
use nalgebra::{DVector, Vector3};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;
use trundle_infer::{
    Channels as Noise, Estimate, Fit, FitOptions, InferError, Likelihood, Quiet, Residual, Score, Watch, fit,
    on_all_cores, quasi_static,
};
use trundle_model::{Acting, Kind, Model, Posterior, Slot};
use trundle_record::{Dataset, Prepared};

/// What the simulator was replaced by for a fit.
#[derive(Clone)]
pub(crate) struct Basis {
    along: Arc<Along>,
    /// Values of the simulator's parameters in the fit.
    own: Vec<f64>,
    /// Whether those are biased by what is missing, so that effects are not tried around them.
    biased: bool,
}

/// Fits of a law on the object, each trusting it as far as the one before says.
const ROUNDS: usize = 2;
/// Starts that a search gives for each place of an effect: two steps, with and without what they shift.
const OF_A_PLACE: usize = 4;
/// Linearisations of one model at most.
const TURNS: usize = 4;
/// Change of the logarithm of a parameter below which a model is settled.
const STILL: f64 = 0.03;
/// Length of a prediction, s.
const WINDOW: f64 = 1.0;

/// A simulator that nothing is known of, with a recording.
#[derive(Clone)]
pub(crate) struct BlackBox<'a> {
    data: &'a Dataset,
    foreign: &'a Foreign<'a>,
    paths: Arc<[Path]>,
    /// The simulator, linearised where effects are tried.
    along: Arc<Along>,
    /// The body that laws know, without laws.
    bare: Model,
    seed: u64,
    /// Asked in every step of a simulation on the calling thread whether to go on.
    watch: &'a dyn Watch,
}

impl<'a> BlackBox<'a> {
    /// The simulator with its parameters refitted.
    ///
    /// # Errors
    /// When there is not enough data, or the simulator fails.
    pub fn new(
        data: &'a Dataset,
        foreign: &'a Foreign<'a>,
        seed: u64,
        watch: &'a dyn Watch,
    ) -> Result<Self, InferError> {
        enough(data)?;
        if quasi_static(data) {
            return Err(InferError::NoData {
                recording: data.name.clone(),
                reason: "the pushes are so slow that their force says nothing of the motion to come"
                    .to_owned(),
                remedy: "a simulator is driven by force: push faster, or diagnose a model instead of `step`"
                    .to_owned(),
            });
        }
        let paths: Vec<Path> =
            data.training.iter().map(|e| Path::new(e, &data.noise)).collect::<Result<_, InferError>>()?;
        let body = body(data, None);
        let noise = Noise::of(&data.noise);
        let along = settle(foreign, &paths, &foreign.start, noise, &body, seed, watch)?;
        let bare = self::body(data, along.felt_mass());
        Ok(Self { data, foreign, paths: paths.into(), along: Arc::new(along), bare, seed, watch })
    }

    /// The linearised simulator of a model.
    fn along<'t>(&'t self, tried: &'t Tried) -> &'t Arc<Along> {
        tried.basis.as_ref().map_or(&self.along, |basis| &basis.along)
    }

    /// The same, trusting the model's laws as far as the seen motion tells what they do.
    fn doubting(&self, tried: &Tried) -> Result<Along, InferError> {
        let along = self.along(tried);
        if !on_object(&tried.fit.model) {
            return Ok((**along).clone());
        }
        Ok(along.doubting(&tried.fit.model.plant(&tried.fit.values)?))
    }

    fn own(&self, tried: &Tried) -> Vec<f64> {
        self.along(tried).own(&tried.fit)
    }

    fn rollout<'s>(&'s self, tried: &Tried, values: &'s [f64]) -> Result<Rollout<'s>, InferError> {
        let plant = tried.fit.model.plant(&tried.fit.values)?;
        // A watch is asked on the calling thread only; work on other threads asks between its parts.
        let watch = if rayon::current_thread_index().is_some() { &Quiet } else { self.watch };
        Ok(Rollout { foreign: self.foreign, values, plant, watch })
    }

    fn residuals(&self, tried: &Tried, channels: Noise) -> Result<Vec<Vec<Residual>>, InferError> {
        let plant = tried.fit.model.plant(&tried.fit.values)?;
        Ok(self.doubting(tried)?.residuals(&plant, &self.own(tried), channels))
    }
}

/// The body as laws know it.
fn body(data: &Dataset, felt: Option<f64>) -> Model {
    let mass = data.mass_given.or(felt).unwrap_or(data.body.mass);
    let mut model = Model::nominal(data.body.clone(), Some(mass), data.dof);
    model.body.mass = mass;
    model.effects.clear();
    model
}

/// Whether a model has laws that act on the object.
fn on_object(model: &Model) -> bool {
    model.effects.iter().any(|e| e.kind.spec().acting != Acting::Instrument)
}

/// Laws with states of their own are not tried: along the seen motion they would need a start in every episode. Nor is
/// an event of a wheel that only the simulator knows, nor what looks at readings before and after the moment.
fn usable(kind: &Kind) -> bool {
    kind.spec().inner.is_empty() && !kind.changes_wheels() && !kind.remembers()
}

/// Fit laws together with the simulator's parameters where it is linearised.
fn fitted(
    along: &Along,
    model: &Model,
    starts: &[Vec<f64>],
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Fit, InferError> {
    let mut found = fit(along, model, starts, options, watch)?;
    if !on_object(model) {
        return Ok(found);
    }
    for _ in 0..ROUNDS {
        let doubting = along.doubting(&found.model.plant(&found.values)?);
        let at: Vec<f64> = found.values.iter().copied().chain(along.own(&found)).collect();
        found = fit(&doubting, model, &[at], options, watch)?;
    }
    Ok(found)
}

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
        let options = FitOptions { starts: 0, seed, from_afar: false, ..FitOptions::default() };
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

    fn starts(
        &self,
        from: &Tried,
        kinds: &[Kind],
        wanted: &Wanted<'_>,
        watch: &dyn Watch,
    ) -> Result<Option<Vec<Vec<Start>>>, InferError> {
        on_all_cores(watch, |watch| {
            let biased = from.basis.as_ref().is_none_or(|basis| basis.biased);
            let (along, own) = if biased {
                ((*self.along).clone(), self.along.values.clone())
            } else {
                (self.doubting(from)?, self.own(from))
            };
            let plant = from.fit.model.plant(&from.fit.values)?;
            let residual = DVector::from_vec(along.innovations(&plant, &own));
            let courses = match self.remainder(from)? {
                Some(left) if needs_courses(kinds) => self.residuals(from, left.channels)?,
                _ => vec![],
            };
            let touched = touches(&courses, &self.bare.body);
            let lines = in_position(&courses, self.bare.on_rail());
            let hints = Hints { touched: &touched, regions: wanted.regions, lines: &lines };
            let view = Linear { along, own, residual };
            let screen = Screen { view: &view, episodes: &self.data.training, hints: &hints, wanted };
            let mut found = screen.of(&from.fit, kinds, watch)?;
            for starts in &mut found {
                starts.extend(elsewhere(&self.bare, starts[0].effect.kind, &from.fit.values, wanted.seed));
            }
            Ok(Some(found))
        })
    }

    fn fit(&self, job: Job, effort: Effort, seed: u64, watch: &dyn Watch) -> Result<Tried, InferError> {
        let mut model = self.bare.clone();
        model.effects.extend(job.added.iter().cloned());
        let near = Some(effort.steps());
        let options = FitOptions { starts: 0, seed, from_afar: false, near, ..FitOptions::default() };
        let (mut along, own) = match job.basis {
            Some(Basis { along, own, biased: false }) => (along, own),
            _ => (self.along.clone(), self.along.values.clone()),
        };
        let start = |laws: &Vec<f64>| laws.iter().chain(&own).copied().collect();
        let starts: Vec<Vec<f64>> = job.warm.iter().map(start).collect();
        // Those of each place are followed: which place leads where is not seen from its beginning.
        let one = |of_place: &[Vec<f64>]| fitted(&along, &model, of_place, &options, watch);
        let all = starts.par_chunks(OF_A_PLACE).map(one).collect::<Result<Vec<_>, InferError>>()?;
        let best = all.into_iter().min_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
        let Some(mut found) = best else {
            return Err(InferError::NoStart { recording: self.data.name.clone(), starts: 0 });
        };
        let turns = if effort == Effort::Full { TURNS } else { 0 };
        for _ in 0..turns {
            let values = along.trusted(&found);
            let still = |(a, b): (&f64, &f64)| (a - b).abs() < STILL * b.abs().max(1e-9);
            if values.iter().zip(&along.values).all(still) {
                break;
            }
            let dof = self.bare.dof;
            let anew = Along::new(self.foreign, &values, &self.paths, along.channels, dof, watch)?;
            along = Arc::new(anew);
            let at: Vec<f64> = found.values.iter().chain(&values).copied().collect();
            found = fitted(&along, &model, &[at], &options, watch)?;
        }
        let own = along.own(&found);
        Ok(Tried::new(job.added, found, Some(Basis { along, own, biased: false })))
    }

    fn refitted(
        &self,
        tried: &Tried,
        model: &Model,
        keep: &dyn Fn(usize) -> bool,
        watch: &dyn Watch,
    ) -> Result<Tried, InferError> {
        let options =
            FitOptions { starts: 0, from_afar: false, near: Some(REFIT_STEPS), ..FitOptions::default() };
        let some = self.doubting(tried)?.only(keep);
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
        let plant = tried.fit.model.plant(&tried.fit.values)?;
        Ok(self.doubting(tried)?.only(keep).predicted(&plant, &self.own(tried)))
    }

    fn located(&self, tried: &Tried, left: Option<Remainder>) -> Result<Located, InferError> {
        let Some(left) = left else { return Ok(Located::default()) };
        let residuals = self.residuals(tried, left.channels)?;
        let found = windows(&residuals, self.along(tried));
        Ok(Located::of_courses(&residuals, found, &self.bare.body))
    }

    fn channels(&self, tried: &Tried) -> Result<Channels, InferError> {
        let plant = tried.fit.model.plant(&tried.fit.values)?;
        let mut sum = [0.0; 3];
        let innovations = self.along(tried).innovations(&plant, &self.own(tried));
        for (k, innovation) in innovations.iter().enumerate() {
            sum[k % 3] += innovation * innovation;
        }
        let total: f64 = sum.iter().sum();
        let [x, y, theta] = sum.map(|s| if total > 0.0 { s / total } else { 0.0 });
        Ok(Channels { x, y, theta })
    }

    /// The simulator predicts; how uncertain that is, by the instruments' noise, its linearisation tells.
    fn outlook(&self, tried: &Tried) -> Result<Outlook, InferError> {
        let (along, dof, values) = (self.along(tried), self.data.dof, self.own(tried));
        let rollout = self.rollout(tried, &values)?;
        let moves = |v: [f64; 3]| [0, 1, 2].map(|k| if dof[k] { v[k] } else { 0.0 });
        let mut ends = vec![];
        for (k, (path, episode)) in along.paths.iter().zip(&self.data.training).enumerate() {
            let known = episode.motion_so_far(&self.data.noise);
            for Ahead { from, to, covariance } in along.ahead(k, &known, WINDOW) {
                let [from, to] = [from, to].map(|k| &path.intervals[k]);
                let span = [from, to].map(|interval| interval.t + interval.span);
                let Some(root) = covariance.cholesky() else { continue };
                let Some(error) = rollout.ahead(episode, &known, span)? else { continue };
                let whitened: Vector3<f64> =
                    root.l().solve_lower_triangular(&Vector3::from(error)).unwrap_or_default();
                let motion = [0, 1, 2].map(|k| to.seen[k] - from.seen[k]);
                ends.push(End { error: moves(error), whitened: moves(whitened.into()), motion });
            }
        }
        Ok(Outlook::over(ends.into_iter(), dof, self.bare.body.gyration))
    }

    fn score(&self, tried: &Tried, _: &Tried, episodes: &[Prepared]) -> Result<Score, InferError> {
        let values = self.own(tried);
        let rollout = self.rollout(tried, &values)?;
        rollout.score(episodes, &self.data.noise, self.data.dof, self.bare.body.gyration)
    }

    fn open_loop(&self, tried: &Tried, episode: &Prepared) -> Result<Option<Vec<[f64; 3]>>, InferError> {
        let values = self.own(tried);
        self.rollout(tried, &values)?.open_loop(episode).map(Some)
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

    /// By simulations in open loop, beside what the instruments' noise makes of one.
    fn certificate(&self, names: [&str; 2], models: [&Tried; 2]) -> Result<Certificate, InferError> {
        let blind = self.doubting(models[0])?.with_channels(self.along.channels.scaled(BLIND, 1.0));
        let pose = self.along.channels.pose;
        let mut simulated = vec![];
        for (episode, spreads) in self.data.training.iter().zip(blind.spreads()) {
            let [a, b] = models.map(|tried| self.open_loop(tried, episode));
            let (a, b) = (a?.unwrap_or_default(), b?.unwrap_or_default());
            let at = |&(t, sd): &(f64, [f64; 3])| {
                let k = episode.pose.partition_point(|p| p.t < t - 1e-6);
                let sd = [0, 1, 2].map(|c| sd[c].hypot(pose[c]));
                Some((t, [*a.get(k)?, *b.get(k)?], sd))
            };
            let samples = spreads.iter().filter_map(at).collect();
            simulated.push(Simulated { episode: episode.name.clone(), samples });
        }
        let costs = models.map(|tried| tried.fit.cost);
        Ok(of_simulations(names, costs, &simulated, self.data.dof))
    }

    /// A push cannot be designed yet: the planner simulates trundle's own plant.
    fn experiment(
        &self,
        _: [&str; 2],
        _: [&Tried; 2],
        _: &Noise,
        _: &dyn Watch,
    ) -> Result<Option<Experiment>, InferError> {
        Ok(None)
    }

    fn unnamed(&self, _: &Tried, _: Option<Remainder>, _: &dyn Watch) -> Result<Option<Tried>, InferError> {
        Ok(None)
    }

    /// The simulator's own.
    /// The simulator's own parameters are estimated beside the laws', where no sandwich is known.
    fn widened(&self, tried: &Tried) -> Result<Tried, InferError> {
        Ok(tried.clone())
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
