//! A diagnosis of joints from start to end.

use crate::answer::{
    JointAlternative, JointAnswer, JointBeforeAfter, JointEffect, JointFit, JointMismatch, JointNominal,
    JointParameter, JointResidual,
};
use crate::error::MechanismError;
use crate::figures::figures;
use crate::fit::{Fit, fit};
use crate::intervals::{Interval, are_defined, intervals};
use crate::lack_of_fit::{LackOfFit, lack_of_fit};
use crate::location::{regime, shares, windows};
use crate::model::{Kind, Role, label};
use crate::outcome::JointOutcome;
use crate::problem::Problem;
use crate::rows::Scope;
use crate::search::{Found, Searcher, Support, Tried};
use crate::statement::statement;
use crate::units::Unit;
use std::collections::BTreeMap;
use trundle_diagnose::{
    MAX_RESIDUAL_GAIN_SHARE, MAX_TIE_DIFFERENCE_NATS, MIN_MATERIAL_ERROR_RATIO, Quantity, Verdict,
    calibrated, max_given_cost,
};
use trundle_infer::Watch;

/// Fewest independent samples of a joint: five for each parameter of an axis with two effects.
const MIN_SAMPLES: usize = 30;
/// Least probability of an alternative that is reported.
const MIN_ALTERNATIVE_PROBABILITY: f64 = 0.005;

/// Diagnose a recording of joints.
///
/// # Errors
/// If there is too little motion, or the user interrupts.
pub fn diagnose_joints(
    problem: &Problem,
    without: &[String],
    watch: &dyn Watch,
) -> Result<JointOutcome, MechanismError> {
    require_samples(problem)?;
    let searcher = Searcher { problem, without, watch };
    let mut found = searcher.run()?;
    watch.progress("lack of fit", 0.0);
    let joints = 0..problem.joints.len();
    let before: Vec<LackOfFit> = joints.clone().map(|j| lack_of_fit(problem, &found.base, j)).collect();
    let after: Vec<LackOfFit> = joints.clone().map(|j| lack_of_fit(problem, &found.best, j)).collect();
    let given = given_values_suffice(problem, &found.base, &searcher);
    let verdict = verdict(&found, &before, &after, problem, given);
    if verdict == Verdict::Unexplained {
        found.best = found.base.clone();
        found.support.clear();
    }
    watch.progress("figures", 0.0);
    let answer = answer(problem, &searcher, &mut found, verdict, [&before, &after]);
    let (base, best) = (found.base.fit, found.best.fit);
    Ok(JointOutcome::new(problem, answer, base, best))
}

fn require_samples(problem: &Problem) -> Result<(), MechanismError> {
    let most = (0..problem.joints.len()).map(|j| problem.samples(j)).max().unwrap_or(0);
    if most >= MIN_SAMPLES {
        return Ok(());
    }
    Err(MechanismError::Unsuitable {
        recording: problem.name.clone(),
        reason: format!(
            "the joints move in {most} independent samples of the training episodes, and {MIN_SAMPLES} are needed"
        ),
        remedy: "record longer or faster motion".to_owned(),
    })
}

/// Whether the values of the model predict left-out parts as well as the refitted ones; `None` if none are given.
fn given_values_suffice(problem: &Problem, base: &Tried, searcher: &Searcher<'_>) -> Option<bool> {
    if problem.axis.is_some() || problem.simulator.as_ref().is_some_and(|simulator| !simulator.is_given) {
        return None;
    }
    let fixed = fit(problem, &[], None, Scope::Training, 0);
    let times = searcher.times(base);
    let cost = fixed.cost(&times) - base.fit.cost(&times);
    let ratio = (0..times.len())
        .filter(|j| fixed.samples[*j] > 0)
        .map(|j| (fixed.sd[j] / base.fit.sd[j]).powi(2))
        .fold(1.0, f64::max);
    Some(cost <= max_given_cost(fixed.slots.len()) || ratio < MIN_MATERIAL_ERROR_RATIO)
}

