//! What an answer tells of what was tried: pure functions of fits.

use super::hunt::{Remainder, Trial, called, holds_up, without};
use super::likelihood::Along;
use crate::answer::{Alternative, Verdict, Window};
use crate::thresholds::{LEFT_OVER, SURE, TIE};
use nalgebra::{Matrix2, Vector2, Vector3};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use trundle_infer::Residual;
use trundle_model::{Effect, Model};

/// At most this many alternatives are told.
const ALTERNATIVES: usize = 5;
/// p of a sample that belongs to a window.
const SAMPLE_P: f64 = 1e-4;
/// Windows closer than this are one, shorter ones are not told, s.
const BRIDGE: f64 = 0.15;
const SHORTEST: f64 = 0.1;
/// At most this many windows are told.
const MOST: usize = 24;

/// The trial with the most weight each of whose effects holds up block by block, and the chance of each.
pub(crate) fn choose(tried: &[Trial]) -> (&Trial, Vec<f64>) {
    for trial in tried {
        let mut chances = Vec::new();
        for k in 0..trial.added.len() {
            chances.push(match without(tried, trial, k) {
                Some(simpler) => holds_up(trial, simpler),
                None => 0.0,
            });
        }
        if chances.iter().all(|c| *c >= SURE) {
            return (trial, chances);
        }
    }
    (&tried[0], vec![])
}

pub(crate) fn judge(observations: usize, before: Remainder, best: &Trial, left: Remainder) -> Verdict {
    if best.added.is_empty() {
        return if before.matters(observations) { Verdict::Unexplained } else { Verdict::Consistent };
    }
    if left.matters(observations) && left.gain > LEFT_OVER * before.gain {
        return Verdict::Unexplained;
    }
    Verdict::Explained
}

/// Effects of a trial that another lacks.
fn lacking<'a>(from: &'a Trial, other: &Trial) -> Vec<&'a Effect> {
    from.added.iter().filter(|e| other.added.iter().all(|o| o.kind != e.kind)).collect()
}

/// Effects that could stand in another's place without the likelihood telling.
pub(crate) fn ties(tried: &[Trial], best: &Trial) -> Vec<Vec<String>> {
    let mut sets = Vec::new();
    for effect in &best.added {
        let mut set = vec![called(effect).to_owned()];
        for other in tried.iter().filter(|t| t.added.len() == best.added.len()) {
            let alike = (other.fit.cost - best.fit.cost).abs() < TIE
                && other.fit.estimates.len() == best.fit.estimates.len();
            if let ([mine], [rival], true) =
                (lacking(best, other).as_slice(), lacking(other, best).as_slice(), alike)
                && mine.kind == effect.kind
                && !set.iter().any(|told| told == called(rival))
            {
                set.push(called(rival).to_owned());
            }
        }
        if set.len() > 1 {
            sets.push(set);
        }
    }
    sets
}

/// The best trials of other effects than those that are named, and the push that would tell.
pub(crate) fn alternatives(tried: &[Trial], probabilities: &[f64], best: &Trial) -> Vec<Alternative> {
    let others = tried.iter().zip(probabilities).filter(|(t, _)| !lacking(t, best).is_empty());
    let one = |(trial, &probability): (&Trial, &f64)| Alternative {
        effect: trial.names().join(" + "),
        probability,
        experiment: lacking(trial, best).first().map_or("", |e| e.kind.spec().probe).to_owned(),
    };
    others.take(ALTERNATIVES).map(one).collect()
}

/// Stretches in which a missing wrench is not zero.
pub(crate) fn windows(residuals: &[Vec<Residual>], along: &Along) -> Vec<Window> {
    let directions = along.dof.iter().filter(|d| **d).count().max(1);
    let mut all = Vec::new();
    for (episode, path) in residuals.iter().zip(&along.paths) {
        let mut found: Vec<Window> = Vec::new();
        for residual in episode {
            let strength = surprise(standardised(residual, along.dof), directions);
            match found.last_mut() {
                _ if strength < -SAMPLE_P.log10() => {}
                Some(open) if residual.t - open.end <= BRIDGE => {
                    open.end = residual.t;
                    open.strength = open.strength.max(strength);
                }
                _ => found.push(Window {
                    episode: path.name.clone(),
                    start: residual.t,
                    end: residual.t,
                    strength,
                }),
            }
        }
        all.extend(found.into_iter().filter(|w| w.end - w.start >= SHORTEST));
    }
    all.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    all.truncate(MOST);
    all.sort_by(|a, b| a.episode.cmp(&b.episode).then(a.start.total_cmp(&b.start)));
    all
}

/// Squared size of a residual wrench in units of its uncertainty, over the directions that move.
fn standardised(residual: &Residual, dof: [bool; 3]) -> f64 {
    let (mut covariance, mut wrench) = (residual.covariance, Vector3::from(residual.wrench));
    for k in (0..3).filter(|&k| !dof[k]) {
        covariance.row_mut(k).fill(0.0);
        covariance.column_mut(k).fill(0.0);
        (covariance[(k, k)], wrench[k]) = (1.0, 0.0);
    }
    covariance.cholesky().map_or(0.0, |c| wrench.dot(&c.solve(&wrench)))
}

/// −log10 of the tail probability of χ² with `dof` degrees of freedom, finite for any value.
fn surprise(chi_square: f64, dof: usize) -> f64 {
    let tail = ChiSquared::new(dof as f64).map_or(1.0, |d| d.sf(chi_square));
    if tail > 1e-280 {
        return -tail.log10();
    }
    // Leading term of the incomplete gamma function.
    let half = chi_square / 2.0;
    (half - (dof as f64 / 2.0 - 1.0) * half.ln()) / std::f64::consts::LN_10
}

/// The body point through which all missing wrenches pass, τ = x f_y − y f_x, if there is one: on the body, within 10 cm,
/// and explaining most of the moment.
pub(crate) fn line_of_action(residuals: &[Vec<Residual>], model: &Model) -> Option<[f64; 2]> {
    let (mut normal, mut rhs, mut moment) = (Matrix2::zeros(), Vector2::zeros(), 0.0);
    let mut count = 0.0;
    for residual in residuals.iter().flatten() {
        let [fx, fy, torque] = residual.wrench;
        let weight = residual.covariance[(2, 2)].max(1e-12).recip();
        let row = Vector2::new(fy, -fx);
        normal += weight * row * row.transpose();
        rhs += weight * torque * row;
        moment += weight * torque * torque;
        count += 1.0;
    }
    let spread = normal.try_inverse().filter(|_| !model.on_rail())?;
    let point = spread * rhs;
    let unexplained = moment - point.dot(&rhs);
    // Neighbouring samples are nearly the same: count one in ten.
    let scale = 10.0 * (unexplained / count).max(1.0);
    let [low, high] = model.body.bounds();
    let inside = (0..2).all(|k| (low[k] - 0.05..=high[k] + 0.05).contains(&point[k]));
    let sharp = (0..2).all(|k| scale * spread[(k, k)] < 0.01) && unexplained < 0.3 * moment;
    (inside && sharp).then_some([point[0], point[1]])
}
