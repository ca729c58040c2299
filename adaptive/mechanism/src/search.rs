//! Search for missing effects: forward selection with exchange, each effect tested on left-out parts of the training
//! episodes.

use crate::candidates::candidates;
use crate::child_cache::ChildCache;
use crate::coupling::Coupling;
use crate::cross_validation::left_out;
use crate::error::MechanismError;
use crate::error_metrics::error_metrics;
use crate::fit::{Fit, MAX_STEPS, fit};
use crate::fitted_model::{FittedModel, SearchResult, Support};
use crate::intervals::are_defined;
use crate::lack_of_fit::{exceeds_noise, lack_of_fit, may_be_noise};
use crate::model::{Effect, Kind};
use crate::problem::Problem;
use crate::quadratic_cost::QuadraticCost;
use crate::rows::{Scope, noise_floor, weight};
use rayon::prelude::*;
use std::collections::BTreeSet;
use trundle_diagnose::{
    MIN_MATERIAL_ERROR_RATIO, PredictedSample, PredictedSamples, correlation_time, probability_of_gain,
};
use trundle_infer::{Watch, on_all_cores};

/// Steps of a fit that only ranks candidates.
pub(crate) const SCREENING_STEPS: usize = 5;
/// Models to which a second effect is added if no single effect passes the tests.
const MAX_PARENTS: usize = 3;
/// Most effects for each joint. The tests decide; this only bounds the time.
const MAX_EFFECTS_PER_JOINT: usize = 4;

pub(crate) struct Searcher<'a> {
    pub problem: &'a Problem,
    pub without: &'a [String],
    pub watch: &'a dyn Watch,
    pub child_cache: ChildCache,
    pub coupling: Coupling,
}

impl<'a> Searcher<'a> {
    pub fn new(problem: &'a Problem, without: &'a [String], watch: &'a dyn Watch) -> Self {
        Self { problem, without, watch, child_cache: ChildCache::default(), coupling: Coupling::of(problem) }
    }

    /// Run the search.
    pub fn run(&self) -> Result<SearchResult, MechanismError> {
        self.watch.progress("the mechanism under test", 0.0);
        let base = self.cross_validated(fit(self.problem, &[], None, Scope::Training, MAX_STEPS));
        self.forward_selection(base.clone(), base.clone(), vec![base])
    }

    /// Continue a search whose problem has changed a little: all its models are fitted again.
    pub fn continue_from(&self, before: &SearchResult) -> Result<SearchResult, MechanismError> {
        let refitted = |steps: usize| {
            move |old: &FittedModel| {
                self.cross_validated(fit(
                    self.problem,
                    &old.fit.fitted_effects(),
                    Some(&old.fit),
                    Scope::Training,
                    steps,
                ))
            }
        };
        let models = on_all_cores(self.watch, |_| {
            Ok::<_, MechanismError>(
                before.models.par_iter().map(refitted(SCREENING_STEPS)).collect::<Vec<FittedModel>>(),
            )
        })?;
        self.forward_selection(refitted(MAX_STEPS)(&before.base), refitted(MAX_STEPS)(&before.best), models)
    }

    fn forward_selection(
        &self,
        base: FittedModel,
        mut best: FittedModel,
        mut models: Vec<FittedModel>,
    ) -> Result<SearchResult, MechanismError> {
        let limit = MAX_EFFECTS_PER_JOINT * self.problem.joints.len();
        while best.fit.effects.len() < limit {
            self.watch.progress("missing effects", best.fit.effects.len() as f64 / limit as f64);
            let next = self.extended(&best, &mut models)?;
            let Some(next) = next else { break };
            best = self.exchanged(next, &mut models)?;
            // Another effect must not make up for a law that is too simple.
            best = self.refined(best, &mut models)?;
        }
        best = self.simplified(best, &mut models)?;
        best = self.with_best_gains(best, &mut models)?;
        let support = self.support_of_all(&best, &mut models);
        Ok(SearchResult { base, best, support, models })
    }

