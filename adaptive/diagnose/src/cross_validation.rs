//! Cross-validation over training episodes.
//!
//! Each training episode, or each of at most [`MAX_FOLDS`] groups, is left out once. The model is refitted to
//! the others, starting from its fit to all episodes, and predicts the left-out ones. Samples of one episode
//! are correlated; episodes are independent.

use crate::block_bootstrap::PredictedSamples;
use crate::engine::Engine;
use crate::fitted_model::FittedModel;
use rayon::prelude::*;
use trundle_infer::{InferError, Score, Watch, on_all_cores};
use trundle_model::Model;
use trundle_record::Prepared;

/// Most groups of left-out episodes.
const MAX_FOLDS: usize = 8;

/// Prediction of left-out episodes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LeftOutPrediction {
    /// Squared errors of each episode by kind of prediction, with angles at the radius of gyration: the whole
    /// episode in open loop and one-second windows, m²; or the wrench, N².
    episodes: Vec<Vec<f64>>,
    /// The samples of each episode.
    pub samples: PredictedSamples,
}

impl LeftOutPrediction {
    /// Ratio of the squared errors of another model to this one's: of the mean over episodes, or the
    /// geometric mean of the ratios of single episodes, whichever is larger.
    ///
    /// The first detects an effect that acts in one episode. The second counts if both models predict one
    /// left-out episode badly because only that episode identifies a shared parameter. The result is a
    /// geometric mean over the kinds of prediction, and one if nothing can be compared.
    pub fn error_ratio(&self, other: &Self) -> f64 {
        let kinds = self.episodes.iter().chain(&other.episodes).map(Vec::len).min().unwrap_or(0);
        let sum = |of: &Self, kind: usize| of.episodes.iter().map(|e| e[kind]).sum::<f64>();
        let mean_ratios = (0..kinds).map(|kind| (sum(other, kind) / sum(self, kind)).ln());
        let pairs = || self.episodes.iter().zip(&other.episodes);
        let episode_ratios =
            (0..kinds).flat_map(|kind| pairs().map(move |(own, other)| (other[kind] / own[kind]).ln()));
        mean(mean_ratios).max(mean(episode_ratios)).exp()
    }
}

/// Mean of the finite values; zero if there are none.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) =
        values.filter(|v| v.is_finite()).fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Predict each training episode by a fit to the others, or in sample if there is only one. Samples that are
/// not scored for the model `compared_with` are excluded for both models.
///
/// # Errors
/// If the user interrupts.
pub(crate) fn cross_validate(
    engine: &dyn Engine,
    fitted: &FittedModel,
    compared_with: &FittedModel,
    watch: &dyn Watch,
) -> Result<LeftOutPrediction, InferError> {
    let (data, nominal) = (engine.data(), engine.nominal());
    let count = data.training.len();
    let folds = count.min(MAX_FOLDS);
    let gyration = if data.dof[2] { nominal.body.gyration } else { 0.0 };
    let scored = |model: &FittedModel, episode: &Prepared| {
        let score = engine.score(model, compared_with, std::slice::from_ref(episode))?;
        Ok(errors(&score, gyration, engine.is_quasi_static()))
    };
    let one = |fold: usize, watch: &dyn Watch| -> Result<(Vec<Vec<f64>>, PredictedSamples), InferError> {
        let inside = |k: usize| k % folds == fold;
        let fitted =
            if folds > 1 { refitted(engine, fitted, &|k| !inside(k), watch)? } else { fitted.clone() };
        let own = data.training.iter().enumerate().filter(|(k, _)| inside(*k));
        let errors = own.map(|(_, episode)| scored(&fitted, episode)).collect::<Result<_, InferError>>()?;
        Ok((errors, engine.predicted(&fitted, &inside)?))
    };
    let all = on_all_cores(watch, |watch| {
        (0..folds).into_par_iter().map(|fold| one(fold, watch)).collect::<Result<Vec<_>, InferError>>()
    })?;
    let (errors, samples) = all.into_iter().unzip();
    Ok(LeftOutPrediction { episodes: in_order(errors, count), samples: in_order(samples, count) })
}

/// The entries of `count` episodes in their order, from the entries of each fold.
fn in_order<T>(folds: Vec<Vec<Vec<T>>>, count: usize) -> Vec<Vec<T>> {
    let number = folds.len();
    let mut episodes: Vec<Vec<T>> = (0..count).map(|_| vec![]).collect();
    for (fold, found) in folds.into_iter().enumerate() {
        for (k, own) in found.into_iter().enumerate() {
            if let Some(place) = episodes.get_mut(fold + k * number) {
                *place = own;
            }
        }
    }
    episodes
}

/// A model refitted to some episodes. Parameters of effects that these episodes do not identify keep their
/// values from the fit to all episodes. For example, other episodes cannot predict the time of an event. Where the
/// refit cannot start, all parameters keep their values.
fn refitted(
    engine: &dyn Engine,
    fitted: &FittedModel,
    keep: &dyn Fn(usize) -> bool,
    watch: &dyn Watch,
) -> Result<FittedModel, InferError> {
    let mut model = engine.nominal().clone();
    model.effects.extend(fitted.added.iter().cloned());
    // The density may not be finite without the left-out episodes, as at friction that hardly creeps.
    let refit = |model: &Model| match engine.refitted(fitted, model, keep, watch) {
        Err(InferError::NoStart { .. }) => Ok(fitted.clone()),
        found => found,
    };
    let found = refit(&model)?;
    let is_lost = |name: &str| {
        fitted.fit.estimate(name).is_some_and(|all| all.identified) && !is_identified(&found, name)
    };
    let Some(model) = with_fixed(model, &fitted.fit.model, is_lost) else { return Ok(found) };
    refit(&model)
}

