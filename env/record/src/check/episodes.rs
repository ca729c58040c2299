//! Check that all episodes show the same object.

use super::dynamics::{NormalEquations, WINDOWS_PER_EPISODE, fit};
use super::finding::{Finding, Severity};
use super::input::CheckInput;
use super::wrench_fit::MIN_STATED_MISFIT;

/// Minimum number of episodes.
const MIN_EPISODES: usize = 3;
/// Minimum unexplained share of an episode under the body that is fitted to the other episodes.
const MIN_UNEXPLAINED_SHARE: f64 = 0.2;
/// Minimum misfit with one common body relative to separate bodies, for all episodes and for the episode itself.
const MIN_COMMON_MISFIT_RATIO: f64 = 3.0;

/// Checks for an episode that its own body explains, but that of the other episodes does not. Reports nothing if the body
/// does not explain the other episodes either.
pub(crate) fn other_object(input: &CheckInput) -> Vec<Finding> {
    let Some(fits) = &input.wrench_fits else { return vec![] };
    let (correction, terms) = (fits.best.mistake.correction(), &fits.best.fit.terms);
    let episodes: Vec<NormalEquations> =
        fits.equations.chunks(WINDOWS_PER_EPISODE).map(NormalEquations::sum).collect();
    if episodes.len() < MIN_EPISODES {
        return vec![];
    }
    let all = NormalEquations::sum(&episodes);
    let common = fit(&all, &correction, terms);
    let square = |equations: &NormalEquations, share: f64| share * equations.transformed(&correction).1;
    let split = |k: usize| {
        let rest = NormalEquations::sum(episodes.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, m)| m));
        let others = fit(&rest, &correction, terms);
        let own = fit(&episodes[k], &correction, terms);
        let separate = square(&rest, others.unexplained) + square(&episodes[k], own.unexplained);
        (k, square(&all, common.unexplained) / separate.max(f64::MIN_POSITIVE), others, own)
    };
    let worst = (0..episodes.len()).map(split).max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((k, ratio, others, own)) = worst else { return vec![] };
    let share = others.unexplained_share_of(&episodes[k], &correction);
    let in_common = common.unexplained_share_of(&episodes[k], &correction);
    if share < MIN_UNEXPLAINED_SHARE
        || ratio < MIN_COMMON_MISFIT_RATIO
        || in_common < MIN_COMMON_MISFIT_RATIO * own.unexplained
        || others.unexplained > MIN_STATED_MISFIT
    {
        return vec![];
    }
    let sentence = format!(
        "this episode appears to show another object: the body of the other episodes leaves {:.0} % of its wrench \
         unexplained ({:.1} % of theirs); the fitted mass is {:.3} kg here and {:.3} kg there",
        100.0 * share,
        100.0 * others.unexplained,
        own.mass(),
        others.mass()
    );
    let remedy = "remove the episode if another object or another gripper was recorded; otherwise check its poses and \
                  clock";
    vec![
        Finding::new("episodes", Severity::Warning, sentence, remedy)
            .in_episode(input.data.episodes[k].name()),
    ]
}
