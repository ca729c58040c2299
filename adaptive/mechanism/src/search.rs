//! Search for missing effects: forward selection with exchange, each effect tested on left-out parts of the training
//! episodes.

use crate::cross_validation::{LeftOut, left_out};
use crate::error::MechanismError;
use crate::fit::{Fit, MAX_STEPS, fit, fit_with};
use crate::intervals::are_defined;
use crate::laws::JointKind;
use crate::model::{Effect, Kind, Role};
use crate::others::Others;
use crate::periodogram::best_periods;
use crate::problem::Problem;
use crate::rows::{Scope, evaluate, weight};
use rayon::prelude::*;
use trundle_diagnose::{
    MIN_EFFECT_PROBABILITY, MIN_MATERIAL_ERROR_RATIO, PredictedSample, PredictedSamples, correlation_time,
    probability_of_gain,
};
use trundle_infer::{Watch, on_all_cores};

/// Steps of a fit that only ranks candidates.
const SCREENING_STEPS: usize = 5;
/// Candidates that are fitted to their optimum.
const MAX_FITTED: usize = 6;
/// Models to which a second effect is added if no single effect passes the tests.
const MAX_PARENTS: usize = 3;
/// Least gain of a candidate in the screen, nats.
const MIN_SCREEN_GAIN_NATS: f64 = 3.0;
/// Most effects for each joint. The tests decide; this only bounds the time.
const MAX_EFFECTS_PER_JOINT: usize = 4;

/// A fitted model with its predictions of left-out parts.
#[derive(Clone, Debug)]
pub(crate) struct Tried {
    pub fit: Fit,
    pub left_out: LeftOut,
}

impl Tried {
    pub fn kinds(&self) -> Vec<Kind> {
        let mut kinds: Vec<Kind> = self.fit.effects.iter().map(|e| e.kind).collect();
        kinds.sort();
        kinds
    }

    /// Log evidence by the Bayesian information criterion (Schwarz 1978); `time` as in [`Fit::cost`].
    pub fn log_evidence(&self, time: &[f64]) -> f64 {
        let samples: f64 = (0..time.len()).map(|j| self.fit.samples[j] as f64 / time[j]).sum();
        -self.fit.cost(time) - 0.5 * self.fit.slots.len() as f64 * samples.max(1.0).ln()
    }
}

/// What the tests of an effect found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Support {
    /// Probability that the effect improves the prediction of left-out parts.
    pub probability: f64,
    /// Ratio of the squared errors without and with it.
    pub error_ratio: f64,
}

impl Support {
    pub fn is_certain(self) -> bool {
        self.probability >= MIN_EFFECT_PROBABILITY
    }

    pub fn is_material(self) -> bool {
        self.error_ratio >= MIN_MATERIAL_ERROR_RATIO
    }

    pub fn passes(self) -> bool {
        self.is_certain() && self.is_material()
    }
}

/// Result of the search.
pub(crate) struct Found {
    pub base: Tried,
    pub best: Tried,
    /// Support of each effect of the best model.
    pub support: Vec<Support>,
    /// All models that were fitted to their optimum.
    pub tried: Vec<Tried>,
}

pub(crate) struct Searcher<'a> {
    pub problem: &'a Problem,
    pub without: &'a [String],
    pub watch: &'a dyn Watch,
}

