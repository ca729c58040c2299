//! Warnings about a diagnosis. Held-out episodes are scored here for the last time and change no verdict.

use crate::engine::Engine;
use crate::fitted_model::FittedModel;
use trundle_infer::InferError;
use trundle_record::Prepared;

/// Ratio of a held-out episode's error one second ahead to the largest error of a fitted one, above which it
/// counts as unlike the fitted ones. With six fitted episodes of one distribution and a standard deviation of
/// 0.4 of the error's logarithm, fewer than one episode in a hundred exceeds it.
const MAX_HELD_OUT_ERROR_RATIO: f64 = 3.0;
/// Ratio of a held-out error metric after to before above which it counts as worse.
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
    let error = |tried: &FittedModel, episode: &Prepared| -> Result<Option<f64>, InferError> {
        let score = engine.score(tried, tried, std::slice::from_ref(episode))?;
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
    if named && !data.held_out.is_empty() {
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

/// A value with three significant digits.
fn significant(value: f64) -> String {
    let digits = (2.0 - value.abs().max(f64::MIN_POSITIVE).log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::engine::own::Own;
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::Quiet;
    use trundle_model::Kind;

    #[test]
    fn a_held_out_episode_with_another_object_is_reported() {
        let mut data = World::of(locked()).recording(1);
        let base = |engine: &Own<'_>| engine.base(0, &Quiet).unwrap();
        let engine = Own::new(&data, None).unwrap();
        let own = base(&engine);
        let found = warnings(&engine, &own, &own, false).unwrap();
        assert!(found.is_empty(), "{found:?}");
        let rubbing = effect(Kind::CoulombFriction, &[("x", 0.45), ("y", 0.31), ("force", 20.0)]);
        data.held_out = World::of(locked().with(rubbing)).recording(1).held_out;
        let engine = Own::new(&data, None).unwrap();
        let found = warnings(&engine, &own, &own, false).unwrap();
        assert!(found[0].contains(&data.held_out[0].name) && found[0].contains("unlike"), "{found:?}");
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
}
