//! Models with one more effect than a model: a screen of all candidates, and fits of the best to their optimum.

use crate::candidates::candidates;
use crate::error::MechanismError;
use crate::fit::{Fit, Freedom, MAX_STEPS, fit, fit_with};
use crate::fitted_model::FittedModel;
use crate::laws::{JointKind, plays};
use crate::model::{Effect, Kind};
use crate::periodogram::best_periods;
use crate::point_masses::best_point_masses;
use crate::quadratic_cost::QuadraticCost;
use crate::rows::{Scope, evaluate, noise_floor, robust_sd};
use crate::search::{SCREENING_STEPS, Searcher};
use crate::slots::slots;
use rayon::prelude::*;
use trundle_diagnose::MIN_MATERIAL_ERROR_RATIO;
use trundle_infer::on_all_cores;

/// Candidates that are fitted to their optimum.
const MAX_FITTED: usize = 6;
/// Plays from which a fit starts at the given values of the mechanism.
const MAX_PLAYS: usize = 3;
/// Least gain of a candidate in the screen, nats.
const MIN_SCREEN_GAIN_NATS: f64 = 3.0;

impl Searcher<'_> {
    /// Models with one more effect, fitted to their optimum, the best first.
    pub fn children(
        &self,
        parent: &FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<Vec<FittedModel>, MechanismError> {
        let cost = parent.fit.cost(&self.times(parent));
        if let Some(known) = self.child_cache.get(parent, cost) {
            return Ok(known);
        }
        let found = self.children_where(parent, models, &|_| true)?;
        self.child_cache.insert(parent, cost, &found);
        Ok(found)
    }

    /// Models with one more effect that `is_wanted`, fitted to their optimum, the best first. An effect is material only if the
    /// residual of its joint is larger than the noise.
    pub fn children_where(
        &self,
        parent: &FittedModel,
        models: &mut Vec<FittedModel>,
        is_wanted: &dyn Fn(Kind) -> bool,
    ) -> Result<Vec<FittedModel>, MechanismError> {
        let is_larger = |j: usize| {
            let square = parent.left_out.mean_square(j, parent.fit.sd[j]);
            square >= MIN_MATERIAL_ERROR_RATIO * noise_floor(self.problem, j).powi(2)
        };
        let larger: Vec<bool> = (0..self.problem.joints.len()).map(is_larger).collect();
        let may_be_material = |kind: Kind| match kind {
            Kind::Joint(_, j) => larger[j],
            _ => larger.contains(&true),
        };
        let is_wanted = |kind: Kind| may_be_material(kind) && is_wanted(kind);
        self.children_above(parent, models, &is_wanted, MIN_SCREEN_GAIN_NATS)
    }

    /// Fit all models with one more effect that may improve on a model, also those whose effect is immaterial.
    pub fn fit_further_children(
        &self,
        model: &FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<(), MechanismError> {
        self.children_above(model, models, &|_| true, MIN_SCREEN_GAIN_NATS).map(|_| ())
    }

    /// Models with one more effect that `is_wanted`, and a gain in the screen of more than `least` nats.
    pub fn children_above(
        &self,
        parent: &FittedModel,
        models: &mut Vec<FittedModel>,
        is_wanted: &dyn Fn(Kind) -> bool,
        least: f64,
    ) -> Result<Vec<FittedModel>, MechanismError> {
        let times = self.times(parent);
        let Fit { effects, slots, values, sd, .. } = &parent.fit;
        let others = QuadraticCost::of(self.problem, effects, slots, values, sd);
        let kinds: Vec<Kind> = candidates(self.problem)
            .into_iter()
            .filter(|kind| is_wanted(*kind) && self.is_offered(parent, *kind))
            .collect();
        let mut screened = on_all_cores(self.watch, |_| {
            let screen = |kind: &Kind| self.screened(parent, *kind, &times, &others);
            Ok::<_, MechanismError>(kinds.par_iter().filter_map(screen).collect::<Vec<(f64, Fit)>>())
        })?;
        screened.retain(|(gain, _)| *gain > least);
        screened.sort_by(|a, b| b.0.total_cmp(&a.0));
        screened.truncate(MAX_FITTED);
        let mut children = on_all_cores(self.watch, |_| {
            let optimum = |(_, start): &(f64, Fit)| {
                self.cross_validated(fit(
                    self.problem,
                    &start.fitted_effects(),
                    Some(start),
                    Scope::Training,
                    MAX_STEPS,
                ))
            };
            Ok::<_, MechanismError>(screened.par_iter().map(optimum).collect::<Vec<FittedModel>>())
        })?;
        children.sort_by(|a, b| b.log_evidence(&times).total_cmp(&a.log_evidence(&times)));
        models.extend(children.iter().cloned());
        Ok(children)
    }

    fn is_offered(&self, parent: &FittedModel, kind: Kind) -> bool {
        let is_new = parent.fit.effects.iter().all(|e| e.kind != kind);
        // Play and elasticity of one joint share the only compliance of its equation.
        let conflicts = |other: Kind| match (kind, other) {
            (Kind::Joint(a, j), Kind::Joint(b, k)) => j == k && a.is_compliance() && b.is_compliance(),
            _ => false,
        };
        is_new
            && !self.without.iter().any(|name| name == kind.effect())
            && !parent.fit.effects.iter().any(|e| conflicts(e.kind))
    }

    /// The gain in log evidence of the best start of a candidate after a few steps, and its values.
    pub fn screened(
        &self,
        parent: &FittedModel,
        kind: Kind,
        times: &[f64],
        others: &QuadraticCost,
    ) -> Option<(f64, Fit)> {
        let scope = match kind {
            Kind::Joint(_, joint) => Scope::Joint(joint),
            Kind::EncoderOffset(joint) if self.problem.axis.is_some() => Scope::Joint(joint),
            _ => Scope::Training,
        };
        let mut starts = kind.starts(self.problem);
        if let (Scope::Joint(_), true) = (scope, kind.params().iter().any(|p| p.is_period)) {
            let Fit { effects, slots, values, .. } = &parent.fit;
            let rows = evaluate(self.problem, effects, slots, values, scope, false);
            starts = best_periods(self.problem, &rows[0], &starts);
        }
        let samples: f64 = (0..times.len()).map(|j| parent.fit.samples[j] as f64 / times[j]).sum();
        let plays = match kind {
            Kind::Joint(JointKind::Backlash, joint) => self.best_plays(parent, joint),
            _ => vec![],
        };
        let loads = match kind {
            Kind::Payload(body) => best_point_masses(self.problem, &parent.fit, body),
            _ => vec![],
        };
        let own = starts.into_iter().map(|values| (values, Some(&parent.fit)));
        let own = own.chain(loads.iter().map(|(values, model)| (values.clone(), Some(model))));
        let all = own.chain(plays.into_iter().map(|values| (values, None)));
        let one = |(values, from): (Vec<f64>, Option<&Fit>)| {
            let mut effects = parent.fit.fitted_effects();
            effects.push(Effect { kind, values });
            let found =
                fit_with(self.problem, &effects, from, scope, SCREENING_STEPS, Freedom::Approximated(others));
            let joints: Vec<usize> = match scope {
                Scope::Joint(joint) => vec![joint],
                _ => (0..times.len()).collect(),
            };
            let own = |j: &usize| {
                parent.fit.samples[*j] as f64 / times[*j] * (parent.fit.sd[*j] / found.sd[*j]).ln()
            };
            let added = (found.slots.len() - parent.fit.slots.len()) as f64;
            let lost = match scope {
                Scope::Joint(joint) => others.cost(joint, &found.values) / times[joint],
                _ => 0.0,
            };
            let gain = joints.iter().map(own).sum::<f64>() - lost - 0.5 * added * samples.max(1.0).ln();
            (gain, found)
        };
        all.map(one).filter(|(gain, _)| gain.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Values of the plays with the smallest residuals at the given values of the mechanism. A nominal model that is refitted
    /// without a play has other inertias, with which impacts are at other times: from there, a fit does not find the play.
    fn best_plays(&self, parent: &FittedModel, joint: usize) -> Vec<Vec<f64>> {
        let size = |values: &Vec<f64>| {
            let mut effects = parent.fit.fitted_effects();
            effects.push(Effect { kind: Kind::Joint(JointKind::Backlash, joint), values: values.clone() });
            let slots = slots(self.problem, &effects);
            let start: Vec<f64> = slots.iter().map(|slot| slot.start).collect();
            let rows = evaluate(self.problem, &effects, &slots, &start, Scope::Joint(joint), false);
            robust_sd(self.problem, joint, &rows[0].residual)
        };
        let all = plays(&self.problem.joints[joint].scales).into_iter();
        let mut sized: Vec<(f64, Vec<f64>)> = all.map(|values| (size(&values), values)).collect();
        sized.sort_by(|a, b| a.0.total_cmp(&b.0));
        sized.into_iter().take(MAX_PLAYS).map(|(_, values)| values).collect()
    }
}
