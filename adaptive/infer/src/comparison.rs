//! Selects the comparison for a recording: by its motion, or by the wrench where inertia is negligible.

use crate::likelihood::{Evaluation, Likelihood, Linearised};
use crate::{Channels, InferError, MotionLikelihood, WrenchLikelihood};
use trundle_model::Model;
use trundle_record::{Dataset, InertialShare, MAX_QUASI_STATIC_SHARE, MIN_POSES_FOR_MOTION, Prepared};

/// One of the two comparisons.
#[derive(Clone)]
pub enum Comparison {
    /// Poses under the recorded wrench.
    Motion(MotionLikelihood),
    /// Wrenches required for the recorded poses.
    Wrench(WrenchLikelihood),
}

impl Comparison {
    /// The comparison for a recording's training episodes.
    ///
    /// # Errors
    /// When there is not enough data.
    pub fn of(data: &Dataset) -> Result<Self, InferError> {
        Self::over(data, &data.training)
    }

    /// The same over other episodes of the recording.
    ///
    /// # Errors
    /// When there is not enough data.
    pub fn over(data: &Dataset, episodes: &[Prepared]) -> Result<Self, InferError> {
        let named = |error| match error {
            InferError::NoData { recording, reason, remedy } => {
                InferError::NoData { recording: format!("{}: {recording}", data.name), reason, remedy }
            }
            other => other,
        };
        if is_quasi_static(data) {
            WrenchLikelihood::new(episodes, &data.noise, data.dof).map(Self::Wrench).map_err(named)
        } else {
            MotionLikelihood::new(episodes, &data.noise).map(Self::Motion).map_err(named)
        }
    }

    /// A cheaper likelihood of the same data, for ranking candidates.
    #[must_use]
    pub fn thinned(&self) -> Self {
        match self {
            Self::Motion(l) => Self::Motion(l.thinned()),
            Self::Wrench(l) => Self::Wrench(l.clone()),
        }
    }

    /// The same over a subset of the episodes.
    #[must_use]
    pub fn only(&self, keep: impl Fn(usize) -> bool) -> Self {
        match self {
            Self::Motion(l) => Self::Motion(l.only(keep)),
            Self::Wrench(l) => Self::Wrench(l.only(keep)),
        }
    }

    /// The same with noise estimated under a model.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    pub fn with_tuned_noise(&self, model: &Model, values: &[f64]) -> Result<Self, InferError> {
        Ok(match self {
            Self::Motion(l) if l.noise_is_stated() => Self::Motion(l.clone()),
            Self::Motion(l) => Self::Motion(l.with_tuned_noise(model, values)?),
            Self::Wrench(l) => Self::Wrench(l.with_tuned_noise(model, values)?),
        })
    }

    /// The same with given noise.
    #[must_use]
    pub fn with_channels(&self, channels: Channels) -> Self {
        match self {
            Self::Motion(l) => Self::Motion(l.with_channels(channels)),
            Self::Wrench(l) => Self::Wrench(l.with_scatter(channels.reading)),
        }
    }

    /// Whether wrenches are compared, because inertia is negligible.
    pub fn is_quasi_static(&self) -> bool {
        matches!(self, Self::Wrench(_))
    }

    /// Number of compared samples.
    pub fn observations(&self) -> usize {
        match self {
            Self::Motion(l) => l.tracks().iter().map(crate::Track::observations).sum(),
            Self::Wrench(l) => l.samples().len(),
        }
    }

    fn inner(&self) -> &dyn Likelihood {
        match self {
            Self::Motion(l) => l,
            Self::Wrench(l) => l,
        }
    }
}

/// Whether a recording's training episodes are quasi-static: the inertial share of the force plus two
/// standard deviations is below [`MAX_QUASI_STATIC_SHARE`], or the episodes have too few poses.
pub fn is_quasi_static(data: &Dataset) -> bool {
    let has_few_poses = data.training.iter().all(|episode| episode.pose.len() < MIN_POSES_FOR_MOTION);
    has_few_poses
        || InertialShare::of(data).is_some_and(|share| share.mean + 2.0 * share.sd < MAX_QUASI_STATIC_SHARE)
}

impl Likelihood for Comparison {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        self.inner().cost(model, values)
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        self.inner().linearise(model, values, free)
    }

    fn evaluate<'a>(
        &'a self,
        model: &'a Model,
        values: &[f64],
        free: &'a [usize],
        likely: bool,
    ) -> Result<Evaluation<'a>, InferError> {
        self.inner().evaluate(model, values, free, likely)
    }

    fn chi_squared(&self, model: &Model, values: &[f64]) -> Result<(f64, usize), InferError> {
        self.inner().chi_squared(model, values)
    }

    fn channels(&self) -> Channels {
        self.inner().channels()
    }

    fn tuned(&self, model: &Model, values: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        self.inner().tuned(model, values)
    }

    fn rescaled(&self, model: &Model, values: &[f64]) -> Result<Option<Vec<f64>>, InferError> {
        self.inner().rescaled(model, values)
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        self.inner().split()
    }

    fn coarse(&self) -> Option<&dyn Likelihood> {
        self.inner().coarse()
    }
}
