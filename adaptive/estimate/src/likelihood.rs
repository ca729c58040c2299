//! Choice of the likelihood of a fit.

use trundle_infer::{
    Comparison, Cut, Fit, FitOptions, InertialLikelihood, InferError, Joint, Likelihood, Loss, Shooting,
    Watch, fit, guided_fit, is_quasi_static,
};
use trundle_model::{Model, Stepper};
use trundle_posterior::{SearchExtent, search_modes};
use trundle_record::Dataset;
use trundle_sim::{ObstacleStepper, can_touch};

use crate::EstimateError;

/// Duration of an interval of eq. 8, s. At the full rate of a tracker, an interval would mostly contain noise.
const INTERVAL_S: f64 = 0.1;

/// Kind of a likelihood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LikelihoodKind {
    /// Kalman filter along each episode.
    Filter,
    /// Simulation over short intervals (eq. 8).
    Steps,
    /// Simulation of whole episodes; compares the final state.
    Final,
    /// Simulation over windows.
    Windows,
    /// Wrench that the model needs for the recorded motion.
    Wrench,
}

impl LikelihoodKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Filter, Self::Steps, Self::Final, Self::Windows, Self::Wrench];

    /// Name of the kind in Python and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Filter => "filter",
            Self::Steps => "steps",
            Self::Final => "final",
            Self::Windows => "windows",
            Self::Wrench => "wrench",
        }
    }

    /// The kind with a name.
    ///
    /// # Errors
    /// If the name is unknown.
    pub fn named(name: &str) -> Result<Self, EstimateError> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| EstimateError::UnknownName {
            argument: "likelihood",
            value: name.to_owned(),
            known: Self::ALL.map(Self::name).join(", "),
        })
    }

    /// Whether the likelihood simulates, so that it supports obstacles and other simulators.
    fn simulates(self) -> bool {
        !matches!(self, Self::Filter | Self::Wrench)
    }
}

/// The loss with a name: `gaussian` or `student`.
///
/// # Errors
/// If the name is unknown.
pub fn loss_named(name: &str) -> Result<Loss, EstimateError> {
    match name {
        "gaussian" => Ok(Loss::Gaussian),
        "student" => Ok(Loss::STUDENT),
        _ => Err(EstimateError::UnknownName {
            argument: "loss",
            value: name.to_owned(),
            known: "gaussian, student".to_owned(),
        }),
    }
}

/// Options that choose a likelihood.
#[derive(Clone, Copy, Debug)]
pub struct LikelihoodOptions {
    /// Kind; by default the filter, or windows if there are obstacles or a simulator.
    pub kind: Option<LikelihoodKind>,
    /// Duration of a window, s.
    pub window: f64,
    /// Loss of the residuals.
    pub loss: Loss,
    /// Whether to simulate contacts with the recorded obstacles; by default if the object may touch one.
    pub obstacles: Option<bool>,
}

/// A likelihood over recordings.
pub struct LikelihoodChoice<'a> {
    kind: LikelihoodKind,
    window: f64,
    loss: Loss,
    recordings: &'a [Dataset],
    /// Simulator of each recording with obstacles.
    obstacle_steppers: Vec<Option<ObstacleStepper>>,
    /// The user's simulator.
    simulator: Option<&'a dyn Stepper>,
}

impl<'a> LikelihoodChoice<'a> {
    /// Chooses a likelihood. `simulator` replaces the laws and the obstacles.
    ///
    /// # Errors
    /// If the chosen kind does not support the loss, obstacles or a simulator, or an obstacle is not a simple
    /// polygon.
    pub fn new(
        options: &LikelihoodOptions,
        recordings: &'a [Dataset],
        model: &Model,
        simulator: Option<&'a dyn Stepper>,
    ) -> Result<Self, EstimateError> {
        let considers_obstacles = options.obstacles != Some(false);
        let must_simulate = simulator.is_some()
            || considers_obstacles && recordings.iter().any(|data| may_touch(data, model));
        let default = if must_simulate { LikelihoodKind::Windows } else { LikelihoodKind::Filter };
        let kind = options.kind.unwrap_or(default);
        if must_simulate && !kind.simulates() {
            return Err(EstimateError::NoSimulation { likelihood: kind.name() });
        }
        if kind == LikelihoodKind::Filter && options.loss != Loss::Gaussian {
            return Err(EstimateError::StudentFilter);
        }
        let stepper = |data: &Dataset| {
            let needed = considers_obstacles && simulator.is_none() && may_touch(data, model);
            needed.then(|| ObstacleStepper::new(model, data.obstacles.clone())).transpose()
        };
        let obstacle_steppers = recordings.iter().map(stepper).collect::<Result<_, _>>()?;
        let (window, loss) = (options.window, options.loss);
        Ok(Self { kind, window, loss, recordings, obstacle_steppers, simulator })
    }

