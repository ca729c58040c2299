//! Two explanations of a recording, and their separation by planned motions.

use super::competing_model::{CompetingModel, GivenEffect};
use super::limits::{JointLimits, recorded_limits};
use super::plan::Plan;
use super::predicted_commands::predicted_commands;
use super::separation::misfit_after_refit;
use crate::candidates::candidates;
use crate::drive::Drive;
use crate::error::MechanismError;
use crate::model::{Kind, label};
use crate::motion::Motion;
use crate::outcome::FittedMechanism;
use crate::problem::Problem;
use crate::search::Searcher;
use nalgebra::DMatrix;
use serde::Serialize;
use trundle_infer::Watch;

/// Expected separation by a planned motion.
#[derive(Clone, Debug, Serialize)]
pub struct Separation {
    /// Expected log-likelihood ratio against the best refit of the other model if the first model is true, and if the
    /// second is, nats. `None` if no command makes that mechanism follow the motion.
    pub nats: [Option<f64>; 2],
    /// Largest effort of the drive of each joint under either model.
    pub effort: Vec<f64>,
    /// Number of compared samples of each joint.
    pub samples: Vec<usize>,
}

/// Name of an effect, `KIND:PLACE`, and starting values of its parameters by name.
pub type NamedEffect = (String, Vec<(String, f64)>);

/// Two explanations of a recording.
#[derive(Clone, Debug)]
pub struct JointDesigner {
    problem: Problem,
    /// The problem without episodes.
    template: Problem,
    models: [CompetingModel; 2],
    /// Standard deviation of an independent compared sample of each joint.
    noise: Vec<f64>,
    /// Log-likelihood ratio of the recording in favour of the first model, nats.
    recorded: f64,
    /// What the recording tells about the parameters of each model.
    information: [DMatrix<f64>; 2],
    limits: Vec<JointLimits>,
    filter_sd: f64,
}

impl JointDesigner {
    /// Fit both explanations to a recording: effects by name with starting values of parameters by name.
    ///
    /// # Errors
    /// If an effect is unknown or cannot be fitted, a joint has no drive, or the user interrupts.
    pub fn new(
        problem: Problem,
        motion: &Motion,
        explanations: [&[NamedEffect]; 2],
        watch: &dyn Watch,
    ) -> Result<Self, MechanismError> {
        require_drives(&problem)?;
        let searcher = Searcher::new(&problem, &[], watch);
        let mut models = vec![];
        for effects in explanations {
            let given = effects.iter().map(|(name, values)| given(&problem, name, values));
            models.push(CompetingModel::new(&searcher, &given.collect::<Result<Vec<_>, _>>()?)?);
        }
        let Ok(models) = <[CompetingModel; 2]>::try_from(models) else {
            return Err(unsuitable(&problem, "there are no two explanations", "give two"));
        };
        if models[0].kinds() == models[1].kinds() {
            let remedy = "compare explanations with different effects";
            return Err(unsuitable(&problem, "both explanations have the same effects", remedy));
        }
        // Both models see the same noise, which is no larger and no slower than the residual of the better one.
        let smaller = |of: &dyn Fn(&CompetingModel, usize) -> f64| -> Vec<f64> {
            (0..problem.joints.len()).map(|j| of(&models[0], j).min(of(&models[1], j))).collect()
        };
        let times = smaller(&|model, j| model.times[j]);
        let noise = smaller(&|model, j| model.fit.sd[j] * times[j].sqrt());
        let recorded = models[1].fit.cost(&times) - models[0].fit.cost(&times);
        let information = models.each_ref().map(|model| model.information(&problem, &noise));
        let limits = (0..problem.joints.len()).map(|j| recorded_limits(&problem, motion, j)).collect();
        let template = Problem { episodes: vec![], ..problem.clone() };
        Ok(Self {
            problem,
            template,
            models,
            noise,
            recorded,
            information,
            limits,
            filter_sd: motion.stages.both(),
        })
    }

    /// Names of the effects of both models.
    #[must_use]
    pub fn names(&self) -> [Vec<String>; 2] {
        let name = |kind: &Kind| label(&self.problem, *kind);
        self.models.each_ref().map(|model| model.kinds().iter().map(name).collect())
    }

    /// Which motion or rig identifies the effects best, for each effect that only one of the models has.
    #[must_use]
    pub fn advice(&self) -> Vec<String> {
        let [first, second] = self.models.each_ref().map(CompetingModel::kinds);
        let different = |own: &[Kind], other: &[Kind]| -> Vec<Kind> {
            own.iter().filter(|kind| !other.contains(kind)).copied().collect()
        };
        let all = [different(&first, &second), different(&second, &first)].concat();
        all.iter()
            .map(|kind| format!("{}: {}", label(&self.problem, *kind), kind.spec().experiment))
            .collect()
    }

    /// Log-likelihood ratio of the recording in favour of the first model, nats.
    #[must_use]
    pub fn recorded(&self) -> f64 {
        self.recorded
    }

    /// Whether neither model explains the recording.
    #[must_use]
    pub fn is_unexplained(&self) -> bool {
        self.models.iter().all(|model| model.unexplained.contains(&true))
    }

