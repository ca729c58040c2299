//! A diagnosis of joints from start to end.

use crate::answer::JointAnswer;
use crate::coupling::Coupling;
use crate::dynamics::Dynamics;
use crate::error::MechanismError;
use crate::fit::{Freedom, MAX_STEPS, fit_with};
use crate::fitted_model::{FittedModel, SearchResult};
use crate::lack_of_fit::{LackOfFit, lack_of_fit};
use crate::model::Kind;
use crate::motion::Motion;
use crate::outcome::JointOutcome;
use crate::probability_limits::{explained, probability_limits, remaining};
use crate::problem::Problem;
use crate::report::answer;
use crate::resting_samples::with_resting_samples;
use crate::rows::Scope;
use crate::search::Searcher;
use trundle_diagnose::{MAX_RESIDUAL_GAIN_SHARE, MIN_MATERIAL_ERROR_RATIO, Verdict, max_given_cost};
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
