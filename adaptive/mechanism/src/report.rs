//! The answer of a diagnosis of joints, from the result of its search.

use crate::answer::{
    JointAnswer, JointBeforeAfter, JointEffect, JointFit, JointMismatch, JointNominal, JointParameter,
    JointResidual,
};
use crate::competing_models::{
    alternatives, inclusion_probability, posterior_weights, single_ties, tied_sets,
};
use crate::error_metrics::{JointErrorMetrics, error_metrics};
use crate::fit::Fit;
use crate::fitted_model::{FittedModel, SearchResult, Support};
use crate::intervals::{Interval, are_defined, intervals};
use crate::lack_of_fit::LackOfFit;
use crate::location::{regime, shares, windows};
use crate::model::{Role, Slot, place};
use crate::probability_limits::{ProbabilityLimit, explained};
use crate::problem::Problem;
use crate::search::Searcher;
use crate::spurious_effects::is_spurious;
use crate::statement::statement;
use crate::units::Unit;
use crate::warnings::warnings;
use std::collections::BTreeMap;
use trundle_diagnose::{MAX_TIE_DIFFERENCE_NATS, Quantity, Verdict, calibrated};

/// The answer for a verdict. `lack` is the lack of fit of each joint, without and with the effects of the best model, and
/// `limits` has an entry for each of these effects.
pub(crate) fn answer(
    problem: &Problem,
    searcher: &Searcher<'_>,
    found: &mut SearchResult,
    verdict: Verdict,
    lack: [&[LackOfFit]; 2],
    limits: &[ProbabilityLimit],
) -> JointAnswer {
    let times = searcher.times(&found.best);
    let best = found.best.clone();
    let immaterial = immaterial(problem, searcher, found, &best);
    let bound = best.log_evidence(&times) - 2.0 * MAX_TIE_DIFFERENCE_NATS;
    found.models = searcher.supported(&best, &mut found.models, &times, bound);
    let weights = posterior_weights(searcher, found, &times);
    let spread = intervals(problem, &best.fit, &times);
    let missing = missing(searcher, found, &best, (&weights, &spread), limits);
    let tied = tied_sets(problem, found, &times);
    let base_spread = intervals(problem, &found.base.fit, &searcher.times(&found.base));
    JointAnswer {
        format: "trundle-diagnosis/1",
        recording: problem.name.clone(),
        verdict,
        alternatives: alternatives(problem, found, &weights),
        tied_sets: if tied.len() > 1 { vec![tied.clone()] } else { vec![] },
        tied: single_ties(&tied),
        immaterial: if verdict == Verdict::Unexplained { vec![] } else { immaterial },
        mismatch: mismatch(problem, found, verdict, lack),
        residual: residual(problem, found, verdict, lack[1]),
        warnings: warnings(problem, &found.best.fit),
        nominal: JointNominal {
            given: given(problem),
            before: parameters(problem, &found.base.fit, &base_spread),
            after: parameters(problem, &best.fit, &spread),
        },
        fit: JointFit {
            held_out: before_after(problem, &found.base.fit, &found.best.fit, true),
            training: before_after(problem, &found.base.fit, &found.best.fit, false),
        },
        missing,
    }
}

/// The effects of the best model, those that explain most first. `weights` are those of the fitted models, and `spread` has the
/// intervals of the best model.
fn missing(
    searcher: &Searcher<'_>,
    found: &mut SearchResult,
    best: &FittedModel,
    (weights, spread): (&[f64], &[Interval]),
    limits: &[ProbabilityLimit],
) -> Vec<JointEffect> {
    let problem = searcher.problem;
    let mut missing: Vec<JointEffect> = vec![];
    for (k, limit) in limits.iter().enumerate() {
        let simpler = searcher.without_effect(best, k, &mut found.models);
        let support = found.support.get(k).copied().unwrap_or(Support {
            probability: 0.5,
            error_ratio: 1.0,
            may_be_noise: false,
        });
        let kind = best.fit.effects[k].kind;
        let chance = support.probability.min(inclusion_probability(found, weights, kind));
        let explains = reduction(problem, &simpler.fit, &best.fit);
        let probability = (limit.share * calibrated(chance)).min(limit.most).min(support.share());
        missing.push(reported(problem, &best.fit, spread, k, probability, explains));
    }
    missing.sort_by(|a, b| b.explains.unwrap_or(0.0).total_cmp(&a.explains.unwrap_or(0.0)));
    missing
}