impl Searcher<'_> {
    /// Run the search.
    pub fn run(&self) -> Result<Found, MechanismError> {
        self.watch.progress("the mechanism under test", 0.0);
        let base = self.tried(fit(self.problem, &[], None, Scope::Training, MAX_STEPS));
        let mut tried = vec![base.clone()];
        let mut best = base.clone();
        let limit = MAX_EFFECTS_PER_JOINT * self.problem.joints.len();
        while best.fit.effects.len() < limit {
            self.watch.progress("missing effects", best.fit.effects.len() as f64 / limit as f64);
            let next = self.extended(&best, &mut tried)?;
            let Some(next) = next else { break };
            best = self.exchanged(next, &mut tried)?;
        }
        best = self.refined(best, &mut tried)?;
        best = self.reduced(best, &mut tried)?;
        let support = self.support_of_all(&best, &mut tried);
        Ok(Found { base, best, support, tried })
    }

    /// A model with given effects, fitted to its optimum. Values are further starting points.
    ///
    /// # Errors
    /// With the effect that cannot be fitted.
    pub fn with_effects(&self, effects: &[(Kind, Option<Vec<f64>>)]) -> Result<Tried, Kind> {
        let mut model = self.tried(fit(self.problem, &[], None, Scope::Training, MAX_STEPS));
        for (kind, values) in effects {
            let times = self.times(&model);
            let Fit { effects, slots, values: fitted, sd, .. } = &model.fit;
            let others = Others::of(self.problem, effects, slots, fitted, sd);
            let screened = self.screened(&model, *kind, &times, &others).map(|(_, start)| start);
            let given = values.clone().map(|values| {
                let all = [model.fit.fitted_effects(), vec![Effect { kind: *kind, values }]].concat();
                fit(self.problem, &all, Some(&model.fit), Scope::Training, 0)
            });
            let optimum = |start: Fit| {
                fit(self.problem, &start.fitted_effects(), Some(&start), Scope::Training, MAX_STEPS)
            };
            let best =
                screened.into_iter().chain(given).map(optimum).filter(|fit| fit.cost(&times).is_finite());
            let best = best.min_by(|a, b| a.cost(&times).total_cmp(&b.cost(&times)));
            model = self.tried(best.ok_or(*kind)?);
        }
        Ok(model)
    }

    fn tried(&self, fit: Fit) -> Tried {
        let left_out = left_out(self.problem, &fit);
        Tried { fit, left_out }
    }

    /// Correlation time of each joint's left-out residuals, samples.
    pub fn times(&self, model: &Tried) -> Vec<f64> {
        let time = |residuals: &Vec<Vec<f64>>| {
            let sample = |r: &f64| PredictedSample { cost: 0.0, residual: [*r, 0.0, 0.0] };
            let all: PredictedSamples =
                residuals.iter().map(|fold| fold.iter().map(sample).collect()).collect();
            correlation_time(&all).max(1.0)
        };
        model.left_out.residuals.iter().map(time).collect()
    }

    /// The best model with one more effect that passes the tests, or with two more of which each does.
    fn extended(&self, parent: &Tried, tried: &mut Vec<Tried>) -> Result<Option<Tried>, MechanismError> {
        let children = self.children(parent, tried)?;
        let mut passing = vec![];
        for child in &children {
            if self.support(parent, child).passes() && self.all_pass(child, tried) {
                passing.push(child.clone());
            }
        }
        if let Some(first) = passing.first() {
            let times = self.times(first);
            passing.sort_by(|a, b| b.log_evidence(&times).total_cmp(&a.log_evidence(&times)));
            return Ok(passing.into_iter().next());
        }
        for child in children.iter().take(MAX_PARENTS) {
            for grandchild in self.children(child, tried)? {
                if self.support(child, &grandchild).passes() && self.all_pass(&grandchild, tried) {
                    return Ok(Some(grandchild));
                }
            }
        }
        Ok(None)
    }

    /// Models with one more effect, fitted to their optimum, the best first.
    fn children(&self, parent: &Tried, tried: &mut Vec<Tried>) -> Result<Vec<Tried>, MechanismError> {
        let times = self.times(parent);
        let Fit { effects, slots, values, sd, .. } = &parent.fit;
        let others = Others::of(self.problem, effects, slots, values, sd);
        let kinds: Vec<Kind> = Kind::candidates(self.problem)
            .into_iter()
            .filter(|kind| self.is_offered(parent, *kind))
            .collect();
        let mut screened = on_all_cores(self.watch, |_| {
            let screen = |kind: &Kind| self.screened(parent, *kind, &times, &others);
            Ok::<_, MechanismError>(kinds.par_iter().filter_map(screen).collect::<Vec<(f64, Fit)>>())
        })?;
        screened.retain(|(gain, _)| *gain > MIN_SCREEN_GAIN_NATS);
        screened.sort_by(|a, b| b.0.total_cmp(&a.0));
        screened.truncate(MAX_FITTED);
        let mut children = on_all_cores(self.watch, |_| {
            let optimum = |(_, start): &(f64, Fit)| {
                self.tried(fit(
                    self.problem,
                    &start.fitted_effects(),
                    Some(start),
                    Scope::Training,
                    MAX_STEPS,
                ))
            };
            Ok::<_, MechanismError>(screened.par_iter().map(optimum).collect::<Vec<Tried>>())
        })?;
        children.sort_by(|a, b| b.log_evidence(&times).total_cmp(&a.log_evidence(&times)));
        tried.extend(children.iter().cloned());
        Ok(children)
    }

    fn is_offered(&self, parent: &Tried, kind: Kind) -> bool {
        let is_new = parent.fit.effects.iter().all(|e| e.kind != kind);
        // Play and elasticity of one joint share the only compliance of its equation.
        let conflicts = |other: Kind| match (kind, other) {
            (Kind::Joint(a, j), Kind::Joint(b, k)) => j == k && is_compliance(a) && is_compliance(b),
            _ => false,
        };
        is_new
            && !self.without.iter().any(|name| name == kind.effect())
            && !parent.fit.effects.iter().any(|e| conflicts(e.kind))
    }

    /// The gain in log evidence of the best start of a candidate after a few steps, and its values.
    fn screened(&self, parent: &Tried, kind: Kind, times: &[f64], others: &Others) -> Option<(f64, Fit)> {
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
        let one = |values: Vec<f64>| {
            let mut effects = parent.fit.fitted_effects();
            effects.push(Effect { kind, values });
            let found =
                fit_with(self.problem, &effects, Some(&parent.fit), scope, SCREENING_STEPS, Some(others));
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
        starts.into_iter().map(one).filter(|(gain, _)| gain.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Support for what `fuller` has in addition to `simpler`.
    pub fn support(&self, simpler: &Tried, fuller: &Tried) -> Support {
        let times = self.times(fuller);
        let joints = self.affected(simpler, fuller);
        let (mut with, mut without): (PredictedSamples, PredictedSamples) = (vec![], vec![]);
        let mut time: f64 = 1.0;
        let mut ratio: f64 = 1.0;
        for j in joints {
            let sd =
                |tried: &Tried| tried.left_out.mean_square(j, tried.fit.sd[j]).sqrt().max(tried.fit.sd[j]);
            let predicted = |tried: &Tried| -> PredictedSamples {
                let sd = sd(tried);
                let cost = |r: f64| sd.ln() + 0.5 * (r / sd).powi(2) * weight(r, sd);
                let one = |r: &f64| PredictedSample { cost: cost(*r), residual: [r / sd, 0.0, 0.0] };
                tried.left_out.residuals[j].iter().map(|fold| fold.iter().map(one).collect()).collect()
            };
            with.extend(predicted(fuller));
            without.extend(predicted(simpler));
            time = time.max(times[j]);
            ratio = ratio.max((sd(simpler) / sd(fuller)).powi(2));
        }
        Support { probability: probability_of_gain(time, &with, &without), error_ratio: ratio }
    }

    /// Joints whose equations the difference of two models enters. Parameters of all joints change a little with every
    /// effect; that is no evidence about it.
    fn affected(&self, simpler: &Tried, fuller: &Tried) -> Vec<usize> {
        let (own, other) = (simpler.kinds(), fuller.kinds());
        let difference =
            other.iter().filter(|k| !own.contains(k)).chain(own.iter().filter(|k| !other.contains(k)));
        let single = |kind: &Kind| match kind {
            Kind::Joint(_, joint) => Some(*joint),
            Kind::EncoderOffset(joint) if self.problem.axis.is_some() => Some(*joint),
            _ => None,
        };
        let joints: Option<Vec<usize>> = difference.map(single).collect();
        // Refinements change values only.
        let all = || (0..self.problem.joints.len()).collect();
        let found = joints.filter(|joints| !joints.is_empty()).unwrap_or_else(all);
        found.into_iter().filter(|j| fuller.fit.samples[*j] > 0).collect()
    }

    /// A model without one of its effects, fitted to its optimum.
    pub fn without_effect(&self, model: &Tried, index: usize, tried: &mut Vec<Tried>) -> Tried {
        let mut effects = model.fit.fitted_effects();
        effects.remove(index);
        let mut kinds: Vec<Kind> = effects.iter().map(|e| e.kind).collect();
        kinds.sort();
        let has_same_shape = |t: &&Tried| t.kinds() == kinds && t.fit.slots.len() < model.fit.slots.len();
        if let Some(known) = tried.iter().find(has_same_shape) {
            return known.clone();
        }
        let mut from = model.fit.clone();
        from.slots.iter_mut().for_each(|slot| {
            // Indices of the effects behind the removed one change.
            if let Role::Effect(k, param) = slot.role
                && k > index
            {
                slot.role = Role::Effect(k - 1, param);
            }
        });
        let found = self.tried(fit(self.problem, &effects, Some(&from), Scope::Training, MAX_STEPS));
        tried.push(found.clone());
        found
    }

    pub fn support_of_all(&self, model: &Tried, tried: &mut Vec<Tried>) -> Vec<Support> {
        (0..model.fit.effects.len())
            .map(|k| self.support(&self.without_effect(model, k, tried), model))
            .collect()
    }

    /// Models that the data support: the nominal one, and those whose effects all pass the tests. Models with less evidence
    /// than `bound` are not tested.
    pub fn supported(&self, tried: &mut Vec<Tried>, times: &[f64], bound: f64) -> Vec<Tried> {
        let all = tried.clone();
        let keeps = |model: &&Tried| model.log_evidence(times) < bound || self.all_pass(model, tried);
        all.iter().filter(keeps).cloned().collect()
    }

    fn all_pass(&self, model: &Tried, tried: &mut Vec<Tried>) -> bool {
        are_defined(self.problem, &model.fit, &self.times(model))
            && self.support_of_all(model, tried).iter().all(|support| support.passes())
    }

    /// The model in which no exchange of one effect for another increases the evidence.
    fn exchanged(&self, mut model: Tried, tried: &mut Vec<Tried>) -> Result<Tried, MechanismError> {
        let count = model.fit.effects.len();
        if count < 2 {
            return Ok(model);
        }
        for index in 0..count {
            let reduced = self.without_effect(&model, index, tried);
            let times = self.times(&model);
            for child in self.children(&reduced, tried)? {
                if child.log_evidence(&times) > model.log_evidence(&times) + 1.0
                    && self.all_pass(&child, tried)
                {
                    model = child;
                    break;
                }
            }
        }
        Ok(model)
    }

    /// The model with refinements of its laws that improve the prediction.
    fn refined(&self, mut model: Tried, tried: &mut Vec<Tried>) -> Result<Tried, MechanismError> {
        for index in 0..model.fit.effects.len() {
            self.watch.progress("refinements", index as f64 / model.fit.effects.len() as f64);
            let mut effects = model.fit.fitted_effects();
            let Some(values) = refinement(self.problem, &effects[index]) else { continue };
            effects[index].values = values;
            let finer = self.tried(fit(self.problem, &effects, Some(&model.fit), Scope::Training, MAX_STEPS));
            let times = self.times(&model);
            if self.support(&model, &finer).is_certain()
                && finer.log_evidence(&times) > model.log_evidence(&times)
            {
                tried.push(finer.clone());
                model = finer;
            }
        }
        Ok(model)
    }

    /// The model without effects that do not pass the tests any more.
    fn reduced(&self, mut model: Tried, tried: &mut Vec<Tried>) -> Result<Tried, MechanismError> {
        loop {
            let support = self.support_of_all(&model, tried);
            let worst = (0..support.len())
                .filter(|k| !support[*k].passes())
                .min_by(|a, b| support[*a].error_ratio.total_cmp(&support[*b].error_ratio));
            match worst {
                Some(k) => model = self.without_effect(&model, k, tried),
                None => return Ok(model),
            }
        }
    }
}

fn is_compliance(kind: JointKind) -> bool {
    matches!(kind, JointKind::Backlash | JointKind::Elasticity)
}

/// Values with the refinements of an effect at starting values; `None` if it has none or they are free.
fn refinement(problem: &Problem, effect: &Effect) -> Option<Vec<f64>> {
    let (Kind::Joint(_, j), params) = (effect.kind, effect.kind.params()) else { return None };
    let free = |k: usize| params[k].refines && effect.values[k].is_nan();
    if !(0..params.len()).any(free) {
        return None;
    }
    let size = effect.values.iter().copied().find(|v| !v.is_nan()).unwrap_or(0.0);
    let scales = &problem.joints[j].scales;
    let one = |k: usize| match (free(k), params[k].scale) {
        (false, _) => effect.values[k],
        (true, crate::laws::Scale::Effort) => 1.5 * size,
        (true, scale) => 0.1 * scale.of(scales),
    };
    Some((0..params.len()).map(one).collect())
}
