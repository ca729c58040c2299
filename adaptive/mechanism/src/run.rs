//! A diagnosis of joints from start to end.

use crate::answer::{
    JointAnswer, JointBeforeAfter, JointEffect, JointFit, JointMismatch, JointNominal, JointParameter,
    JointResidual,
};
use crate::competing_models::{
    alternatives, inclusion_probability, posterior_weights, single_ties, tied_sets,
};
use crate::coupling::Coupling;
use crate::dynamics::Dynamics;
use crate::error::MechanismError;
use crate::error_metrics::error_metrics;
use crate::fit::{Fit, Freedom, MAX_STEPS, fit_with};
use crate::fitted_model::{FittedModel, SearchResult, Support};
use crate::intervals::{Interval, are_defined, intervals};
use crate::lack_of_fit::{LackOfFit, lack_of_fit};
use crate::location::{regime, shares, windows};
use crate::model::{Kind, Role, place};
use crate::motion::Motion;
use crate::outcome::JointOutcome;
use crate::probability_limits::{ProbabilityLimit, explained, probability_limits, remaining};
use crate::problem::Problem;
use crate::resting_samples::with_resting_samples;
use crate::rows::Scope;
use crate::search::Searcher;
use crate::spurious_effects::is_spurious;
use crate::statement::statement;
use crate::units::Unit;
use std::collections::BTreeMap;
use trundle_diagnose::{
    MAX_RESIDUAL_GAIN_SHARE, MAX_TIE_DIFFERENCE_NATS, MIN_MATERIAL_ERROR_RATIO, Quantity, Verdict,
    calibrated, max_given_cost,
};
use trundle_infer::Watch;
use trundle_record::JointRecording;

/// Fewest independent samples of a joint: five for each parameter of an axis with two effects.
const MIN_SAMPLES: usize = 30;
/// Reduction of the misfit, see [`explained`], below which no effect is named. On the tuning range of the benchmark four of 13
/// wrong names are below it, and no correct answer.
const MIN_EXPLANATION: f64 = 0.15;

/// Diagnose a recording of joints.
///
/// # Errors
/// If efforts cannot be used, the dynamics do not fit, there is too little motion, or the user interrupts.
pub fn diagnose_joints(
    recording: &JointRecording,
    motion: &Motion,
    dynamics: Option<&Dynamics>,
    without: &[String],
    watch: &dyn Watch,
) -> Result<JointOutcome, MechanismError> {
    let mut searched = search(Problem::new(recording, motion, dynamics)?, without, watch)?;
    // What remains may act faster than the motion: its higher frequencies are compared as well.
    if searched.is_lacking()
        && let Some(finer) = motion.finer()
    {
        searched = search(Problem::new(recording, &finer, dynamics)?, without, watch)?;
    }
    let Searched { problem, mut found, before, after } = searched;
    let searcher = Searcher::new(&problem, without, watch);
    watch.progress("lack of fit", 0.0);
    let given = given_values_suffice(&problem, &found.base, &searcher);
    let lack = [&before[..], &after[..]];
    let verdict = verdict(&found, &before, &after, &problem, given);
    let mut answer = concluded(&problem, &searcher, &mut found, verdict, lack)?;
    if verdict == Verdict::Explained && !answer.has_probable_name() {
        answer = concluded(&problem, &searcher, &mut found, Verdict::Unexplained, lack)?;
    }
    let (base, best) = (found.base.fit, found.best.fit);
    Ok(JointOutcome::new(&problem, answer, base, best))
}

/// The answer for a verdict.
fn concluded(
    problem: &Problem,
    searcher: &Searcher<'_>,
    found: &mut SearchResult,
    verdict: Verdict,
    lack: [&[LackOfFit]; 2],
) -> Result<JointAnswer, MechanismError> {
    if verdict == Verdict::Unexplained {
        found.best = found.base.clone();
        found.support.clear();
    }
    let limits = probability_limits(problem, searcher, found, lack);
    if verdict != Verdict::Unexplained {
        searcher.fit_further_children(&found.best, &mut found.models)?;
    }
    searcher.watch.progress("figures", 0.0);
    Ok(answer(problem, searcher, found, verdict, lack, &limits))
}

/// A search with the lack of fit of each joint, without and with the effects that it found.
struct Searched {
    problem: Problem,
    found: SearchResult,
    before: Vec<LackOfFit>,
    after: Vec<LackOfFit>,
}

fn search(problem: Problem, without: &[String], watch: &dyn Watch) -> Result<Searched, MechanismError> {
    require_samples(&problem)?;
    let mut found = Searcher::new(&problem, without, watch).run()?;
    let problem = match with_resting_samples(&problem, &found.best.fit) {
        Some(all) => {
            found = Searcher::new(&all, without, watch).continue_from(&found)?;
            all
        }
        None => problem,
    };
    let of = |fitted: &FittedModel| -> Vec<LackOfFit> {
        (0..problem.joints.len()).map(|j| lack_of_fit(&problem, fitted, j)).collect()
    };
    let (before, after) = (of(&found.base), of(&found.best));
    Ok(Searched { problem, found, before, after })
}

