//! Where a model's residual is large: joints, times, and kinds of motion.

use crate::answer::{JointWindow, RegimeKind};
use crate::fitted_model::FittedModel;
use crate::lack_of_fit::LackOfFit;
use crate::problem::Problem;
use std::collections::BTreeMap;

/// Parts of an episode that are compared.
const WINDOWS_PER_EPISODE: usize = 20;
/// Root mean square, in standard deviations of the whole residual, above which a part is reported.
const MIN_WINDOW_STRENGTH: f64 = 2.0;
/// Most parts that are reported.
const MAX_WINDOWS: usize = 10;
/// Ratio of the residual in one half of the samples to the other half at which a dependence is reported.
const MIN_CONTRAST: f64 = 1.5;

/// Residuals of one joint with the motion.
struct Sample {
    episode: usize,
    /// Place among all samples.
    order: f64,
    t: f64,
    residual: f64,
    speed: f64,
    acceleration: f64,
    side: f64,
}

fn samples(problem: &Problem, model: &FittedModel, joint: usize) -> Vec<Sample> {
    let fit = &model.fit;
    let rows = crate::rows::evaluate(
        problem,
        &fit.effects,
        &fit.slots,
        &fit.values,
        crate::rows::Scope::Training,
        false,
    );
    let Some(own) = rows.iter().find(|own| own.joint == joint) else { return vec![] };
    let one = |(row, place): (usize, &crate::rows::Place)| {
        let episode = &problem.episodes[place.episode];
        let series = &episode.joints[joint];
        Sample {
            episode: place.episode,
            order: row as f64,
            t: episode.start + place.sample as f64 * episode.dt,
            residual: own.residual[row],
            speed: series.v[place.sample].abs(),
            acceleration: series.a[place.sample].abs(),
            side: series.v[place.sample],
        }
    };
    own.places.iter().enumerate().map(one).collect()
}

