//! Pointwise log likelihood for cross-validation of a posterior (PSIS-LOO, Vehtari et al. 2017).
//!
//! The points are episodes. Given the parameters, episodes are independent: each has its own tare error, wrench noise
//! and initial state. Samples of one episode share these, so that samples are not exchangeable, and leaving out one
//! sample would test little more than the interpolation of its neighbours.

use crate::{Posterior, PosteriorError};
use rayon::prelude::*;
use trundle_infer::{InferError, Likelihood, Target};

/// Log likelihood of each episode at each draw of a posterior.
#[derive(Clone, Debug)]
pub struct PointwiseLogLikelihood {
    /// Names of the episodes.
    pub episodes: Vec<String>,
    /// Log densities by chain, draw and episode, nats.
    pub chains: Vec<Vec<Vec<f64>>>,
}

impl Posterior {
    /// Log likelihood of each training episode at each draw. `likelihood` is that of the sampling; it takes the noise of
    /// the posterior from [`Posterior::channels`].
    ///
    /// # Errors
    /// When a per-episode parameter is unknown to the likelihood.
    pub fn log_likelihood(
        &self,
        likelihood: &dyn Likelihood,
    ) -> Result<PointwiseLogLikelihood, PosteriorError> {
        let target = Target::new(likelihood, &self.model, &self.per_episode)?;
        let (episodes, parts): (Vec<_>, Vec<_>) = likelihood.split().into_iter().unzip();
        let at = |point: &Vec<f64>| {
            let values = (0..).map(|k| target.values(point, k).0);
            let costs = parts.iter().zip(values).map(|(part, values)| part.cost(&self.model, &values));
            costs.map(|cost| cost.map(|cost| -cost)).collect::<Result<Vec<f64>, InferError>>()
        };
        let of = |points: &Vec<Vec<f64>>| points.par_iter().map(at).collect::<Result<Vec<_>, InferError>>();
        let chains = self.chains.iter().map(|chain| of(&chain.points)).collect::<Result<_, _>>()?;
        Ok(PointwiseLogLikelihood { episodes, chains })
    }
}
