//! Selection of the model that is named, from the models that the search fitted.

use crate::block_bootstrap::{PredictedSamples, correlation_time, probability_of_gain};
use crate::cross_validation::{LeftOutPrediction, cross_validate};
use crate::effect_report::without_effect;
use crate::eligibility::{Eligibility, INELIGIBLE};
use crate::engine::Engine;
use crate::fitted_model::{FittedModel, simpler_sets, with_kinds};
use crate::search::SearchResult;
use crate::thresholds::{MIN_EFFECT_PROBABILITY, MIN_MATERIAL_ERROR_RATIO};
use nalgebra::DMatrix;
use std::collections::BTreeMap;
use trundle_infer::{Fit, IDENTIFIED_SD, InferError, Watch, unscored_time};
use trundle_model::Param;

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
        } else if !self.improves_training_fit(candidate)? {
            Some("an effect does not improve the fit consistently over blocks of samples")
        } else if !self.explains_more_than_remains(candidate)? {
            Some(OUTWEIGHED)
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
        let remaining = self.remaining(candidate)?;
        for kinds in simpler_sets(&candidate.added) {
            let Some(other) = with_kinds(&self.found.models, kinds) else { continue };
            if other.fit.cost - candidate.fit.cost < remaining {
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

/// Whether the data identify the parameters that define an effect: every essential parameter except for
/// places and directions, and at least one of the alternatives of which any defines it, or a combination of these. For
/// example, a swinging load with an unknown frequency is equivalent to an offset mass. The offsets of a tracked frame
/// may each be uncertain only because the place of the wheel is.
fn is_defined(candidate: &FittedModel, k: usize) -> bool {
    let names = candidate.fit.model.effect_names();
    let name = &names[names.len() - candidate.added.len() + k];
    let spec = candidate.added[k].kind.spec();
    let full_name = |p: &Param| format!("{name}.{}", p.name);
    let identified = |p: &Param| candidate.fit.estimate(&full_name(p)).map(|e| e.identified);
    let essential = |p: &&Param| {
        p.refinement.is_none() && !p.role.is_choice() && !p.scales_face_pressure && !p.role.is_place()
    };
    let of = |any: bool| spec.params.iter().filter(essential).filter(move |p| p.is_alternative == any);
    let any: Vec<bool> = of(true).filter_map(identified).collect();
    let alternatives: Vec<String> = of(true).map(full_name).collect();
    of(false).filter_map(identified).all(|known| known)
        && (any.is_empty() || any.contains(&true) || determines_a_combination(&candidate.fit, &alternatives))
}

/// Whether the posterior determines a combination of several parameters.
fn determines_a_combination(fit: &Fit, parameters: &[String]) -> bool {
    let at = |name: &String| fit.slots.iter().position(|slot| slot.name == *name);
    let places: Vec<usize> = parameters.iter().filter_map(at).collect();
    if places.len() < 2 {
        return false;
    }
    let covariance = DMatrix::from_fn(places.len(), places.len(), |i, j| fit.spread[(places[i], places[j])]);
    covariance.symmetric_eigenvalues().min() < IDENTIFIED_SD * IDENTIFIED_SD
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{Selector, correlation_time, cross_validate, is_defined, probability_of_gain};
    use crate::answer::Value;
    use crate::engine::Engine;
    use crate::engine::plant_engine::PlantEngine;
    use crate::fitted_model::FittedModel;
    use crate::search::SearchResult;
    use crate::{Options, diagnose};
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

    #[test]
    fn an_effect_that_explains_less_than_remains_is_not_named() {
        let force = |state: &State<f64>| [0.8 * (9.0 * state.pose[0]).sin(), 0.0, 0.0];
        let slope = effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]);
        let data = World { out_of_catalogue: force, ..World::of(locked().with(slope)) }.recording(4);
        let engine = PlantEngine::new(&data, None).unwrap();
        let base = engine.base(0, &Quiet).unwrap();
        let comparison = Comparison::of(&data).unwrap();
        let fitted = |kinds: &[Kind]| {
            let added: Vec<Effect> = kinds.iter().map(|kind| Effect::free(*kind)).collect();
            let nominal = engine.nominal().clone();
            let model = Model { effects: [nominal.effects.clone(), added.clone()].concat(), ..nominal };
            FittedModel::new(
                added,
                fit(&comparison, &model, &[], &FitOptions::default(), &Quiet).unwrap(),
                None,
            )
        };
        let (one, both) = (fitted(&[Kind::FloorSlope]), fitted(&[Kind::FloorSlope, Kind::QuadraticDrag]));
        let models = vec![both.clone(), one.clone(), base];
        let located = engine.located(&models[2], None).unwrap();
        let found = SearchResult { models, before: None, located, has_large_residual: false };
        let selector = Selector { engine: &engine, found: &found, base: 2, watch: &Quiet };
        assert!(selector.explains_more_than_remains(&one).unwrap());
        assert!(both.fit.cost < one.fit.cost && !selector.explains_more_than_remains(&both).unwrap());
    }

    /// A fit with one effect, of whose parameters only `known` are identified.
    fn fit_with_identified(kind: Kind, known: &[&str]) -> FittedModel {
        let data = World::of(locked()).recording(4);
        let added = vec![Effect::free(kind)];
        let nominal = PlantEngine::new(&data, None).unwrap().nominal().clone();
        let model = Model { effects: [nominal.effects.clone(), added.clone()].concat(), ..nominal };
        let options = FitOptions { starts: 1, ..FitOptions::default() };
        let mut fitted = fit(&Comparison::of(&data).unwrap(), &model, &[], &options, &Quiet).unwrap();
        for (index, estimate) in fitted.estimates.iter_mut().enumerate() {
            estimate.identified = known.iter().any(|key| estimate.name.ends_with(&format!(".{key}")));
            if !estimate.identified {
                fitted.spread.row_mut(index).fill(0.0);
                fitted.spread.column_mut(index).fill(0.0);
                fitted.spread[(index, index)] = 1.0;
            }
        }
        FittedModel::new(added, fitted, None)
    }

    #[test]
    fn one_identified_limit_defines_a_saturation() {
        assert!(is_defined(&fit_with_identified(Kind::Saturation, &["limit_torque"]), 0));
        assert!(!is_defined(&fit_with_identified(Kind::Saturation, &[]), 0));
    }

    #[test]
    fn the_gain_of_one_axis_defines_a_scale_error() {
        assert!(is_defined(&fit_with_identified(Kind::ForceScale, &["gain_y"]), 0));
        assert!(!is_defined(&fit_with_identified(Kind::ForceScale, &[]), 0));
    }

    #[test]
    fn a_combination_of_gains_defines_a_scale_error() {
        let mut fitted = fit_with_identified(Kind::ForceScale, &[]);
        let at = |key: &str| fitted.fit.slots.iter().position(|slot| slot.name.ends_with(key)).unwrap();
        let [x, y] = [at("gain_y"), at("gain_torque")];
        fitted.fit.spread[(x, y)] = 0.999;
        fitted.fit.spread[(y, x)] = 0.999;
        assert!(is_defined(&fitted, 0));
    }

    #[test]
    fn a_load_heavier_than_the_object_is_defined() {
        let load = effect(Kind::MassChange, &[("episode", 1.0), ("time", 2.0), ("mass", 26.0)]);
        let data = World::of(locked().with(load.clone())).recording(4);
        let added = vec![Effect::free(Kind::MassChange).with("episode", Some(1.0))];
        let nominal = PlantEngine::new(&data, None).unwrap().nominal().clone();
        let free = Model { effects: [nominal.effects.clone(), added.clone()].concat(), ..nominal };
        let own: Vec<f64> = [20.0, 0.0, 0.0, 0.0, 20.0, 100.0, 1.0, 2.0, 20.0].into();
        let options = FitOptions { starts: 2, ..FitOptions::default() };
        let fitted = fit(&Comparison::of(&data).unwrap(), &free, &[own], &options, &Quiet).unwrap();
        let fitted = FittedModel::new(added, fitted, None);
        let mass = fitted.fit.estimate("mass_change.mass").unwrap();
        assert!(mass.mean > 22.0 && is_defined(&fitted, 0), "{mass:?}");
    }

    #[test]
    fn a_swinging_load_without_its_frequency_is_not_defined() {
        let all: Vec<&str> = Kind::SwingingLoad.spec().params.iter().map(|p| p.name).collect();
        assert!(is_defined(&fit_with_identified(Kind::SwingingLoad, &all), 0));
        let rest: Vec<&str> = all.into_iter().filter(|key| *key != "frequency").collect();
        assert!(!is_defined(&fit_with_identified(Kind::SwingingLoad, &rest), 0));
    }
}