fn rms<'a>(samples: impl Iterator<Item = &'a Sample>) -> f64 {
    let (sum, count) = samples.fold((0.0, 0.0), |(s, n), x| (s + x.residual * x.residual, n + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Share of each joint in the misfit: what the effects explain of its squared residual, or what a flexible regression
/// does, relative to the squared effort.
pub(crate) fn shares(
    problem: &Problem,
    before: &FittedModel,
    after: &FittedModel,
    lack: &[LackOfFit],
) -> BTreeMap<String, f64> {
    let part = |j: usize| {
        let square = |fitted: &FittedModel| fitted.left_out.mean_square(j, fitted.fit.sd[j]);
        let gain = (square(before) - square(after)).max(lack[j].mean_square);
        gain / problem.joints[j].scales.effort.powi(2).max(f64::MIN_POSITIVE)
    };
    let parts: Vec<f64> = (0..problem.joints.len()).map(part).collect();
    let total: f64 = parts.iter().sum();
    let share = |j: usize| if total > 0.0 { parts[j] / total } else { 0.0 };
    (0..parts.len()).map(|j| (problem.joints[j].name.clone(), share(j))).collect()
}

/// Parts of episodes in which the residual is largest.
pub(crate) fn windows(problem: &Problem, model: &FittedModel) -> Vec<JointWindow> {
    let mut found = vec![];
    for (j, joint) in problem.joints.iter().enumerate() {
        let all = samples(problem, model, j);
        let overall = rms(all.iter()).max(f64::MIN_POSITIVE);
        for (index, episode) in problem.episodes.iter().enumerate() {
            let own: Vec<&Sample> = all.iter().filter(|s| s.episode == index).collect();
            for part in own.chunks(own.len().div_ceil(WINDOWS_PER_EPISODE).max(3)) {
                let strength = rms(part.iter().copied()) / overall;
                if let (true, Some(first), Some(last)) =
                    (strength > MIN_WINDOW_STRENGTH, part.first(), part.last())
                {
                    found.push(JointWindow {
                        episode: episode.name.clone(),
                        joint: joint.name.clone(),
                        start: first.t,
                        end: last.t,
                        strength,
                    });
                }
            }
        }
    }
    found.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    found.truncate(MAX_WINDOWS);
    found
}

/// The motion or half of the recording during which a joint's residual is large, as a keyword and in words.
pub(crate) struct Regime {
    pub kind: RegimeKind,
    pub description: String,
}

/// Where a joint's residual is large; `None` if it depends on no motion and no half of the recording.
pub(crate) fn regime(problem: &Problem, model: &FittedModel, joint: usize) -> Option<Regime> {
    let setup = &problem.joints[joint];
    let speed_unit = if setup.is_hinge { "rad/s" } else { "m/s" };
    let found = largest_contrast(&samples(problem, model, joint), speed_unit)?;
    let description = format!("{}, joint {}", found.description, setup.name);
    Some(Regime { description, ..found })
}

/// The half of the samples in which the residual is clearly larger.
fn largest_contrast(all: &[Sample], speed_unit: &str) -> Option<Regime> {
    use RegimeKind::{
        FirstHalf, HighSpeed, LargeAcceleration, LowSpeed, NegativeDirection, PositiveDirection, SecondHalf,
        SmallAcceleration,
    };
    let regime = |kind, description: String| Regime { kind, description };
    let contrasts = [
        split(all, |s| s.speed).map(|(ratio, at)| {
            let named = |word| format!("{word} {at:.2} {speed_unit}");
            (ratio, regime(HighSpeed, named("above")), regime(LowSpeed, named("below")))
        }),
        split(all, |s| s.acceleration).map(|(ratio, at)| {
            let named = |word| format!("at accelerations {word} {at:.2} {speed_unit}²");
            (ratio, regime(LargeAcceleration, named("above")), regime(SmallAcceleration, named("below")))
        }),
        split_at(all, |s| s.side, 0.0).map(|ratio| {
            let named = |word| format!("in {word} direction");
            (
                ratio,
                regime(PositiveDirection, named("positive")),
                regime(NegativeDirection, named("negative")),
            )
        }),
        split(all, |s| s.order).map(|(ratio, _)| {
            let named = |word| format!("in the {word} half of the recording");
            (ratio, regime(SecondHalf, named("second")), regime(FirstHalf, named("first")))
        }),
    ];
    let largest = contrasts.into_iter().flatten().max_by(|a, b| a.0.ln().abs().total_cmp(&b.0.ln().abs()))?;
    let (ratio, above, below) = largest;
    if ratio >= MIN_CONTRAST {
        Some(above)
    } else if ratio <= MIN_CONTRAST.recip() {
        Some(below)
    } else {
        None
    }
}

/// Ratio of the residual above the median of a quantity to that below it, and the median.
fn split(samples: &[Sample], of: impl Fn(&Sample) -> f64) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = samples.iter().map(&of).collect();
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    let at = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
    split_at(samples, of, at).map(|ratio| (ratio, at))
}

/// Ratio of the residual above a value of a quantity to that below it.
fn split_at(samples: &[Sample], of: impl Fn(&Sample) -> f64, at: f64) -> Option<f64> {
    let below = rms(samples.iter().filter(|s| of(s) < at));
    let above = rms(samples.iter().filter(|s| of(s) >= at));
    (below > 0.0 && above > 0.0).then_some(above / below)
}

#[cfg(test)]
mod tests {
    use super::{Sample, largest_contrast};

    /// Samples with a residual that depends on time and velocity.
    fn contrast(residual: impl Fn(f64, f64) -> f64) -> Option<String> {
        let one = |k: usize| {
            let t = 0.01 * k as f64;
            let (v, acceleration) = ((5.0 * t).cos(), (3.1 * t).sin().abs());
            Sample {
                episode: 0,
                order: t,
                t,
                residual: residual(t, v),
                speed: v.abs(),
                acceleration,
                side: v,
            }
        };
        largest_contrast(&(0..2000).map(one).collect::<Vec<_>>(), "rad/s").map(|found| found.description)
    }

    #[test]
    fn the_regime_is_the_half_in_which_the_residual_is_larger() {
        let dry = |v: f64| v.signum();
        assert_eq!(contrast(|_, v| dry(v)), None);
        assert_eq!(contrast(|_, v| dry(v) + 0.5).as_deref(), Some("in positive direction"));
        assert_eq!(contrast(|_, v| v * v).as_deref(), Some("above 0.70 rad/s"));
        let warm_up = contrast(|t, v| dry(v) * (-t / 10.0).exp());
        assert_eq!(warm_up.as_deref(), Some("in the first half of the recording"));
    }
}