impl Searched {
    /// Whether much of a joint's misfit remains and exceeds the noise, or the effects explain little.
    fn is_lacking(&self) -> bool {
        let Self { problem, found, before, after } = self;
        let remains =
            |j: usize| after[j].exceeds_noise && remaining(found, before, after, j) > MAX_RESIDUAL_GAIN_SHARE;
        (0..after.len()).any(remains) || verdict(found, before, after, problem, None) == Verdict::Unexplained
    }
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
fn given_values_suffice(problem: &Problem, base: &FittedModel, searcher: &Searcher<'_>) -> Option<bool> {
    if problem.axis.is_some() || problem.simulator.as_ref().is_some_and(|simulator| !simulator.is_given) {
        return None;
    }
    let fixed = fit_with(problem, &[], None, Scope::Training, MAX_STEPS, Freedom::Timing);
    let values = fixed.slots.iter().filter(|slot| !slot.is_timing()).count();
    let times = searcher.times(base);
    let cost = fixed.cost(&times) - base.fit.cost(&times);
    let ratio = (0..times.len())
        .filter(|j| fixed.samples[*j] > 0)
        .map(|j| (fixed.sd[j] / base.fit.sd[j]).powi(2))
        .fold(1.0, f64::max);
    Some(cost <= max_given_cost(values) || ratio < MIN_MATERIAL_ERROR_RATIO)
}

fn verdict(
    found: &SearchResult,
    before: &[LackOfFit],
    after: &[LackOfFit],
    problem: &Problem,
    given: Option<bool>,
) -> Verdict {
    let is_lacking = |j: usize| match found.best.fit.effects.is_empty() {
        true => after[j].exceeds_noise,
        false => after[j].is_material && remaining(found, before, after, j) > MAX_RESIDUAL_GAIN_SHARE,
    };
    let coupling = Coupling::of(problem);
    let is_poor = |kind: &Kind| match coupling.acts_on(*kind) {
        Some(joints) => joints.iter().all(|j| explained(problem, found, &[*j]) < MIN_EXPLANATION),
        None => false,
    };
    let has_lack = (0..problem.joints.len()).any(is_lacking) || found.best.kinds().iter().any(is_poor);
    match (found.best.fit.effects.is_empty(), has_lack) {
        (_, true) => Verdict::Unexplained,
        (false, false) => Verdict::Explained,
        (true, false) if given == Some(false) => Verdict::Reparameterised,
        (true, false) => Verdict::Consistent,
    }
}

fn answer(
    problem: &Problem,
    searcher: &Searcher<'_>,
    found: &mut SearchResult,
    verdict: Verdict,
    [before, after]: [&[LackOfFit]; 2],
    limits: &[ProbabilityLimit],
) -> JointAnswer {
    let times = searcher.times(&found.best);
    let best = found.best.clone();
    let immaterial = immaterial(problem, searcher, found, &best);
    let bound = best.log_evidence(&times) - 2.0 * MAX_TIE_DIFFERENCE_NATS;
    found.models = searcher.supported(&best, &mut found.models, &times, bound);
    let weights = posterior_weights(searcher, found, &times);
    let spread = intervals(problem, &best.fit, &times);
    let mut missing: Vec<JointEffect> = vec![];
    for (k, limit) in limits.iter().enumerate() {
        let simpler = searcher.without_effect(&best, k, &mut found.models);
        let support = found.support.get(k).copied().unwrap_or(Support {
            probability: 0.5,
            error_ratio: 1.0,
            may_be_noise: false,
        });
        let kind = best.fit.effects[k].kind;
        let chance = support.probability.min(inclusion_probability(found, &weights, kind));
        let explains = reduction(problem, &simpler.fit, &best.fit);
        let probability = (limit.share * calibrated(chance)).min(limit.most).min(support.share());
        missing.push(reported(problem, &best.fit, &spread, k, probability, explains));
    }
    missing.sort_by(|a, b| b.explains.unwrap_or(0.0).total_cmp(&a.explains.unwrap_or(0.0)));
    let tied = tied_sets(problem, found, &times);
    let worst =
        (0..after.len()).max_by(|a, b| after[*a].mean_square.total_cmp(&after[*b].mean_square)).unwrap_or(0);
    let square = |fitted: &FittedModel, j: usize| fitted.left_out.mean_square(j, fitted.fit.sd[j]);
    let total = |fitted: &FittedModel| {
        (0..times.len())
            .map(|j| square(fitted, j) / problem.joints[j].scales.effort.powi(2).max(f64::MIN_POSITIVE))
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
            explained: (0..times.len())
                .map(|j| (problem.joints[j].name.clone(), explained(problem, found, &[j])))
                .collect(),
            share: Some(total(&found.best) / total(&found.base).max(f64::MIN_POSITIVE)),
            regime: if is_consistent { None } else { regime(problem, &found.best, worst) },
        },
        warnings: crate::warnings::warnings(problem, &found.best.fit),
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
    let (before, after) =
        (error_metrics(problem, before, held_out)?, error_metrics(problem, after, held_out)?);
    Some(JointBeforeAfter { before, after })
}

/// Share by which an effect reduces the held-out misfit of efforts, negative if it increases it; on training episodes if none
/// are held out.
fn reduction(problem: &Problem, simpler: &Fit, best: &Fit) -> Option<f64> {
    let misfit = |fit: &Fit| {
        let found = error_metrics(problem, fit, true).or_else(|| error_metrics(problem, fit, false))?;
        let part = |(name, errors): (&String, &crate::error_metrics::JointErrorMetrics)| {
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