    /// Kind of the likelihood.
    pub fn kind(&self) -> LikelihoodKind {
        self.kind
    }

    /// Name of the loss.
    pub fn loss(&self) -> &'static str {
        if self.loss == Loss::Gaussian { "gaussian" } else { "student" }
    }

    /// Whether wrenches are compared because inertia is negligible in all recordings.
    pub fn is_quasi_static(&self) -> bool {
        !self.kind.simulates() && self.recordings.iter().all(is_quasi_static)
    }

    /// The likelihood of all recordings.
    ///
    /// # Errors
    /// If a recording has too few data.
    pub fn likelihood(&self) -> Result<Box<dyn Likelihood + '_>, InferError> {
        self.likelihood_of(self.kind)
    }

    fn likelihood_of(&self, kind: LikelihoodKind) -> Result<Box<dyn Likelihood + '_>, InferError> {
        let parts = self.recordings.iter().zip(&self.obstacle_steppers).map(|(data, stepper)| {
            self.likelihood_of_one(data, stepper.as_ref(), kind).map_err(|error| in_recording(data, error))
        });
        let mut parts = parts.collect::<Result<Vec<_>, InferError>>()?;
        if parts.len() == 1 { Ok(parts.remove(0)) } else { Ok(Box::new(Joint::new(parts)?)) }
    }

    fn likelihood_of_one<'b>(
        &'b self,
        data: &'b Dataset,
        obstacles: Option<&'b ObstacleStepper>,
        kind: LikelihoodKind,
    ) -> Result<Box<dyn Likelihood + 'b>, InferError> {
        let cut = match kind {
            LikelihoodKind::Filter => return Ok(Box::new(Comparison::of(data)?)),
            LikelihoodKind::Wrench if self.is_quasi_static() => return Ok(Box::new(Comparison::of(data)?)),
            LikelihoodKind::Wrench => {
                let inertial = InertialLikelihood::new(&data.training, &data.noise, data.dof)?;
                return Ok(Box::new(inertial.with_loss(self.loss)));
            }
            LikelihoodKind::Steps => Cut::Steps { stride: stride(data) },
            LikelihoodKind::Final => Cut::Final,
            LikelihoodKind::Windows => Cut::Windows { length: self.window },
        };
        let shooting = Shooting::new(&data.training, &data.noise, data.dof, cut)?.with_loss(self.loss);
        Ok(match (self.simulator, obstacles) {
            (Some(simulator), _) => Box::new(shooting.simulated_by(simulator)),
            (None, Some(stepper)) => Box::new(shooting.simulated_by(stepper)),
            (None, None) => Box::new(shooting),
        })
    }

    /// Fits a model. A fit of final states without a start begins at the fit of windows. A filter uses the same
    /// search as sampling, so that both find the same optimum.
    ///
    /// # Errors
    /// If a recording has too few data, no start has a finite density, or the user interrupts.
    pub fn fit(
        &self,
        model: &Model,
        start: &[Vec<f64>],
        options: &FitOptions,
        watch: &dyn Watch,
    ) -> Result<Fit, InferError> {
        let likelihood = self.likelihood()?;
        match self.kind {
            LikelihoodKind::Final if start.is_empty() => match self.likelihood_of(LikelihoodKind::Windows) {
                Ok(guide) => guided_fit(&*guide, &*likelihood, model, options, watch),
                // Episodes that are too short for windows still have final states.
                Err(_) => fit(&*likelihood, model, start, options, watch),
            },
            LikelihoodKind::Filter => {
                Ok(search_modes(&*likelihood, model, start, options, SearchExtent::Best, watch)?.best)
            }
            _ => fit(&*likelihood, model, start, options, watch),
        }
    }
}

/// Number of pose samples in an interval of eq. 8.
fn stride(data: &Dataset) -> usize {
    let mut steps: Vec<f64> =
        data.training.iter().flat_map(|e| e.pose.windows(2)).map(|pair| pair[1].t - pair[0].t).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).map_or(1, |step| (INTERVAL_S / step).round().max(1.0) as usize)
}

/// Whether the object may touch an obstacle in a training episode.
fn may_touch(data: &Dataset, model: &Model) -> bool {
    let poses = data.training.iter().flat_map(|e| &e.pose).map(|p| p.pose);
    can_touch(&model.body, &data.obstacles, poses)
}

/// The error with the name of its recording.
fn in_recording(data: &Dataset, error: InferError) -> InferError {
    match error {
        InferError::NoData { recording, reason, remedy } if !recording.starts_with(&data.name) => {
            InferError::NoData { recording: format!("{}: {recording}", data.name), reason, remedy }
        }
        other => other,
    }
}