/// Where the nominal mechanism disagrees with the recording.
fn mismatch(
    problem: &Problem,
    found: &SearchResult,
    verdict: Verdict,
    [before, after]: [&[LackOfFit]; 2],
) -> JointMismatch {
    let is_consistent = verdict == Verdict::Consistent;
    let found_regime = if is_consistent { None } else { regime(problem, &found.base, worst_joint(after)) };
    JointMismatch {
        joints: shares(problem, &found.base, &found.best, before),
        regime_kind: found_regime.as_ref().map(|r| r.kind),
        regime: found_regime.map(|r| r.description),
        windows: if is_consistent { vec![] } else { windows(problem, &found.base) },
    }
}

/// What the best model leaves.
fn residual(problem: &Problem, found: &SearchResult, verdict: Verdict, after: &[LackOfFit]) -> JointResidual {
    let joints = problem.joints.iter().enumerate();
    let square = |fitted: &FittedModel, j: usize| fitted.left_out.mean_square(j, fitted.fit.sd[j]);
    let total = |fitted: &FittedModel| {
        (joints.clone())
            .map(|(j, joint)| square(fitted, j) / joint.scales.effort.powi(2).max(f64::MIN_POSITIVE))
            .sum::<f64>()
    };
    let effort_rms = |j: usize| {
        let gain = found.best.fit.gain(j);
        let gain = gain.map_or(1.0, |gain| gain.abs() / problem.joints[j].reference_gain);
        gain * square(&found.best, j).sqrt()
    };
    let unit = |is_hinge: bool| Unit::Effort.text(is_hinge, problem.effort_unit);
    let found_regime = match verdict {
        Verdict::Consistent => None,
        _ => regime(problem, &found.best, worst_joint(after)),
    };
    JointResidual {
        effort_rms: joints.clone().map(|(j, joint)| (joint.name.clone(), effort_rms(j))).collect(),
        effort_unit: joints.clone().map(|(_, joint)| (joint.name.clone(), unit(joint.is_hinge))).collect(),
        explained: (joints.clone())
            .map(|(j, joint)| (joint.name.clone(), explained(problem, found, &[j])))
            .collect(),
        share: Some(total(&found.best) / total(&found.base).max(f64::MIN_POSITIVE)),
        regime_kind: found_regime.as_ref().map(|r| r.kind),
        regime: found_regime.map(|r| r.description),
    }
}

/// The joint with the largest lack of fit.
fn worst_joint(lack: &[LackOfFit]) -> usize {
    (0..lack.len()).max_by(|a, b| lack[*a].mean_square.total_cmp(&lack[*b].mean_square)).unwrap_or(0)
}

fn before_after(problem: &Problem, before: &Fit, after: &Fit, held_out: bool) -> Option<JointBeforeAfter> {
    let (before, after) =
        (error_metrics(problem, before, held_out)?, error_metrics(problem, after, held_out)?);
    Some(JointBeforeAfter { before, after })
}

/// Share by which an effect reduces the held-out misfit of efforts, negative if it increases it; on training episodes if none
/// are held out.
fn reduction(problem: &Problem, simpler: &Fit, best: &Fit) -> Option<f64> {
    let misfit = |fit: &Fit| {
        let found = error_metrics(problem, fit, true).or_else(|| error_metrics(problem, fit, false))?;
        let part = |(name, errors): (&String, &JointErrorMetrics)| {
            let joint = problem.joints.iter().find(|joint| joint.name == *name)?;
            Some((errors.effort_rmse? / joint.scales.effort).powi(2))
        };
        Some(found.joints.iter().filter_map(part).sum::<f64>())
    };
    let (without, with) = (misfit(simpler)?, misfit(best)?);
    (without > 0.0).then(|| 1.0 - with / without)
}

