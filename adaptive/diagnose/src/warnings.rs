//! Warnings about a diagnosis. Held-out episodes are scored here for the last time and change no verdict.

use crate::engine::Engine;
use crate::fitted_model::FittedModel;
use trundle_infer::{InferError, Score};
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
        if let Some(unlike) =
            error(after, episode)?.filter(|e| largest > 0.0 && *e > MAX_HELD_OUT_ERROR_RATIO * largest)
        {
            found.push(format!(
                "{} (held out) behaves unlike the training episodes: its prediction error is {:.1} times their \
                 largest; check whether the object, its load or the floor changed",
                episode.name,
                unlike / largest
            ));
        }
    }
    if named && !data.held_out.is_empty() {
        let [old, new] =
            [engine.score(before, after, &data.held_out)?, engine.score(after, before, &data.held_out)?];
        found.extend(worse_metrics(&old, &new));
    }
    Ok(found)
}

/// A warning about held-out error metrics that became worse.
fn worse_metrics(before: &Score, after: &Score) -> Option<String> {
    let metrics = [
        ("position error in open loop", "m", before.position_rmse, after.position_rmse),
        ("position error one second ahead", "m", before.window_position_rmse, after.window_position_rmse),
        ("force error", "N", before.force_rmse, after.force_rmse),
    ];
    let rose = |(name, unit, before, after): (&str, &str, Option<f64>, Option<f64>)| {
        let (before, after) = (before?, after?);
        (after > MIN_WORSE_RATIO * before)
            .then(|| format!("{name} {before:.4} {unit} before, {after:.4} {unit} after"))
    };
    let all: Vec<String> = metrics.into_iter().filter_map(rose).collect();
    (!all.is_empty()).then(|| format!("held-out error metrics became worse: {}", all.join(", ")))
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
        let of = |force| Score { force_rmse: Some(force), ..Score::default() };
        assert!(worse_metrics(&of(1.0), &of(1.2)).unwrap().contains("force error"));
        assert_eq!(worse_metrics(&of(1.0), &of(1.01)), None);
    }
}