    /// The selected model without effects that others replace or that do not pass the tests any more.
    fn simplified(
        &self,
        selected: FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<FittedModel, MechanismError> {
        let kinds = selected.kinds();
        let mut best = self.merged(selected, models)?;
        best = self.refined(best, models)?;
        best = self.reduced(best, models)?;
        // The alternatives to the effects of another set have not been fitted yet.
        if best.kinds() == kinds { Ok(best) } else { self.exchanged(best, models) }
    }

    /// A model with given effects, fitted to its optimum. Values are further starting points.
    ///
    /// # Errors
    /// With the effect that cannot be fitted.
    pub fn with_effects(&self, effects: &[(Kind, Option<Vec<f64>>)]) -> Result<FittedModel, Kind> {
        let mut model = self.cross_validated(fit(self.problem, &[], None, Scope::Training, MAX_STEPS));
        for (kind, values) in effects {
            let times = self.times(&model);
            let Fit { effects, slots, values: fitted, sd, .. } = &model.fit;
            let others = QuadraticCost::of(self.problem, effects, slots, fitted, sd);
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
            model = self.cross_validated(best.ok_or(*kind)?);
        }
        Ok(model)
    }

    pub fn cross_validated(&self, fit: Fit) -> FittedModel {
        let left_out = left_out(self.problem, &fit);
        let (offered, count) = (candidates(self.problem).len(), fit.effects.len());
        // Sets of a number of effects are equally probable.
        let log_prior = (0..count).map(|k| ((k + 1) as f64 / (offered - k) as f64).ln()).sum();
        FittedModel { fit, left_out, log_prior }
    }

    /// Correlation time of each joint's left-out residuals, samples.
    pub fn times(&self, model: &FittedModel) -> Vec<f64> {
        let time = |residuals: &Vec<Vec<f64>>| {
            let sample = |r: &f64| PredictedSample { cost: 0.0, residual: [*r, 0.0, 0.0] };
            let all: PredictedSamples =
                residuals.iter().map(|fold| fold.iter().map(sample).collect()).collect();
            correlation_time(&all).max(1.0)
        };
        model.left_out.residuals.iter().map(time).collect()
    }

    /// The best model with one more effect that passes the tests, or with two more of which each does.
    fn extended(
        &self,
        parent: &FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<Option<FittedModel>, MechanismError> {
        let children = self.children(parent, models)?;
        let mut passing = vec![];
        for child in &children {
            if self.improves(parent, child) && self.all_pass(child, models) {
                passing.push(child.clone());
            }
        }
        if let Some(first) = passing.first() {
            let times = self.times(first);
            passing.sort_by(|a, b| b.log_evidence(&times).total_cmp(&a.log_evidence(&times)));
            return Ok(passing.into_iter().next());
        }
        for child in children.iter().take(MAX_PARENTS).chain(&self.masked(parent, &children, models)?) {
            for grandchild in self.children(child, models)? {
                if self.improves(child, &grandchild) && self.all_pass(&grandchild, models) {
                    return Ok(Some(grandchild));
                }
            }
        }
        Ok(None)
    }

    /// The best models with one more effect at a joint with a lack of fit, also if none of them improves on the parent: one of two
    /// effects alone may leave a residual that is as correlated in time.
    fn masked(
        &self,
        parent: &FittedModel,
        known: &[FittedModel],
        models: &mut Vec<FittedModel>,
    ) -> Result<Vec<FittedModel>, MechanismError> {
        let exceeds_noise = |j: &usize| lack_of_fit(self.problem, parent, *j).exceeds_noise;
        let misfitting: Vec<usize> = (0..self.problem.joints.len()).filter(exceeds_noise).collect();
        if misfitting.is_empty() {
            return Ok(vec![]);
        }
        let is_known =
            |kind: Kind| known.iter().take(MAX_PARENTS).any(|fitted| fitted.kinds().contains(&kind));
        let is_wanted = |kind: Kind| kind.joint().is_some_and(|j| misfitting.contains(&j)) && !is_known(kind);
        let mut found = self.children_above(parent, models, &is_wanted, f64::NEG_INFINITY)?;
        found.truncate(MAX_PARENTS);
        Ok(found)
    }

    /// Whether what `fuller` has in addition passes the tests, and the evidence for it is larger.
    fn improves(&self, simpler: &FittedModel, fuller: &FittedModel) -> bool {
        let times = self.times(fuller);
        fuller.log_evidence(&times) > simpler.log_evidence(&times)
            && self.support(simpler, fuller).passes()
            && self.predicts(simpler, fuller)
    }

    /// Whether the simulated motion of an axis is no worse, where it can be simulated. Where no inertia is given, effects
    /// can balance each other's efforts without any motion.
    pub fn predicts(&self, simpler: &FittedModel, fuller: &FittedModel) -> bool {
        let error =
            |fitted: &FittedModel| error_metrics(self.problem, &fitted.fit, false)?.relative_window_rmse;
        match (error(simpler), error(fuller)) {
            (Some(before), Some(after)) => after * after <= MIN_MATERIAL_ERROR_RATIO * before * before,
            _ => true,
        }
    }

    /// Support for what `fuller` has in addition to `simpler`.
    pub fn support(&self, simpler: &FittedModel, fuller: &FittedModel) -> Support {
        let times = self.times(fuller);
        let joints = self.affected(simpler, fuller);
        let (mut with, mut without): (PredictedSamples, PredictedSamples) = (vec![], vec![]);
        let mut time: f64 = 1.0;
        let mut ratio: f64 = 1.0;
        let mut may_be_noise = true;
        for j in joints {
            let sd = |fitted: &FittedModel| {
                fitted.left_out.mean_square(j, fitted.fit.sd[j]).sqrt().max(fitted.fit.sd[j])
            };
            let predicted = |fitted: &FittedModel| -> PredictedSamples {
                let sd = sd(fitted);
                let cost = |r: f64| sd.ln() + 0.5 * (r / sd).powi(2) * weight(r, sd);
                let one = |r: &f64| PredictedSample { cost: cost(*r), residual: [r / sd, 0.0, 0.0] };
                fitted.left_out.residuals[j].iter().map(|fold| fold.iter().map(one).collect()).collect()
            };
            with.extend(predicted(fuller));
            without.extend(predicted(simpler));
            time = time.max(times[j]);
            let sds = [sd(simpler), sd(fuller)];
            ratio = ratio.max((sds[0] / sds[1]).powi(2));
            may_be_noise &= self::may_be_noise(sds, noise_floor(self.problem, j));
        }
        Support { probability: probability_of_gain(time, &with, &without), error_ratio: ratio, may_be_noise }
    }

    /// Joints whose equations the difference of two models enters. Parameters of all joints change a little with every
    /// effect; that is no evidence about it. A gain enters the equations of the joints that move the same free masses.
    pub fn affected(&self, simpler: &FittedModel, fuller: &FittedModel) -> Vec<usize> {
        let (own, other) = (simpler.kinds(), fuller.kinds());
        let difference =
            other.iter().filter(|k| !own.contains(k)).chain(own.iter().filter(|k| !other.contains(k)));
        let own = |kind: &Kind| match kind {
            Kind::EncoderOffset(_) if self.problem.axis.is_none() => None,
            _ => self.coupling.acts_on(*kind),
        };
        let joints: Option<Vec<Vec<usize>>> = difference.map(own).collect();
        // Refinements change values only.
        let all = || vec![(0..self.problem.joints.len()).collect()];
        let found = joints.filter(|joints| !joints.is_empty()).unwrap_or_else(all);
        let found: BTreeSet<usize> = found.into_iter().flatten().collect();
        found.into_iter().filter(|j| fuller.fit.samples[*j] > 0).collect()
    }

    pub fn support_of_all(&self, model: &FittedModel, models: &mut Vec<FittedModel>) -> Vec<Support> {
        (0..model.fit.effects.len())
            .map(|k| self.support(&self.without_effect(model, k, models), model))
            .collect()
    }

    /// Models that the data support: the nominal one, and those whose effects all pass the tests. Models with less evidence
    /// than `bound` are not tested, unless they are as wrong as the best one.
    pub fn supported(
        &self,
        best: &FittedModel,
        models: &mut Vec<FittedModel>,
        times: &[f64],
        bound: f64,
    ) -> Vec<FittedModel> {
        let all = models.clone();
        let competes =
            |model: &FittedModel| model.log_evidence(times) >= bound || self.is_as_wrong(best, model);
        all.iter().filter(|model| !competes(model) || self.all_pass(model, models)).cloned().collect()
    }

    /// Whether a model with as many other effects predicts left-out parts about as badly as the best one: the errors of the best
    /// one exceed the noise, and those of the other are not larger by a material share. The likelihood of such models tells how
    /// well a wrong law imitates the residual, and nothing about the cause.
    pub fn is_as_wrong(&self, best: &FittedModel, other: &FittedModel) -> bool {
        let square = |fitted: &FittedModel, j: usize| fitted.left_out.mean_square(j, fitted.fit.sd[j]);
        let are_alike = |&j: &usize| {
            exceeds_noise(square(best, j).sqrt(), noise_floor(self.problem, j))
                && square(other, j) < MIN_MATERIAL_ERROR_RATIO * square(best, j)
        };
        other.fit.effects.len() == best.fit.effects.len()
            && other.kinds() != best.kinds()
            && self.affected(other, best).iter().all(are_alike)
    }

    pub fn all_pass(&self, model: &FittedModel, models: &mut Vec<FittedModel>) -> bool {
        are_defined(self.problem, &model.fit, &self.times(model))
            && self.support_of_all(model, models).iter().all(|support| support.passes())
    }
}

#[cfg(test)]
mod tests {
    use super::Searcher;
    use crate::fit::{MAX_STEPS, fit};
    use crate::laws::JointKind;
    use crate::model::{Effect, Kind};
    use crate::rows::{Scope, tests::carriage};
    use trundle_infer::Quiet;

    #[test]
    fn alternatives_are_fitted_to_a_set_from_which_an_effect_was_dropped() {
        // Dry friction, an offset of the effort, and noise.
        let problem = carriage(
            "joint",
            Some(|t| {
                let v = 0.6 * (3.0 * t).cos() - 0.4 * (8.0 * t).sin();
                let a = -1.8 * (3.0 * t).sin() - 3.2 * (8.0 * t).cos();
                2.4 * a + 1.5 * v.signum() + 1.0 + 0.02 * (1e5 * t * t).sin()
            }),
        );
        let searcher = Searcher::new(&problem, &[], &Quiet);
        let set = |kinds: &[JointKind]| -> Vec<Kind> { kinds.iter().map(|&k| Kind::Joint(k, 0)).collect() };
        let effects: Vec<Effect> =
            set(&[JointKind::DryFriction, JointKind::EffortBias, JointKind::ViscousFriction])
                .into_iter()
                .map(|kind| Effect { kind, values: vec![0.1; kind.spec().params.len()] })
                .collect();
        let selected = searcher.cross_validated(fit(&problem, &effects, None, Scope::Training, MAX_STEPS));
        let mut models = vec![selected.clone()];
        let best = searcher.simplified(selected, &mut models).unwrap();
        assert_eq!(best.kinds().len(), 2);
        for other in [JointKind::EffortBias, JointKind::DirectionalFriction] {
            let mut wanted = set(&[JointKind::DryFriction, other]);
            wanted.sort();
            assert!(models.iter().any(|fitted| fitted.kinds() == wanted), "{wanted:?}");
        }
    }
}