    /// The fitted models.
    #[must_use]
    pub fn fitted(&self) -> [FittedMechanism; 2] {
        self.models.each_ref().map(|model| FittedMechanism::new(&self.problem, &model.fit))
    }

    /// Recorded limits of each joint.
    #[must_use]
    pub fn limits(&self) -> &[JointLimits] {
        &self.limits
    }

    /// Time between the samples of a plan, s.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.problem.episodes.iter().find(|e| !e.held_out).map_or(self.filter_sd, |e| e.dt)
    }

    /// Standard deviation of an independent sample of the effort of each joint.
    #[must_use]
    pub fn noise(&self) -> &[f64] {
        &self.noise
    }

    /// Unit of the efforts of each joint.
    #[must_use]
    pub fn effort_units(&self) -> Vec<&'static str> {
        let text = |is_hinge| crate::units::Unit::Effort.text(is_hinge, self.problem.effort_unit);
        self.problem.joints.iter().map(|joint| text(joint.is_hinge)).collect()
    }

    /// Separation of the models by a planned motion.
    ///
    /// # Errors
    /// If its arrays do not fit the mechanism.
    pub fn separation(&self, plan: &Plan) -> Result<Separation, MechanismError> {
        let Some(recorded) = self.problem.episodes.iter().find(|e| !e.held_out) else {
            return Err(unsuitable(
                &self.problem,
                "there is no training episode",
                "do not hold out all of them",
            ));
        };
        let mut planned = plan.problem(&self.template, recorded, self.filter_sd)?;
        let mut effort = vec![0.0f64; self.problem.joints.len()];
        let mut nats = [None; 2];
        for (truth, other) in [(0, 1), (1, 0)] {
            let commands = predicted_commands(&planned, &self.models[truth].fit);
            for (j, command) in commands.into_iter().enumerate() {
                planned.episodes[0].joints[j].command = command;
                effort[j] = effort[j].max(self.largest_effort(&planned, truth, j));
            }
            let fits = [truth, other].map(|k| &self.models[k].fit);
            nats[truth] = misfit_after_refit(&planned, fits, &self.noise, &self.information[other]);
        }
        let samples = planned.episodes[0].joints.iter().map(|series| series.kept.len()).collect();
        Ok(Separation { nats, effort, samples })
    }

    fn largest_effort(&self, planned: &Problem, model: usize, j: usize) -> f64 {
        let series = &planned.episodes[0].joints[j];
        let drive = planned.joints[j].drive;
        let sizes = (0..series.q.len()).map(|k| series.command_error(drive, k).abs());
        sizes.fold(0.0, f64::max) * self.gain(model, j)
    }

    /// Size of the gain of a joint's drive in a model.
    fn gain(&self, model: usize, j: usize) -> f64 {
        let fit = &self.models[model].fit;
        let own =
            crate::equation::JointModel::new(&self.problem, j, &fit.effects, &fit.slots, |k| fit.values[k]);
        let recorded = self.problem.episodes.iter().find(|e| !e.held_out);
        recorded.map_or(1.0, |episode| own.gain_of(&episode.joints[j]).abs())
    }
}

fn unsuitable(problem: &Problem, reason: &str, remedy: &str) -> MechanismError {
    MechanismError::Unsuitable {
        recording: problem.name.clone(),
        reason: reason.to_owned(),
        remedy: remedy.to_owned(),
    }
}

fn require_drives(problem: &Problem) -> Result<(), MechanismError> {
    let Some(joint) = problem.joints.iter().find(|joint| joint.drive == Drive::None) else { return Ok(()) };
    Err(unsuitable(
        problem,
        &format!("joint {} has no drive, so that it cannot be made to follow a trajectory", joint.name),
        "record effort_JOINT or target_JOINT of every joint; without a drive, start free motion from other positions \
         and with another load",
    ))
}

fn given(problem: &Problem, name: &str, values: &[(String, f64)]) -> Result<GivenEffect, MechanismError> {
    let candidates = candidates(problem);
    let Some(kind) = candidates.iter().find(|kind| label(problem, **kind) == name) else {
        let known: Vec<String> = candidates.iter().map(|kind| label(problem, *kind)).collect();
        return Err(unsuitable(
            problem,
            &format!("effect {name} is unknown, or cannot be added to this mechanism"),
            &format!("effects are {}", known.join(", ")),
        ));
    };
    if values.is_empty() {
        return Ok((*kind, None));
    }
    let mut found: Vec<f64> =
        kind.starts(problem).into_iter().next().unwrap_or_else(|| vec![f64::NAN; kind.params().len()]);
    for (key, value) in values {
        let place = kind.params().iter().position(|param| param.name == key);
        let known: Vec<&str> = kind.params().iter().map(|param| param.name).collect();
        let place = place.ok_or_else(|| {
            unsuitable(
                problem,
                &format!("effect {name} has no parameter {key}"),
                &format!("parameters are {}", known.join(", ")),
            )
        })?;
        found[place] = *value;
    }
    Ok((*kind, Some(found)))
}
