//! Warnings about a diagnosis. Held-out episodes are scored here for the last time and change no verdict.

use crate::answer::Verdict;
use crate::engine::Engine;
use crate::fitted_model::FittedModel;
use crate::lack_of_fit::LackOfFit;
use trundle_infer::{InferError, Score};
use trundle_record::Prepared;

/// Probability from which a name counts as sure, as in the blind benchmarks.
const SURE_PROBABILITY: f64 = 0.9;

/// Ratio of a held-out episode's error one second ahead to the largest error of a fitted one, above which it
/// counts as unlike the fitted ones. With six fitted episodes of one distribution and a standard deviation of
/// 0.4 of the error's logarithm, fewer than one episode in a hundred exceeds it.
const MAX_HELD_OUT_ERROR_RATIO: f64 = 3.0;
/// Ratio of a held-out error metric after to before above which it counts as worse. A log density counts as worse if it
/// falls as much as by errors that are larger by this ratio.
const MIN_WORSE_RATIO: f64 = 1.05;
/// Number of training episodes below which cross-validation is unreliable.
const MIN_TRAINING_EPISODES: usize = 6;

/// All warnings about a diagnosis that compares the models `before` and `after`.
pub(crate) fn warnings(
    engine: &dyn Engine,
    before: &FittedModel,
    after: &FittedModel,
    named: bool,
) -> Result<Vec<String>, InferError> {
    let data = engine.data();
    let mut found: Vec<String> =
        after.fit.prior_conflicts.iter().map(|strain| format!("implausible value: {strain}")).collect();
    if data.held_out.is_empty() {
        found.push(
            "no episode is held out, so that predictions of unseen episodes are not checked; list some under \
             [split] held_out in recording.toml"
                .to_owned(),
        );
    }
    if named && data.training.len() < MIN_TRAINING_EPISODES {
        found.push(format!(
            "only {} training episodes: cross-validation needs {MIN_TRAINING_EPISODES} or more to be reliable",
            data.training.len()
        ));
    }
    let error = |fitted: &FittedModel, episode: &Prepared| -> Result<Option<f64>, InferError> {
        let score = engine.score(fitted, fitted, std::slice::from_ref(episode))?;
        Ok(score.window_position_rmse.or(score.force_rmse))
    };
    let mut largest = 0.0_f64;
    for episode in &data.training {
        largest = largest.max(error(after, episode)?.unwrap_or(0.0));
    }
    for episode in &data.held_out {
        if let Some(size) = error(after, episode)? {
            let cause = "the object, its load or the floor";
            found.extend(unlike_training(&episode.name, "prediction error", size, largest, cause));
        }
    }
    // A learnt wrench or refitted values may predict worse as well.
    if !std::ptr::eq(before, after) && !data.held_out.is_empty() {
        let [old, new] =
            [engine.score(before, after, &data.held_out)?, engine.score(after, before, &data.held_out)?];
        let metrics = [
            ("position error in open loop", "m", old.position_rmse, new.position_rmse),
            ("position error one second ahead", "m", old.window_position_rmse, new.window_position_rmse),
            ("force error", "N", old.force_rmse, new.force_rmse),
        ]
        .map(|(name, unit, before, after)| ErrorMetric {
            name: name.to_owned(),
            unit: unit.to_owned(),
            before,
            after,
        });
        found.extend(worse_metrics(&metrics));
        found.extend(lower_density(&old, &new));
    }
    Ok(found)
}

/// A warning about a held-out episode whose error is much larger than the largest of the training episodes; `metric` names
/// the error, `cause` what may have changed.
#[must_use]
pub fn unlike_training(episode: &str, metric: &str, error: f64, largest: f64, cause: &str) -> Option<String> {
    (largest > 0.0 && error > MAX_HELD_OUT_ERROR_RATIO * largest).then(|| {
        format!(
            "{episode} (held out) behaves unlike the training episodes: its {metric} is {:.1} times their largest; \
             check whether {cause} changed",
            error / largest
        )
    })
}

