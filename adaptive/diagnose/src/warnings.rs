//! Doubts that a careful reader must know of. Held-out episodes are looked at here for the last time, and change no
//! verdict.

use crate::engine::{Engine, Tried};
use trundle_infer::{InferError, Score};
use trundle_record::Prepared;

/// A held-out episode whose error one second ahead is larger than that of every fitted one by this factor behaves unlike
/// them: with six fitted episodes of one distribution, the largest is exceeded threefold in less than one case of a
/// hundred where the error's logarithm has a standard deviation of 0.4.
const UNLIKE_FACTOR: f64 = 3.0;
/// Rise of a held-out figure that counts as worse.
const WORSE: f64 = 1.05;
/// Episodes below which a judgement by episodes is weak.
const FEW_EPISODES: usize = 6;

/// Everything to doubt in a diagnosis that compares the models `before` and `after`.
pub(crate) fn warnings(
    engine: &dyn Engine,
    before: &Tried,
    after: &Tried,
    named: bool,
) -> Result<Vec<String>, InferError> {
    let data = engine.data();
    let mut found: Vec<String> =
        after.fit.prior_conflicts.iter().map(|strain| format!("implausible value: {strain}")).collect();
    if data.held_out.is_empty() {
        found.push(
            "no episode is held out: nothing shows how the model predicts what it was not fitted to; name some under \
             [split] held_out"
                .to_owned(),
        );
    }
    if named && data.training.len() < FEW_EPISODES {
        found.push(format!(
            "only {} episodes are fitted: {FEW_EPISODES} or more are needed for a sure judgement by left-out episodes",
            data.training.len()
        ));
    }
    let error = |tried: &Tried, episode: &Prepared| -> Result<Option<f64>, InferError> {
        let score = engine.score(tried, tried, std::slice::from_ref(episode))?;
        Ok(score.window_position_rmse.or(score.force_rmse))
    };
    let mut largest = 0.0_f64;
    for episode in &data.training {
        largest = largest.max(error(after, episode)?.unwrap_or(0.0));
    }
    for episode in &data.held_out {
        if let Some(unlike) = error(after, episode)?.filter(|e| largest > 0.0 && *e > UNLIKE_FACTOR * largest)
        {
            found.push(format!(
                "{} (held out) behaves unlike the fitted episodes: it is predicted {:.1} times worse than the worst of \
                 them; was another object, load or floor recorded?",
                episode.name,
                unlike / largest
            ));
        }
    }
    if named && !data.held_out.is_empty() {
        let [old, new] =
            [engine.score(before, after, &data.held_out)?, engine.score(after, before, &data.held_out)?];
        found.extend(worse(&old, &new));
    }
    Ok(found)
}

/// Held-out figures that got worse, in one sentence.
fn worse(before: &Score, after: &Score) -> Option<String> {
    let figures = [
        ("position error in open loop", "m", before.position_rmse, after.position_rmse),
        ("position error one second ahead", "m", before.window_position_rmse, after.window_position_rmse),
        ("force error", "N", before.force_rmse, after.force_rmse),
    ];
    let rose = |(name, unit, before, after): (&str, &str, Option<f64>, Option<f64>)| {
        let (before, after) = (before?, after?);
        (after > WORSE * before).then(|| format!("{name} {before:.4} {unit} before, {after:.4} {unit} after"))
    };
    let all: Vec<String> = figures.into_iter().filter_map(rose).collect();
    (!all.is_empty()).then(|| format!("held-out figures got worse: {}", all.join(", ")))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::common::{World, effect, locked};
    use crate::engine::Own;
    use trundle_infer::Quiet;
    use trundle_model::Kind;

    #[test]
    fn another_object_in_a_held_out_episode_is_named() {
        let mut data = World::of(locked()).recording(1);
        let base = |engine: &Own<'_>| engine.base(0, &Quiet).unwrap();
        let engine = Own::new(&data, None).unwrap();
        let own = base(&engine);
        let told = warnings(&engine, &own, &own, false).unwrap();
        assert!(told.is_empty(), "{told:?}");
        let rubbing = effect(Kind::CoulombFriction, &[("x", 0.45), ("y", 0.31), ("force", 20.0)]);
        data.held_out = World::of(locked().with(rubbing)).recording(1).held_out;
        let engine = Own::new(&data, None).unwrap();
        let told = warnings(&engine, &own, &own, false).unwrap();
        assert!(told[0].contains(&data.held_out[0].name) && told[0].contains("unlike"), "{told:?}");
    }

    #[test]
    fn a_figure_that_got_worse_is_told() {
        let of = |force| Score { force_rmse: Some(force), ..Score::default() };
        assert!(worse(&of(1.0), &of(1.2)).unwrap().contains("force error"));
        assert_eq!(worse(&of(1.0), &of(1.01)), None);
    }
}
