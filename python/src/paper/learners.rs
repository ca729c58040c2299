//! Learners from transitions: physics-based regression and the paper's two baselines.

use trundle_infer::{
    BaselineError, Features, FitOptions, InferError, Linear, Local, Predictor, Shooting, Transition, Watch,
    fit,
};
use trundle_model::{Model, ModelError};

/// Why a learner could not learn.
#[derive(Debug)]
pub(super) enum Trouble {
    /// Of a fit, an interruption among them.
    Infer(InferError),
    /// Anything else, in words.
    Other(String),
}

impl From<InferError> for Trouble {
    fn from(error: InferError) -> Self {
        Self::Infer(error)
    }
}

impl From<BaselineError> for Trouble {
    fn from(error: BaselineError) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<ModelError> for Trouble {
    fn from(error: ModelError) -> Self {
        Self::Infer(error.into())
    }
}

impl From<Trouble> for InferError {
    fn from(trouble: Trouble) -> Self {
        match trouble {
            Trouble::Infer(error) => error,
            Trouble::Other(reason) => ModelError::Format(reason).into(),
        }
    }
}

/// A learner by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Learner {
    /// Physics-based regression.
    Physics,
    /// Linear regression.
    Linear(Features),
    /// Locally weighted regression.
    Local(Features),
}

/// Input of physics-based regression: the form of the model, and the number of random starts.
pub(super) struct Given<'a> {
    pub(super) form: &'a Model,
    pub(super) starts: usize,
    pub(super) seed: u64,
}

impl Learner {
    pub(super) fn of(name: &str) -> Result<Self, Trouble> {
        match name {
            "pbr" => Ok(Self::Physics),
            "lr" => Ok(Self::Linear(Features::World)),
            "lwr" => Ok(Self::Local(Features::World)),
            "lr_body" => Ok(Self::Linear(Features::Body)),
            "lwr_body" => Ok(Self::Local(Features::Body)),
            _ => Err(Trouble::Other(format!("{name:?}: learners are pbr, lr, lwr, lr_body and lwr_body"))),
        }
    }

    /// What is learnt from some transitions.
    pub(super) fn learn(
        self,
        training: &[Transition],
        given: &Given<'_>,
        watch: &dyn Watch,
    ) -> Result<Box<dyn Predictor>, Trouble> {
        Ok(match self {
            Self::Physics => Box::new(physics(training, given, watch)?.resolved()?),
            Self::Linear(features) => Box::new(Linear::fit(training, features)?),
            Self::Local(features) => Box::new(Local::fit(training, features)?),
        })
    }
}

/// The model that physics-based regression learns: the greatest posterior density under eq. 8 on the rows of eq. 7.
pub(super) fn physics(
    training: &[Transition],
    given: &Given<'_>,
    watch: &dyn Watch,
) -> Result<Model, Trouble> {
    let likelihood = Shooting::of_transitions(training)?;
    let options = FitOptions { starts: given.starts, seed: given.seed, ..FitOptions::default() };
    Ok(fit(&likelihood, given.form, &[], &options, watch)?.model)
}
