//! How well a model predicts training episodes that it was not fitted to.
//!
//! Each training episode (or group of them, at most [`MAX_FOLDS`]) is left out once, the model is refitted to the others
//! from where its fit to all of them ended, and predicts what was left out. PredictedSamples of one episode depend on one another;
//! episodes do not.

use crate::block_bootstrap::PredictedSamples;
use crate::engine::{Engine, FittedModel};
use rayon::prelude::*;
use trundle_infer::{InferError, Score, Watch, on_all_cores};
use trundle_model::Model;
use trundle_record::Prepared;

/// Groups that training episodes are left out in, at most.
const MAX_FOLDS: usize = 8;

/// How left-out episodes are predicted.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LeftOutPrediction {
    /// Squared errors of each episode, by kind of prediction, turns counted at the radius of gyration: the whole episode in
    /// open loop and windows of one second, m²; or the wrench, N².
    episodes: Vec<Vec<f64>>,
    /// Each sample.
    pub samples: PredictedSamples,
}

impl LeftOutPrediction {
    /// By what factor the misfit rises when another model predicts instead: of the mean over episodes, or of an episode
    /// as a geometric mean, whichever is more. What happens in one episode counts by the first; the second counts where
    /// one left-out episode is predicted badly by both, because it alone tells a parameter that they share. A geometric
    /// mean over the kinds of prediction; one where nothing can be compared.
    pub fn error_ratio(&self, other: &Self) -> f64 {
        let kinds = self.episodes.iter().chain(&other.episodes).map(Vec::len).min().unwrap_or(0);
        let sum = |of: &Self, kind: usize| of.episodes.iter().map(|e| e[kind]).sum::<f64>();
        let whole = (0..kinds).map(|kind| (sum(other, kind) / sum(self, kind)).ln());
        let pairs = || self.episodes.iter().zip(&other.episodes);
        let each =
            (0..kinds).flat_map(|kind| pairs().map(move |(own, other)| (other[kind] / own[kind]).ln()));
        mean(whole).max(mean(each)).exp()
    }
}

/// Mean of the finite numbers; zero where there are none.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) =
        values.filter(|v| v.is_finite()).fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// How a model predicts the training episodes, each by a fit to the others; in sample where there is only one. What is not
/// judged of the model `beside` is excluded for both.
///
/// # Errors
/// When the user interrupts.
pub(crate) fn cross_validate(
    engine: &dyn Engine,
    tried: &FittedModel,
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
        let fitted = if folds > 1 { refitted(engine, tried, &|k| !inside(k), watch)? } else { tried.clone() };
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

/// What belongs to each of `count` episodes, in their order, from what belongs to those of each fold.
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

/// A model refitted to some episodes. What these alone do not hold stays as all episodes have it: the moment of an event,
/// or the place of a thing that is hit in one episode, is nothing that other episodes could predict.
fn refitted(
    engine: &dyn Engine,
    tried: &FittedModel,
    keep: &dyn Fn(usize) -> bool,
    watch: &dyn Watch,
) -> Result<FittedModel, InferError> {
    let mut model = engine.nominal().clone();
    model.effects.extend(tried.added.iter().cloned());
    let found = engine.refitted(tried, &model, keep, watch)?;
    let is_lost = |name: &str| {
        tried.fit.estimate(name).is_some_and(|all| all.identified) && !is_identified(&found, name)
    };
    let Some(model) = with_fixed(model, &tried.fit.model, is_lost) else { return Ok(found) };
    engine.refitted(tried, &model, keep, watch)
}

fn is_identified(tried: &FittedModel, name: &str) -> bool {
    tried.fit.estimate(name).is_none_or(|estimate| estimate.identified)
}

/// A model with those parameters of its effects held at their fitted values that are `lost`; `None` where none is.
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
    use crate::common::{World, effect, locked};
    use crate::engine::Own;
    use trundle_infer::{Comparison, FitOptions, Quiet, fit};
    use trundle_model::{Effect, Kind};

    #[test]
    fn an_episode_that_both_predict_badly_hides_nothing() {
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

    /// How much the misfit of left-out episodes rises without an effect, for a recording of a world.
    fn error_ratio_without(truth: Model, effect: Effect) -> f64 {
        let data = World::of(truth).recording(4);
        let comparison = Comparison::of(&data).unwrap();
        let engine = Own::new(&data, None).unwrap();
        let nominal = engine.nominal();
        let tried = |added: Vec<Effect>| {
            let model =
                Model { effects: [nominal.effects.clone(), added.clone()].concat(), ..nominal.clone() };
            let fit = fit(&comparison, &model, &[], &FitOptions::default(), &Quiet).unwrap();
            FittedModel::new(added, fit, None)
        };
        let of = |added| {
            let tried = tried(added);
            cross_validate(&engine, &tried, &tried, &Quiet).unwrap()
        };
        of(vec![effect]).error_ratio(&of(vec![]))
    }

    #[test]
    fn a_true_effect_is_missed_and_a_false_one_is_not() {
        let slope = effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]);
        let free = || Effect::free(Kind::FloorSlope);
        assert!(error_ratio_without(locked().with(slope), free()) > 3.0);
        assert!(error_ratio_without(locked(), free()) < 1.1);
    }

    #[test]
    fn what_happens_in_one_episode_is_not_held_against_it() {
        // The last episode alone tells of the load: without it neither its moment nor its mass is known.
        let load = effect(Kind::MassChange, &[("episode", 3.0), ("time", 2.0), ("mass", 8.0)]);
        let sought = Effect::free(Kind::MassChange).with("episode", Some(3.0));
        assert!(error_ratio_without(locked().with(load), sought) > 8.0);
    }

    #[test]
    fn what_other_episodes_do_not_hold_stays() {
        let free = Model { effects: vec![Effect::free(Kind::MassChange)], ..locked() };
        let fitted = effect(Kind::MassChange, &[("episode", 3.0), ("time", 2.0), ("mass", 8.0)]);
        let fitted = Model { effects: vec![fitted], ..locked() };
        let is_identified = with_fixed(free.clone(), &fitted, |name| name == "mass_change.mass").unwrap();
        assert_eq!(is_identified.effects[0], Effect::free(Kind::MassChange).with("mass", Some(8.0)));
        assert!(with_fixed(free, &fitted, |name| name == "body.mass").is_none());
    }
}