/// A warning about a named effect without which held-out episodes are predicted better. `explains` is the share of their
/// misfit by which the effect reduces it.
#[must_use]
pub fn harmful_effect(name: &str, explains: Option<f64>) -> Option<String> {
    let explains = explains.filter(|share| *share < 1.0 - MIN_WORSE_RATIO)?;
    Some(format!(
        "{name} makes predictions of held-out episodes worse: their misfit is {:.2} times that of a refit without it; \
         the true law may be a similar one outside the catalogue",
        1.0 - explains
    ))
}

/// A warning about named laws whose lack of fit makes a similar law outside the catalogue likely. `probability` is that of
/// the named laws being the right ones.
pub(crate) fn doubted_laws(verdict: Verdict, probability: f64) -> Option<String> {
    (verdict == Verdict::Explained && probability < SURE_PROBABILITY).then(|| {
        format!(
            "the named effects leave a residual above the noise, which multiplies their probabilities by {probability:.2}: \
             the true law may be a similar one outside the catalogue, or the stated noise is too small"
        )
    })
}

/// A warning about a consistent verdict although the lack of fit of the nominal model is significant. The verdict neglects
/// it because its prediction errors on training episodes are immaterial; `fit` reports it.
pub(crate) fn neglected_lack_of_fit(
    verdict: Verdict,
    lack: Option<LackOfFit>,
    observations: usize,
    held_out: Option<&Score>,
) -> Option<String> {
    let is_neglected =
        verdict == Verdict::Consistent && lack.is_some_and(|lack| lack.is_significant(observations));
    is_neglected.then(|| {
        let unseen = held_out.and_then(|score| Some((score.position_rmse?, score.r2?)));
        let unseen = unseen.map_or(String::new(), |(error, share)| {
            format!(
                "; in open loop it predicts held-out episodes with a position error of {error:.3} m and {:.0} % of the \
                 variance of their motion",
                100.0 * share
            )
        });
        format!(
            "the residual of the nominal model is more than noise (`trundle fit` says that the model does not explain \
             these data), but no effect predicts one second ahead materially better{unseen}"
        )
    })
}

/// An error metric before and after.
#[derive(Clone, Debug)]
pub struct ErrorMetric {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value without the named effects.
    pub before: Option<f64>,
    /// Value with them.
    pub after: Option<f64>,
}

/// A warning about held-out error metrics that became worse.
#[must_use]
pub fn worse_metrics(metrics: &[ErrorMetric]) -> Option<String> {
    let rose = |metric: &ErrorMetric| {
        let (before, after) = (metric.before?, metric.after?);
        let [old, new] = [before, after].map(|value| format!("{} {}", significant(value), metric.unit));
        (after > MIN_WORSE_RATIO * before).then(|| format!("{} {old} before, {new} after", metric.name))
    };
    let all: Vec<String> = metrics.iter().filter_map(rose).collect();
    (!all.is_empty()).then(|| format!("held-out error metrics became worse: {}", all.join(", ")))
}

/// A warning about a lower density of held-out poses.
fn lower_density(before: &Score, after: &Score) -> Option<String> {
    let (before, after) = (before.log_predictive_density?, after.log_predictive_density?);
    (before - after > MIN_WORSE_RATIO.ln()).then(|| {
        format!(
            "held-out poses became less probable, log density of a pose: {before:.2} before, {after:.2} after"
        )
    })
}

