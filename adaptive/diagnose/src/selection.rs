//! Selection of the model that is named, from the models that the search fitted.

use crate::block_bootstrap::{PredictedSamples, correlation_time, probability_of_gain};
use crate::cross_validation::{LeftOutPrediction, cross_validate};
use crate::definition::is_defined;
use crate::effect_report::without_effect;
use crate::eligibility::{Eligibility, INELIGIBLE};
use crate::engine::Engine;
use crate::fitted_model::{FittedModel, simpler_sets, with_kinds};
use crate::search::SearchResult;
use crate::thresholds::{MIN_EFFECT_PROBABILITY, MIN_MATERIAL_ERROR_RATIO};
use std::collections::BTreeMap;
use trundle_infer::{InferError, Watch, unscored_time};

/// Most models whose effects are checked on left-out episodes.
const MAX_CHECKED_MODELS: usize = 24;

/// Reason for not naming the best model.
pub(crate) const LARGE_RESIDUAL: &str = "its residual exceeds what noise explains";
const UNSUPPORTED: &str = "an effect does not improve the predictive density of left-out episodes";
const OUTWEIGHED: &str = "what remains unexplained exceeds what an effect explains";
const IMMATERIAL: &str = "an effect does not improve the prediction of left-out episodes by a material share";

/// The selected model.
pub(crate) struct Selection {
    /// Its index among the fitted models.
    pub best: usize,
    /// For each of its effects, the probability that left-out episodes are predicted better with it.
    pub chances: Vec<f64>,
    /// Number of models with more weight that contain an unsupported effect.
    pub rejected: usize,
    /// Immaterial effects: the model's index, the effect's index in it, and its probability.
    pub immaterial: Vec<(usize, usize, f64)>,
    /// Reasons for not naming fitted models. Models with less weight than the selected one are not tested.
    pub reasons: BTreeMap<usize, &'static str>,
}

/// Result of the tests of a model.
enum TestResult {
    /// All effects pass, with these probabilities.
    Passed(Vec<f64>),
    /// An effect is not supported, for this reason.
    Unsupported(&'static str),
    /// A simpler law suffices.
    TooRich,
    /// These effects are immaterial; the probabilities are those of all effects.
    Immaterial { effects: Vec<usize>, chances: Vec<f64> },
}

/// Inputs of the selection.
pub(crate) struct Selector<'a> {
    pub engine: &'a dyn Engine,
    pub found: &'a SearchResult,
    /// Index of the nominal model among the fitted models.
    pub base: usize,
    pub watch: &'a dyn Watch,
}