fn is_identified(fitted: &FittedModel, name: &str) -> bool {
    fitted.fit.estimate(name).is_none_or(|estimate| estimate.identified)
}

/// A model whose effects have the parameters selected by `is_lost` fixed at their fitted values; `None` if
/// there are none.
fn with_fixed(mut model: Model, fitted: &Model, is_lost: impl Fn(&str) -> bool) -> Option<Model> {
    let mut any = false;
    let names = model.effect_names();
    for ((effect, name), fitted) in model.effects.iter_mut().zip(names).zip(&fitted.effects) {
        let params = effect.kind.spec().params.iter();
        for ((param, value), fitted) in params.zip(&mut effect.values).zip(&fitted.values) {
            if is_lost(&format!("{name}.{}", param.name)) {
                (*value, any) = (*fitted, true);
            }
        }
    }
    any.then_some(model)
}

fn errors(score: &Score, gyration: f64, quasi: bool) -> Vec<f64> {
    let square = |along: Option<f64>, turn: Option<f64>, arm: f64| {
        along.map(|along| along * along + turn.map_or(0.0, |turn| (arm * turn).powi(2)))
    };
    if quasi {
        let arm = if gyration > 0.0 { gyration.recip() } else { 0.0 };
        return square(score.force_rmse, score.torque_rmse, arm).into_iter().collect();
    }
    [
        square(score.position_rmse, score.heading_rmse, gyration),
        square(score.window_position_rmse, score.window_heading_rmse, gyration),
    ]
    .into_iter()
    .flatten()
    .collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::engine::plant_engine::PlantEngine;
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::{Comparison, FitOptions, Quiet, fit};
    use trundle_model::{Effect, Kind};

    #[test]
    fn an_episode_that_both_models_predict_badly_masks_no_effect() {
        let of = |errors: [f64; 4]| LeftOutPrediction {
            episodes: errors.iter().map(|&e| vec![e]).collect(),
            samples: vec![],
        };
        let (with, without) = (of([1e-4, 1e-4, 1e-4, 5.0]), of([4e-4, 4e-4, 4e-4, 5.0]));
        assert!(with.error_ratio(&without) > 2.0 && without.error_ratio(&with) < 1.0 + 1e-3);
        let event = of([1e-4, 1e-4, 1e-4, 1e-4]);
        assert!(event.error_ratio(&of([1e-4, 1e-4, 1e-4, 5e-4])) == 2.0);
        assert!(event.error_ratio(&event) == 1.0);
    }

    /// Ratio of the squared errors of left-out episodes without an effect to those with it.
    fn error_ratio_without(truth: Model, effect: Effect) -> f64 {
        let data = World::of(truth).recording(4);
        let comparison = Comparison::of(&data).unwrap();
        let engine = PlantEngine::new(&data, None).unwrap();
        let nominal = engine.nominal();
        let fitted = |added: Vec<Effect>| {
            let model =
                Model { effects: [nominal.effects.clone(), added.clone()].concat(), ..nominal.clone() };
            let fit = fit(&comparison, &model, &[], &FitOptions::default(), &Quiet).unwrap();
            FittedModel::new(added, fit, None)
        };
        let of = |added| {
            let fitted = fitted(added);
            cross_validate(&engine, &fitted, &fitted, &Quiet).unwrap()
        };
        of(vec![effect]).error_ratio(&of(vec![]))
    }

    #[test]
    fn errors_rise_without_a_true_effect_only() {
        let slope = effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]);
        let free = || Effect::free(Kind::FloorSlope);
        assert!(error_ratio_without(locked().with(slope), free()) > 3.0);
        assert!(error_ratio_without(locked(), free()) < 1.1);
    }

    #[test]
    fn an_effect_in_one_episode_is_not_rejected() {
        // Only the last episode identifies the time and mass of the load.
        let load = effect(Kind::MassChange, &[("episode", 3.0), ("time", 2.0), ("mass", 8.0)]);
        let effect_free = Effect::free(Kind::MassChange).with("episode", Some(3.0));
        assert!(error_ratio_without(locked().with(load), effect_free) > 8.0);
    }

    #[test]
    fn a_refit_that_cannot_start_keeps_the_values() {
        let data = World::of(locked()).recording(4);
        let engine = PlantEngine::new(&data, None).unwrap();
        let mut fitted = engine.base(0, &Quiet).unwrap();
        fitted.fit.values[0] = f64::NAN;
        let found = refitted(&engine, &fitted, &|episode| episode != 0, &Quiet).unwrap();
        assert_eq!((found.fit.cost, &found.fit.point), (fitted.fit.cost, &fitted.fit.point));
    }

    #[test]
    fn parameters_that_other_episodes_do_not_identify_are_fixed() {
        let free = Model { effects: vec![Effect::free(Kind::MassChange)], ..locked() };
        let fitted = effect(Kind::MassChange, &[("episode", 3.0), ("time", 2.0), ("mass", 8.0)]);
        let fitted = Model { effects: vec![fitted], ..locked() };
        let fixed = with_fixed(free.clone(), &fitted, |name| name == "mass_change.mass").unwrap();
        assert_eq!(fixed.effects[0], Effect::free(Kind::MassChange).with("mass", Some(8.0)));
        assert!(with_fixed(free, &fitted, |name| name == "body.mass").is_none());
    }
}
