//! Learners from transitions: physics-based regression and the paper's two baselines.

use trundle_infer::{Features, FitOptions, Linear, Local, Predictor, Shooting, Transition, Watch, fit};
use trundle_model::Model;

use crate::PaperError;

/// A learner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learner {
    /// Physics-based regression.
    Physics,
    /// Linear regression.
    Linear(Features),
    /// Locally weighted regression.
    Local(Features),
}

/// Settings of physics-based regression.
#[derive(Clone, Copy, Debug)]
pub struct PbrSettings<'a> {
    /// Model whose free values are fitted.
    pub model: &'a Model,
    /// Number of random starts.
    pub starts: usize,
    /// Seed of the random starts.
    pub seed: u64,
}

impl Learner {
    /// The learner with a name: `pbr`, `lr`, `lwr`, `lr_body` or `lwr_body`.
    ///
    /// # Errors
    /// If the name is unknown.
    pub fn named(name: &str) -> Result<Self, PaperError> {
        match name {
            "pbr" => Ok(Self::Physics),
            "lr" => Ok(Self::Linear(Features::World)),
            "lwr" => Ok(Self::Local(Features::World)),
            "lr_body" => Ok(Self::Linear(Features::Body)),
            "lwr_body" => Ok(Self::Local(Features::Body)),
            _ => {
                let known = "pbr, lr, lwr, lr_body and lwr_body";
                Err(PaperError::UnknownName { name: name.to_owned(), known })
            }
        }
    }

    /// Learns from transitions.
    ///
    /// # Errors
    /// If the data are empty or not finite, or the fit fails.
    pub fn learn(
        self,
        training: &[Transition],
        settings: &PbrSettings<'_>,
        watch: &dyn Watch,
    ) -> Result<Box<dyn Predictor>, PaperError> {
        Ok(match self {
            Self::Physics => Box::new(fit_physics(training, settings, watch)?.resolved()?),
            Self::Linear(features) => Box::new(Linear::fit(training, features)?),
            Self::Local(features) => Box::new(Local::fit(training, features)?),
        })
    }
}

/// Fits a model to transitions by physics-based regression: the maximum posterior density under eq. 8 of the
/// rows of eq. 7.
///
/// # Errors
/// If the data are empty, or the fit fails.
pub fn fit_physics(
    training: &[Transition],
    settings: &PbrSettings<'_>,
    watch: &dyn Watch,
) -> Result<Model, PaperError> {
    let likelihood = Shooting::of_transitions(training)?;
    let options = FitOptions { starts: settings.starts, seed: settings.seed, ..FitOptions::default() };
    Ok(fit(&likelihood, settings.model, &[], &options, watch)?.model)
}