impl Selector<'_> {
    /// Select the model with the most weight whose effects all pass four tests. The data identify its
    /// defining parameters. It explains more than remains unexplained. It improves the predictive density of
    /// left-out training episodes by more than chance. It improves their prediction by a material share. If no
    /// model passes, the nominal model is selected.
    pub fn select(&self) -> Result<Selection, InferError> {
        let mut cache = BTreeMap::new();
        let mut immaterial: Vec<(usize, usize, f64)> = vec![];
        let mut reasons = BTreeMap::new();
        let mut eligibility: Option<Eligibility<'_>> = None;
        let models = &self.found.models;
        if self.found.has_large_residual {
            reasons.insert(0, LARGE_RESIDUAL);
            return Ok(Selection { best: self.base, chances: vec![], rejected: 0, immaterial, reasons });
        }
        let mut next = 0;
        while let Some(candidate) = models.get(next) {
            let index = next;
            next += 1;
            if reasons.get(&index).is_some_and(|reason| *reason != INELIGIBLE) {
                continue;
            }
            if !eligibility.as_ref().is_none_or(|eligibility| eligibility.allows(candidate)) {
                reasons.insert(index, INELIGIBLE);
                continue;
            }
            match self.tested(candidate, &mut cache)? {
                TestResult::Passed(chances) => {
                    return Ok(Selection { best: index, chances, rejected: index, immaterial, reasons });
                }
                TestResult::Unsupported(reason) => {
                    reasons.insert(index, reason);
                    // A test rejects the other effects of the best model, so that other models become eligible.
                    if let Some(ineligible) =
                        eligibility.take_if(|eligibility| eligibility.is_reduced_to(candidate))
                    {
                        next = ineligible.index + 1;
                    }
                }
                TestResult::TooRich => {
                    reasons.insert(index, "a simpler law predicts left-out episodes as well");
                }
                TestResult::Immaterial { effects, chances } => {
                    reasons.insert(index, IMMATERIAL);
                    for &k in &effects {
                        let effect = candidate.names()[k];
                        if immaterial.iter().all(|&(i, j, _)| models[i].names()[j] != effect) {
                            immaterial.push((index, k, chances[k]));
                        }
                    }
                    eligibility.get_or_insert(Eligibility { index, candidate, immaterial: effects });
                }
            }
        }
        Ok(Selection { best: self.base, chances: vec![], rejected: 0, immaterial, reasons })
    }

    /// Test a model.
    fn tested(
        &self,
        candidate: &FittedModel,
        cache: &mut BTreeMap<*const FittedModel, LeftOutPrediction>,
    ) -> Result<TestResult, InferError> {
        if cache.len() >= MAX_CHECKED_MODELS {
            return Ok(TestResult::Unsupported("not tested: too many models have more weight"));
        }
        if let Some(reason) = self.rejection_reason(candidate)? {
            return Ok(TestResult::Unsupported(reason));
        }
        let chances = self.chances(candidate, cache)?;
        if chances.iter().any(|chance| *chance < MIN_EFFECT_PROBABILITY) {
            return Ok(TestResult::Unsupported(UNSUPPORTED));
        }
        let effects = self.immaterial_effects(candidate, cache)?;
        Ok(if !effects.is_empty() {
            TestResult::Immaterial { effects, chances }
        } else if self.simpler_law_suffices(candidate, cache)? {
            TestResult::TooRich
        } else {
            TestResult::Passed(chances)
        })
    }

    /// Reason for rejecting a model without a test on left-out episodes, if any.
    fn rejection_reason(&self, candidate: &FittedModel) -> Result<Option<&'static str>, InferError> {
        Ok(if !(0..candidate.added.len()).all(|k| is_defined(candidate, k)) {
            Some("the data do not identify a parameter that defines an effect")
        } else if !self.explains_more_than_remains(candidate)? {
            Some(OUTWEIGHED)
        } else if !self.improves_training_fit(candidate)? {
            Some("an effect does not improve the fit consistently over blocks of samples")
        } else {
            None
        })
    }

    /// Whether every effect of a model gains more than the misfit that remains. Where the right laws are known only
    /// approximately, further effects gain part of what these leave.
    fn explains_more_than_remains(&self, candidate: &FittedModel) -> Result<bool, InferError> {
        let remaining = self.remaining(candidate)?;
        let gain =
            |k| without_effect(self.found, candidate, k).map(|other| other.fit.cost - candidate.fit.cost);
        Ok((0..candidate.added.len()).filter_map(gain).all(|gain| gain > remaining))
    }

    /// Misfit that a model leaves, nats; zero if wrenches are compared instead of motion.
    fn remaining(&self, candidate: &FittedModel) -> Result<f64, InferError> {
        Ok(self.engine.lack_of_fit(candidate)?.map_or(0.0, |lack| lack.misfit()))
    }

    /// Whether every effect of a model improves the density of the training episodes by more than chance.
    /// Otherwise the more expensive test on left-out episodes is not needed.
    fn improves_training_fit(&self, candidate: &FittedModel) -> Result<bool, InferError> {
        let with = self.engine.predicted(candidate, &|_| true)?;
        let time = self.correlation_time(&with);
        for k in 0..candidate.added.len() {
            let Some(simpler) = without_effect(self.found, candidate, k) else { return Ok(false) };
            if probability_of_gain(time, &with, &self.engine.predicted(simpler, &|_| true)?)
                < MIN_EFFECT_PROBABILITY
            {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Correlation time of a fitted model's residuals, samples. Samples of slow pushes are means over a
    /// second, long enough to be independent on an uneven floor.
    fn correlation_time(&self, samples: &PredictedSamples) -> f64 {
        if self.engine.is_quasi_static() { 1.0 } else { correlation_time(samples) }
    }

    /// For each effect of a model, the probability that left-out episodes are predicted better with it.
    fn chances(
        &self,
        candidate: &FittedModel,
        cache: &mut BTreeMap<*const FittedModel, LeftOutPrediction>,
    ) -> Result<Vec<f64>, InferError> {
        let time = self.correlation_time(&self.engine.predicted(candidate, &|_| true)?);
        let with = self.misfit(candidate, candidate, cache)?.samples;
        let one = |k: usize| match without_effect(self.found, candidate, k) {
            Some(simpler) => {
                Ok(probability_of_gain(time, &with, &self.misfit(simpler, candidate, cache)?.samples))
            }
            None => Ok(0.0),
        };
        (0..candidate.added.len()).map(one).collect()
    }

    /// A model's prediction of left-out episodes, for the comparison with another model.
    fn misfit(
        &self,
        fitted: &FittedModel,
        compared_with: &FittedModel,
        cache: &mut BTreeMap<*const FittedModel, LeftOutPrediction>,
    ) -> Result<LeftOutPrediction, InferError> {
        let key = std::ptr::from_ref(fitted);
        let all_judged = unscored_time(&compared_with.fit.model) == 0.0;
        if let Some(misfit) = cache.get(&key).filter(|_| all_judged) {
            return Ok(misfit.clone());
        }
        let found = cross_validate(self.engine, fitted, compared_with, self.watch)?;
        cache.insert(key, found.clone());
        Ok(found)
    }

    /// Whether a model with simpler laws in place of one effect predicts left-out episodes almost as well, or what
    /// remains unexplained exceeds the difference of the fits. The simpler laws are then named.
    fn simpler_law_suffices(
        &self,
        candidate: &FittedModel,
        cache: &mut BTreeMap<*const FittedModel, LeftOutPrediction>,
    ) -> Result<bool, InferError> {
        for kinds in simpler_sets(&candidate.added) {
            let Some(other) = with_kinds(&self.found.models, kinds) else { continue };
            if other.fit.cost - candidate.fit.cost < self.remaining(candidate)? {
                return Ok(true);
            }
            let with = self.misfit(candidate, candidate, cache)?;
            if with.error_ratio(&self.misfit(other, candidate, cache)?) < MIN_MATERIAL_ERROR_RATIO {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Indices of a model's immaterial effects. Without such an effect, left-out episodes are predicted
    /// almost as well. All are immaterial if the errors of the nominal model hardly exceed the instruments' noise.
    fn immaterial_effects(
        &self,
        candidate: &FittedModel,
        cache: &mut BTreeMap<*const FittedModel, LeftOutPrediction>,
    ) -> Result<Vec<usize>, InferError> {
        let mut misfit = |fitted: &FittedModel| self.misfit(fitted, candidate, cache);
        let with = misfit(candidate)?;
        let mut immaterial_effects = vec![];
        if !self.engine.errs_beyond_noise(&self.found.models[self.base])? {
            return Ok((0..candidate.added.len()).collect());
        }
        for k in 0..candidate.added.len() {
            let needed = match without_effect(self.found, candidate, k) {
                Some(simpler) => with.error_ratio(&misfit(simpler)?) >= MIN_MATERIAL_ERROR_RATIO,
                None => false,
            };
            if !needed {
                immaterial_effects.push(k);
            }
        }
        Ok(immaterial_effects)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{OUTWEIGHED, Selector, correlation_time, cross_validate, probability_of_gain};
    use crate::answer::Value;
    use crate::engine::Engine;
    use crate::engine::plant_engine::PlantEngine;
    use crate::fitted_model::FittedModel;
    use crate::search::SearchResult;
    use crate::{Options, diagnose};
    use std::collections::BTreeMap;
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::{Comparison, FitOptions, Quiet, fit};
    use trundle_model::{Effect, Kind, Model, State};

    /// Probability that a slope fitted to pushes of a world predicts left-out pushes better.
    fn chance_of_slope(truth: Model) -> f64 {
        let data = World::of(truth).recording(4);
        let comparison = Comparison::of(&data).unwrap();
        let engine = PlantEngine::new(&data, None).unwrap();
        let predicted = |added: Vec<Effect>| {
            let nominal = engine.nominal();
            let model =
                Model { effects: [nominal.effects.clone(), added.clone()].concat(), ..nominal.clone() };
            let fitted = fit(&comparison, &model, &[], &FitOptions::default(), &Quiet).unwrap();
            let fitted = FittedModel::new(added, fitted, None);
            cross_validate(&engine, &fitted, &fitted, &Quiet).unwrap().samples
        };
        let with = predicted(vec![Effect::free(Kind::FloorSlope)]);
        probability_of_gain(correlation_time(&with), &with, &predicted(vec![]))
    }

    #[test]
    fn a_true_effect_predicts_left_out_episodes_and_a_false_one_does_not() {
        let slope = effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]);
        assert!(chance_of_slope(locked().with(slope)) > 0.99);
        assert!(chance_of_slope(locked()) < 0.9);
    }

    #[test]
    fn a_common_gain_is_no_load_if_the_mass_is_known() {
        let mut data = World::of(locked()).recording(3);
        data.mass_given = Some(22.0);
        for sample in data.training.iter_mut().chain(&mut data.held_out).flat_map(|e| &mut e.wrench) {
            sample.reading = [0, 1, 2].map(|k| sample.reading[k] * [0.7, 1.5, 1.3][k]);
        }
        let found = diagnose(&data, &Options::default(), &Quiet).unwrap().answer;
        let names: Vec<_> = found.missing.iter().map(|m| m.effect.as_str()).collect();
        assert_eq!(names, ["force_scale"], "{:?}", found.verdict);
        let Value::Number(gain) = &found.missing[0].parameters["gain_x"] else { panic!("no number") };
        assert!((gain.mean - 0.7).abs() < 0.02, "{gain:?}");
    }

    /// Fits of sets of effects to pushes of a world with a weak force outside the catalogue, with the nominal model last.
    fn fits(truth: Effect, sets: &[&[Kind]], judge: impl Fn(&Selector<'_>)) {
        let force = |state: &State<f64>| [0.8 * (9.0 * state.pose[0]).sin(), 0.0, 0.0];
        let data = World { out_of_catalogue: force, ..World::of(locked().with(truth)) }.recording(4);
        let engine = PlantEngine::new(&data, None).unwrap();
        let base = engine.base(0, &Quiet).unwrap();
        let comparison = Comparison::of(&data).unwrap();
        let fitted = |kinds: &&[Kind]| {
            let added: Vec<Effect> = kinds.iter().map(|kind| Effect::free(*kind)).collect();
            let nominal = engine.nominal().clone();
            let model = Model { effects: [nominal.effects.clone(), added.clone()].concat(), ..nominal };
            let fit = fit(&comparison, &model, &[], &FitOptions::default(), &Quiet).unwrap();
            FittedModel::new(added, fit, None)
        };
        let located = engine.located(&base, None).unwrap();
        let models: Vec<FittedModel> = sets.iter().map(fitted).chain([base]).collect();
        let found = SearchResult { models, before: None, located, has_large_residual: false };
        judge(&Selector { engine: &engine, found: &found, base: sets.len(), watch: &Quiet });
    }

    #[test]
    fn an_effect_that_explains_less_than_remains_is_not_named() {
        let slope = effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]);
        let sets = [&[Kind::FloorSlope, Kind::QuadraticDrag][..], &[Kind::FloorSlope]];
        fits(slope, &sets, |selector| {
            let [both, one] = [0, 1].map(|k| &selector.found.models[k]);
            assert_ne!(selector.rejection_reason(one).unwrap(), Some(OUTWEIGHED));
            assert!(both.fit.cost < one.fit.cost);
            assert_eq!(selector.rejection_reason(both).unwrap(), Some(OUTWEIGHED));
        });
    }

    #[test]
    fn a_law_that_fits_better_by_less_than_remains_is_replaced_by_a_simpler_one() {
        let offset = effect(Kind::ComOffset, &[("com_x", 0.2), ("com_y", -0.1)]);
        fits(offset, &[&[Kind::SwingingLoad], &[Kind::ComOffset]], |selector| {
            let mut cache = BTreeMap::new();
            assert!(selector.simpler_law_suffices(&selector.found.models[0], &mut cache).unwrap());
            assert!(cache.is_empty(), "left-out episodes were predicted");
        });
    }
}
