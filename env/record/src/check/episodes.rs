//! Whether all episodes are of one object.

use super::dynamics::{Moments, WINDOWS, fit};
use super::explain::WRONG;
use super::subject::Subject;
use super::{Finding, Severity};

/// Fewer episodes than this show no usual one.
const FEWEST: usize = 3;
/// Unexplained share under the others' body from which on an episode is another's, and how many times more one common
/// body leaves unexplained of all episodes, and of this, than one for it and one for the others. A law that does not
/// explain the others either says nothing about this one.
const OTHER: (f64, f64) = (0.2, 3.0);

/// An episode that the body of the others does not explain, while one of its own does.
pub(crate) fn alike(subject: &Subject) -> Vec<Finding> {
    let Some(explained) = &subject.explained else { return vec![] };
    let (change, terms) = (explained.best.mistake.change(), &explained.best.fit.terms);
    let episodes: Vec<Moments> = explained.moments.chunks(WINDOWS).map(Moments::sum).collect();
    if episodes.len() < FEWEST {
        return vec![];
    }
    let all = Moments::sum(&episodes);
    let common = fit(&all, &change, terms);
    let square = |moments: &Moments, share: f64| share * moments.changed(&change).1;
    let apart = |k: usize| {
        let rest = Moments::sum(episodes.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, m)| m));
        let others = fit(&rest, &change, terms);
        let own = fit(&episodes[k], &change, terms);
        let two = square(&rest, others.share) + square(&episodes[k], own.share);
        (k, square(&all, common.share) / two.max(f64::MIN_POSITIVE), others, own)
    };
    let worst = (0..episodes.len()).map(apart).max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((k, times, others, own)) = worst else { return vec![] };
    let share = others.share_of(&episodes[k], &change);
    let in_common = common.share_of(&episodes[k], &change);
    if share < OTHER.0 || times < OTHER.1 || in_common < OTHER.1 * own.share || others.share > WRONG.0 {
        return vec![];
    }
    let sentence = format!(
        "this episode does not fit the object of the others: their body leaves {:.0} % of its load unexplained ({:.1} % \
         of theirs); it shows a mass of {:.3} kg, the others {:.3} kg",
        100.0 * share,
        100.0 * others.share,
        own.mass(),
        others.mass()
    );
    let remedy = "leave the episode out if another object or another gripper was recorded; otherwise look at its poses \
                  and clock";
    vec![Finding::new("episodes", Severity::Warning, sentence, remedy).of(subject.episodes[k].name())]
}