/// A value with three significant digits.
fn significant(value: f64) -> String {
    let digits = (2.0 - value.abs().max(f64::MIN_POSITIVE).log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::engine::plant_engine::PlantEngine;
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::{Channels, Quiet};
    use trundle_model::Kind;

    #[test]
    fn a_held_out_episode_with_another_object_is_reported() {
        let mut data = World::of(locked()).recording(1);
        let base = |engine: &PlantEngine<'_>| engine.base(0, &Quiet).unwrap();
        let engine = PlantEngine::new(&data, None).unwrap();
        let own = base(&engine);
        let found = warnings(&engine, &own, &own, false).unwrap();
        assert!(found.is_empty(), "{found:?}");
        let rubbing = effect(Kind::CoulombFriction, &[("x", 0.45), ("y", 0.31), ("force", 20.0)]);
        data.held_out = World::of(locked().with(rubbing)).recording(1).held_out;
        let engine = PlantEngine::new(&data, None).unwrap();
        let found = warnings(&engine, &own, &own, false).unwrap();
        assert!(found[0].contains(&data.held_out[0].name) && found[0].contains("unlike"), "{found:?}");
    }

    #[test]
    fn a_model_without_names_that_predicts_worse_is_reported() {
        let data = World::of(locked()).recording(1);
        let engine = PlantEngine::new(&data, None).unwrap();
        let before = engine.base(0, &Quiet).unwrap();
        let mut after = before.clone();
        after.fit.values[0] *= 2.0;
        after.fit.model = after.fit.model.with_values(&after.fit.values).unwrap();
        let found = warnings(&engine, &before, &after, false).unwrap();
        assert!(found.iter().any(|warning| warning.contains("became worse")), "{found:?}");
    }

    #[test]
    fn a_worse_metric_is_reported() {
        let of = |before, after| {
            worse_metrics(&[ErrorMetric {
                name: "force error".to_owned(),
                unit: "N".to_owned(),
                before: Some(before),
                after: Some(after),
            }])
        };
        assert!(of(0.01, 0.0125).unwrap().ends_with("force error 0.0100 N before, 0.0125 N after"));
        assert_eq!(of(1.0, 1.01), None);
    }

    #[test]
    fn a_lower_log_density_is_reported() {
        let of = |density| Score { log_predictive_density: Some(density), ..Score::default() };
        let found = lower_density(&of(9.02), &of(8.43)).unwrap();
        assert!(found.ends_with("9.02 before, 8.43 after"), "{found}");
        assert_eq!(lower_density(&of(9.02), &of(9.0)), None);
        assert_eq!(lower_density(&of(9.02), &Score::default()), None);
    }

    #[test]
    fn an_effect_that_harms_held_out_predictions_is_reported() {
        let of = |explains| harmful_effect("coulomb_friction", explains);
        let found = of(Some(-1.7)).unwrap();
        assert!(found.contains("coulomb_friction") && found.contains("2.70 times"), "{found}");
        assert!([Some(0.8), Some(-0.02), None].into_iter().all(|explains| of(explains).is_none()));
    }

    #[test]
    fn a_residual_that_makes_the_named_law_doubtful_is_reported() {
        let found = doubted_laws(Verdict::Explained, 0.474).unwrap();
        assert!(found.contains("probabilities by 0.47"), "{found}");
        assert_eq!(doubted_laws(Verdict::Explained, 0.97), None);
        assert_eq!(doubted_laws(Verdict::Unexplained, 0.4), None);
    }

    #[test]
    fn a_consistent_verdict_with_a_lack_of_fit_is_reported() {
        let channels = Channels { pose: [1e-3; 3], reading: [0.4; 3], wander: [0.0; 3] };
        let lack = |gain| Some(LackOfFit { gain, channels, chi_squared_excess: gain });
        let score = Score { position_rmse: Some(0.279), r2: Some(0.62), ..Score::default() };
        let of = |verdict, gain| neglected_lack_of_fit(verdict, lack(gain), 2000, Some(&score));
        let found = of(Verdict::Consistent, 1e3).unwrap();
        assert!(found.contains("0.279 m and 62 %"), "{found}");
        assert_eq!(of(Verdict::Consistent, 0.0), None);
        assert_eq!(of(Verdict::Unexplained, 1e3), None);
    }
}
