//! A model that is fitted to a recording, with what the recording tells about its parameters.

use crate::error::MechanismError;
use crate::fit::Fit;
use crate::lack_of_fit::lack_of_fit;
use crate::model::{Kind, label};
use crate::problem::Problem;
use crate::rows::{Scope, evaluate, normal_equations};
use crate::search::Searcher;
use nalgebra::DMatrix;

/// An effect and starting values of its parameters, if they are given.
pub(super) type GivenEffect = (Kind, Option<Vec<f64>>);

/// A fitted model.
#[derive(Clone, Debug)]
pub(super) struct CompetingModel {
    pub fit: Fit,
    /// Correlation time of each joint's residual, samples.
    pub times: Vec<f64>,
    /// Joints whose residuals the model does not explain.
    pub unexplained: Vec<bool>,
}

impl CompetingModel {
    /// Fit the model with some effects to the training episodes.
    pub fn new(searcher: &Searcher<'_>, effects: &[GivenEffect]) -> Result<Self, MechanismError> {
        let problem = searcher.problem;
        let model = searcher.with_effects(effects).map_err(|kind| MechanismError::Unsuitable {
            recording: problem.name.clone(),
            reason: format!("{} cannot be fitted to the recording", label(problem, kind)),
            remedy: "compare another explanation, or record more motion".to_owned(),
        })?;
        let times = searcher.times(&model);
        let unexplained =
            (0..problem.joints.len()).map(|j| lack_of_fit(problem, &model, j).is_material).collect();
        Ok(Self { times, unexplained, fit: model.fit })
    }

    /// Kinds of its effects, sorted.
    pub fn kinds(&self) -> Vec<Kind> {
        let mut kinds: Vec<Kind> = self.fit.effects.iter().map(|effect| effect.kind).collect();
        kinds.sort();
        kinds
    }

    /// Precision of its parameters from the recording, for given standard deviations of the samples, and the prior.
    pub fn information(&self, problem: &Problem, sd: &[f64]) -> DMatrix<f64> {
        let Fit { effects, slots, values, .. } = &self.fit;
        let rows = evaluate(problem, effects, slots, values, Scope::Training, true);
        normal_equations(&rows, sd, slots, values, &|_| true).0
    }
}