fn verdict(
    found: &Found,
    before: &[LackOfFit],
    after: &[LackOfFit],
    problem: &Problem,
    given: Option<bool>,
) -> Verdict {
    let is_lacking =
        |j: usize| after[j].is_material && remaining(found, before, after, j) > MAX_RESIDUAL_GAIN_SHARE;
    let has_lack = (0..problem.joints.len()).any(is_lacking);
    match (found.best.fit.effects.is_empty(), has_lack) {
        (_, true) => Verdict::Unexplained,
        (false, false) => Verdict::Explained,
        (true, false) if given == Some(false) => Verdict::Reparameterised,
        (true, false) => Verdict::Consistent,
    }
}

/// Share of a joint's misfit beyond noise that remains with the effects.
fn remaining(found: &Found, before: &[LackOfFit], after: &[LackOfFit], j: usize) -> f64 {
    let square = |tried: &Tried| tried.left_out.mean_square(j, tried.fit.sd[j]);
    let gained = (square(&found.base) - square(&found.best)).max(0.0);
    let missing = before[j].mean_square.max(gained + after[j].mean_square);
    if missing > 0.0 { after[j].mean_square.max(0.0) / missing } else { 0.0 }
}

fn answer(
    problem: &Problem,
    searcher: &Searcher<'_>,
    found: &mut Found,
    verdict: Verdict,
    [before, after]: [&[LackOfFit]; 2],
) -> JointAnswer {
    let times = searcher.times(&found.best);
    let best = found.best.clone();
    let immaterial = immaterial(problem, searcher, found, &best);
    let bound = best.log_evidence(&times) - 2.0 * MAX_TIE_DIFFERENCE_NATS;
    found.tried = searcher.supported(&mut found.tried, &times, bound);
    let weights = weights(found, &times);
    let spread = intervals(problem, &best.fit, &times);
    let mut missing: Vec<JointEffect> = vec![];
    for k in 0..best.fit.effects.len() {
        let simpler = searcher.without_effect(&best, k, &mut found.tried);
        let support = found.support.get(k).copied().unwrap_or(Support { probability: 0.5, error_ratio: 1.0 });
        let kind = best.fit.effects[k].kind;
        let chance = support.probability.min(probability_of(found, &weights, kind));
        let left = |j: usize| remaining(found, before, after, j);
        // Effects that leave much of the misfit are less probably the right ones.
        let explained =
            1.0 - kind.joint().map_or_else(|| (0..times.len()).map(left).fold(0.0, f64::max), left);
        let explains = rise(problem, &simpler.fit, &best.fit);
        missing.push(reported(problem, &best.fit, &spread, k, calibrated(chance).min(explained), explains));
    }
    missing.sort_by(|a, b| b.explains.unwrap_or(0.0).total_cmp(&a.explains.unwrap_or(0.0)));
    let tied = tied(problem, found, &times);
    let worst =
        (0..after.len()).max_by(|a, b| after[*a].mean_square.total_cmp(&after[*b].mean_square)).unwrap_or(0);
    let square = |tried: &Tried, j: usize| tried.left_out.mean_square(j, tried.fit.sd[j]);
    let total = |tried: &Tried| {
        (0..times.len())
            .map(|j| square(tried, j) / problem.joints[j].scales.effort.powi(2).max(f64::MIN_POSITIVE))
            .sum::<f64>()
    };
    let is_consistent = verdict == Verdict::Consistent;
    JointAnswer {
        format: "trundle-diagnosis/1",
        recording: problem.name.clone(),
        verdict,
        alternatives: alternatives(problem, found, &weights),
        tied_sets: if tied.len() > 1 { vec![tied.clone()] } else { vec![] },
        tied: single_ties(&tied),
        immaterial: if verdict == Verdict::Unexplained { vec![] } else { immaterial },
        mismatch: JointMismatch {
            joints: shares(problem, &found.base, &found.best, before),
            regime: if is_consistent { None } else { regime(problem, &found.base, worst) },
            windows: if is_consistent { vec![] } else { windows(problem, &found.base) },
        },
        residual: JointResidual {
            effort_rms: (0..times.len())
                .map(|j| {
                    let joint = &problem.joints[j];
                    let gain = best.fit.gain(j).map_or(1.0, |gain| gain.abs() / joint.reference_gain);
                    (joint.name.clone(), gain * square(&found.best, j).sqrt())
                })
                .collect(),
            effort_unit: problem
                .joints
                .iter()
                .map(|joint| (joint.name.clone(), Unit::Effort.text(joint.is_hinge, problem.effort_unit)))
                .collect(),
            share: Some(total(&found.best) / total(&found.base).max(f64::MIN_POSITIVE)),
            regime: if is_consistent { None } else { regime(problem, &found.best, worst) },
        },
        warnings: crate::warnings::warnings(problem, &found.base.fit, &found.best.fit, verdict),
        nominal: JointNominal {
            given: given(problem),
            before: parameters(
                problem,
                &found.base.fit,
                &intervals(problem, &found.base.fit, &searcher.times(&found.base)),
            ),
            after: parameters(problem, &best.fit, &spread),
        },
        fit: JointFit {
            held_out: before_after(problem, &found.base.fit, &found.best.fit, true),
            training: before_after(problem, &found.base.fit, &found.best.fit, false),
        },
        missing,
    }
}

