//! Results of a diagnosis of joints.

use crate::answer::JointAnswer;
use crate::error_metrics::{EpisodeErrors, OpenLoop, episode_errors, open_loop};
use crate::fit::Fit;
use crate::laws::{JointSample, Law, law_terms};
use crate::model::{Effect, Kind};
use crate::payload_statement::state_payloads;
use crate::problem::Problem;
use crate::warnings::held_out_warnings;
use std::collections::BTreeMap;
use trundle_diagnose::{ErrorMetric, harmful_effect};

/// Results of a diagnosis of joints.
#[derive(Clone, Debug)]
pub struct JointOutcome {
    /// `diagnosis.json`.
    pub answer: JointAnswer,
    /// The mechanism before and after.
    pub models: [FittedMechanism; 2],
    /// Open-loop simulations of an axis in each held-out episode: before and after.
    pub predictions: BTreeMap<String, [Option<OpenLoop>; 2]>,
    /// Residuals of the mechanism "after".
    errors: Vec<EpisodeErrors>,
}

impl JointOutcome {
    pub(crate) fn new(problem: &Problem, mut answer: JointAnswer, before: Fit, after: Fit) -> Self {
        state_payloads(problem, &after, &mut answer);
        let held_out = problem.episodes.iter().filter(|episode| episode.held_out);
        let of = |episode| [&before, &after].map(|fit| open_loop(problem, fit, episode));
        let predictions = held_out.map(|episode| (episode.name.clone(), of(episode))).collect();
        let models = [&before, &after].map(|fit| FittedMechanism::new(problem, fit));
        let errors = episode_errors(problem, &after);
        Self { answer, models, predictions, errors }
    }

    /// Warnings about held-out episodes; `metrics` are their errors before and after, of positions and efforts.
    #[must_use]
    pub fn held_out_warnings(&self, metrics: &[ErrorMetric]) -> Vec<String> {
        let mut found = held_out_warnings(&self.errors, metrics);
        if !self.predictions.is_empty() {
            let named = self.answer.missing.iter();
            found.extend(named.filter_map(|effect| harmful_effect(&effect.effect, effect.explains)));
        }
        found
    }
}

/// A mechanism with fitted parameters and effects.
#[derive(Clone, Debug)]
pub struct FittedMechanism {
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Names of the bodies.
    pub bodies: Vec<String>,
    /// Refitted parameters of the nominal mechanism by name.
    pub nominal: BTreeMap<String, f64>,
    /// Effects with their values.
    pub effects: Vec<Effect>,
    /// The laws of each joint.
    laws: Vec<Vec<Law<f64>>>,
}

impl FittedMechanism {
    pub(crate) fn new(problem: &Problem, fit: &Fit) -> Self {
        let nominal = |(slot, value): (&crate::model::Slot, &f64)| {
            matches!(slot.role, crate::model::Role::Nominal(_)).then(|| (slot.name.clone(), *value))
        };
        let effects = fit.fitted_effects();
        let of_joint = |j: usize| -> Vec<Law<f64>> {
            let law = |effect: &Effect| match effect.kind {
                Kind::Joint(kind, joint) if joint == j => Some(Law::of(kind, &effect.values)),
                _ => None,
            };
            effects.iter().filter_map(law).collect()
        };
        Self {
            joints: problem.joints.iter().map(|joint| joint.name.clone()).collect(),
            bodies: problem.bodies.iter().map(|(name, _)| name.clone()).collect(),
            nominal: fit.slots.iter().zip(&fit.values).filter_map(nominal).collect(),
            laws: (0..problem.joints.len()).map(of_joint).collect(),
            effects,
        }
    }

    /// Effort, level of dry friction and added inertia of the laws of joint `j` at a state.
    #[must_use]
    pub fn terms(&self, j: usize, at: &JointSample<f64>) -> [f64; 3] {
        law_terms(&self.laws[j], at)
    }
}