fn reported(
    problem: &Problem,
    fit: &Fit,
    spread: &[Interval],
    index: usize,
    probability: f64,
    explains: Option<f64>,
) -> JointEffect {
    let effect = &fit.fitted_effects()[index];
    let params = effect.kind.params();
    let is_hinge = effect.kind.joint().is_none_or(|j| problem.joints[j].is_hinge);
    let mut parameters = BTreeMap::new();
    for (i, param) in params.iter().enumerate() {
        let slot = fit.slots.iter().position(|slot| slot.role == Role::Effect(index, i));
        let unit = param.unit.text(is_hinge, problem.effort_unit);
        let (mean, sd) = match slot {
            Some(k) => (fit.values[k], spread[k].sd),
            None if param.is_choice => (effect.values[i], 0.0),
            None => continue,
        };
        parameters.insert(param.name.to_owned(), Quantity { mean, sd, unit });
    }
    JointEffect {
        effect: effect.kind.effect().to_owned(),
        probability,
        statement: statement(problem, effect.kind, &parameters),
        parameters,
        place: place(problem, effect.kind),
        explains,
    }
}

/// Effects that improve the prediction of left-out parts with certainty, but not by a material share, or that explain a
/// negligible share of what was missing, each in addition to the best model. Of several names for one joint only the best is kept.
fn immaterial(
    problem: &Problem,
    searcher: &Searcher<'_>,
    found: &SearchResult,
    best: &FittedModel,
) -> Vec<JointEffect> {
    let own = best.kinds();
    let mut all: Vec<(f64, Option<usize>, JointEffect)> = vec![];
    for fitted in found.models.iter().filter(|fitted| fitted.fit.effects.len() == own.len() + 1) {
        let new = fitted.fit.effects.iter().position(|effect| !own.contains(&effect.kind));
        let (Some(k), true) = (new, own.iter().all(|kind| fitted.kinds().contains(kind))) else { continue };
        let support = searcher.support(best, fitted);
        let times = searcher.times(fitted);
        let is_small = !support.is_material() || is_spurious(searcher.share_limit(&found.base, best, fitted));
        if support.is_certain() && is_small && are_defined(problem, &fitted.fit, &times) {
            let spread = intervals(problem, &fitted.fit, &times);
            let explains = reduction(problem, &best.fit, &fitted.fit);
            let effect =
                reported(problem, &fitted.fit, &spread, k, calibrated(support.probability), explains);
            all.push((support.error_ratio, fitted.fit.effects[k].kind.joint(), effect));
        }
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut kept: Vec<(Option<usize>, JointEffect)> = vec![];
    for (_, joint, effect) in all {
        if kept.iter().all(|(other, _)| *other != joint) {
            kept.push((joint, effect));
        }
    }
    kept.into_iter().map(|(_, effect)| effect).collect()
}

fn parameters(problem: &Problem, fit: &Fit, spread: &[Interval]) -> BTreeMap<String, JointParameter> {
    let nominal = |(k, slot): (usize, &Slot)| {
        matches!(slot.role, Role::Nominal(_)).then(|| {
            let is_hinge = slot.joint.is_none_or(|j| problem.joints[j].is_hinge);
            let known = spread[k].identified;
            let parameter = JointParameter {
                mean: known.then_some(fit.values[k]),
                sd: known.then_some(spread[k].sd),
                unit: slot.unit.text(is_hinge, problem.effort_unit),
                identifiable: known,
            };
            (slot.name.clone(), parameter)
        })
    };
    fit.slots.iter().enumerate().filter_map(nominal).collect()
}

fn given(problem: &Problem) -> BTreeMap<String, f64> {
    if let Some(axis) = problem.axis {
        let known = [("inertia", axis.inertia), ("gravity_torque", axis.gravity_torque)];
        return known.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?))).collect();
    }
    if let Some(simulator) = &problem.simulator {
        let parameters = simulator.parameters.iter().filter(|_| simulator.is_given);
        return parameters.map(|p| (p.name.clone(), p.start)).collect();
    }
    let bodies = problem.bodies.iter().map(|(body, mass)| (format!("mass:{body}"), *mass));
    let joints = problem.joints.iter().zip(&problem.of_model).flat_map(|(joint, [armature, damping, _])| {
        [(format!("armature:{}", joint.name), *armature), (format!("damping:{}", joint.name), *damping)]
    });
    bodies.chain(joints).collect()
}