fn before_after(problem: &Problem, before: &Fit, after: &Fit, held_out: bool) -> Option<JointBeforeAfter> {
    let (before, after) = (figures(problem, before, held_out)?, figures(problem, after, held_out)?);
    Some(JointBeforeAfter { before, after })
}

/// Posterior weight of every tried model that has as many effects as the best one, at least.
fn weights(found: &Found, times: &[f64]) -> Vec<f64> {
    let logs: Vec<f64> = found.tried.iter().map(|tried| tried.log_evidence(times)).collect();
    let best = logs.iter().copied().fold(found.best.log_evidence(times), f64::max);
    let raw: Vec<f64> = logs.iter().map(|log| (log - best).exp()).collect();
    let total: f64 = raw.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    raw.iter().map(|weight| weight / total).collect()
}

/// Share of the weight of models with an effect, among models no larger than the best one.
fn probability_of(found: &Found, weights: &[f64], kind: Kind) -> f64 {
    let most = found.best.fit.effects.len();
    let of = |with: bool| -> f64 {
        let pairs = found.tried.iter().zip(weights).filter(|(tried, _)| tried.fit.effects.len() <= most);
        pairs.filter(|(tried, _)| !with || tried.kinds().contains(&kind)).map(|(_, weight)| weight).sum()
    };
    let all = of(false);
    if all > 0.0 { of(true) / all } else { 1.0 }
}

/// Share by which the held-out misfit of efforts rises without an effect; on training episodes if none are held out.
fn rise(problem: &Problem, simpler: &Fit, best: &Fit) -> Option<f64> {
    let misfit = |fit: &Fit| {
        let found = figures(problem, fit, true).or_else(|| figures(problem, fit, false))?;
        let part = |(name, figures): (&String, &crate::figures::JointFigures)| {
            let joint = problem.joints.iter().find(|joint| joint.name == *name)?;
            Some((figures.effort_rmse? / joint.scales.effort).powi(2))
        };
        Some(found.joints.iter().filter_map(part).sum::<f64>())
    };
    let (without, with) = (misfit(simpler)?, misfit(best)?);
    (without > 0.0).then(|| (1.0 - with / without).max(0.0))
}

fn place(problem: &Problem, kind: Kind) -> Option<BTreeMap<&'static str, String>> {
    match kind {
        Kind::Payload(body) => Some(BTreeMap::from([("body", problem.bodies[body].0.clone())])),
        _ => kind.joint().map(|j| BTreeMap::from([("joint", problem.joints[j].name.clone())])),
    }
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

/// Effects that improve the prediction of left-out parts with certainty, but not by a material share, each in addition to
/// the best model. Of several names for one joint only the best is kept.
fn immaterial(problem: &Problem, searcher: &Searcher<'_>, found: &Found, best: &Tried) -> Vec<JointEffect> {
    let own = best.kinds();
    let mut all: Vec<(f64, Option<usize>, JointEffect)> = vec![];
    for tried in found.tried.iter().filter(|tried| tried.fit.effects.len() == own.len() + 1) {
        let new = tried.fit.effects.iter().position(|effect| !own.contains(&effect.kind));
        let (Some(k), true) = (new, own.iter().all(|kind| tried.kinds().contains(kind))) else { continue };
        let support = searcher.support(best, tried);
        let times = searcher.times(tried);
        if support.is_certain() && !support.is_material() && are_defined(problem, &tried.fit, &times) {
            let spread = intervals(problem, &tried.fit, &times);
            let explains = rise(problem, &best.fit, &tried.fit);
            let effect = reported(problem, &tried.fit, &spread, k, calibrated(support.probability), explains);
            all.push((support.error_ratio, tried.fit.effects[k].kind.joint(), effect));
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

/// Sets of effects whose models fit as well as the best one, its own first.
fn tied(problem: &Problem, found: &Found, times: &[f64]) -> Vec<Vec<String>> {
    let names =
        |tried: &Tried| -> Vec<String> { tried.kinds().iter().map(|kind| label(problem, *kind)).collect() };
    let best = &found.best;
    if best.fit.effects.is_empty() {
        return vec![];
    }
    let mut sets = vec![names(best)];
    for tried in &found.tried {
        // The data determine no more parameters, and the fit is as good; or the evidence is.
        let close = tried.fit.cost(times) - best.fit.cost(times) < MAX_TIE_DIFFERENCE_NATS;
        let is_as_simple = tried.fit.rank < best.fit.rank + 1.0;
        let difference = best.log_evidence(times) - tried.log_evidence(times);
        let is_like = close && is_as_simple || difference < MAX_TIE_DIFFERENCE_NATS;
        let is_as_many = tried.fit.effects.len() == best.fit.effects.len();
        if is_like && is_as_many && !sets.contains(&names(tried)) {
            sets.push(names(tried));
        }
    }
    sets
}

/// Classes of single effects among tied sets that differ in one effect.
fn single_ties(sets: &[Vec<String>]) -> Vec<Vec<String>> {
    let Some((best, others)) = sets.split_first() else { return vec![] };
    let mut ties: Vec<Vec<String>> = vec![];
    for other in others {
        let own: Vec<&String> = best.iter().filter(|name| !other.contains(name)).collect();
        let new: Vec<&String> = other.iter().filter(|name| !best.contains(name)).collect();
        if let ([own], [new]) = (&own[..], &new[..]) {
            match ties.iter_mut().find(|class| class[0] == **own) {
                Some(class) => class.push((*new).clone()),
                None => ties.push(vec![(*own).clone(), (*new).clone()]),
            }
        }
    }
    ties
}

fn alternatives(problem: &Problem, found: &Found, weights: &[f64]) -> Vec<JointAlternative> {
    let own = found.best.kinds();
    let mut all: Vec<JointAlternative> = vec![];
    for (tried, weight) in found.tried.iter().zip(weights) {
        let new: Vec<Kind> = tried.kinds().into_iter().filter(|kind| !own.contains(kind)).collect();
        let [kind] = new[..] else { continue };
        if tried.fit.effects.len() > own.len() || *weight < MIN_ALTERNATIVE_PROBABILITY {
            continue;
        }
        let found_place = place(problem, kind);
        if all.iter().all(|one| one.effect != kind.effect() || one.place != found_place) {
            all.push(JointAlternative {
                effect: kind.effect().to_owned(),
                probability: *weight,
                experiment: kind.spec().experiment.to_owned(),
                place: found_place,
            });
        }
    }
    all.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    all
}

fn parameters(problem: &Problem, fit: &Fit, spread: &[Interval]) -> BTreeMap<String, JointParameter> {
    let nominal = |(k, slot): (usize, &crate::model::Slot)| {
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
