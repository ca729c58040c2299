//! Predictions of a black-box simulator with laws, made by the simulator itself.

use super::engine::BlackBoxEngine;
use super::gains::WindowPrediction;
use crate::design::{Certificate, OPEN_LOOP_NOISE_FACTOR, SimulatedPair, certificate_from_simulations};
use crate::engine::Engine;
use crate::fitted_model::FittedModel;
use crate::predictive_check::{PredictiveCheck, WindowEnd};
use nalgebra::Vector3;
use trundle_infer::{InferError, PREDICTION_WINDOW_S, unscored_time};

impl BlackBoxEngine<'_> {
    /// Errors of one-second predictions. The simulator predicts; the covariance of the error follows from its
    /// linearisation and the noise of the instruments.
    pub(super) fn predictions(&self, fitted: &FittedModel) -> Result<PredictiveCheck, InferError> {
        let (likelihood, dof, values) =
            (self.likelihood_of(fitted), self.data.dof, self.simulator_values(fitted));
        let (rollout, settling) = (self.rollout(fitted, &values)?, unscored_time(&fitted.fit.model));
        let judged = if settling > 0.0 { settling } else { f64::NEG_INFINITY };
        let free = |v: [f64; 3]| [0, 1, 2].map(|k| if dof[k] { v[k] } else { 0.0 });
        let mut ends = vec![];
        for (k, (path, episode)) in likelihood.paths.iter().zip(&self.data.training).enumerate() {
            let (motion_so_far, states) =
                (episode.filtered_motion(&self.data.noise), rollout.episode_states(episode)?);
            for WindowPrediction { from, to, covariance } in
                likelihood.predict_windows(k, &motion_so_far, PREDICTION_WINDOW_S)
            {
                let [from, to] = [from, to].map(|k| &path.intervals[k]);
                let span = [from, to].map(|interval| interval.t + interval.span);
                if span[0] < judged + episode.contact {
                    continue;
                }
                let Some(root) = covariance.cholesky() else { continue };
                let Some(error) = rollout.error_ahead(&states, span)? else { continue };
                let whitened: Vector3<f64> =
                    root.l().solve_lower_triangular(&Vector3::from(error)).unwrap_or_default();
                let motion = [0, 1, 2].map(|k| to.measured[k] - from.measured[k]);
                ends.push(WindowEnd { error: free(error), whitened: free(whitened.into()), motion });
            }
        }
        Ok(PredictiveCheck::from_windows(ends.into_iter(), dof, self.bare.body.gyration))
    }

    /// Certificate of two models from their open-loop simulations, compared with the effect of the instruments'
    /// noise.
    pub(super) fn simulation_certificate(
        &self,
        names: [&str; 2],
        models: [&FittedModel; 2],
    ) -> Result<Certificate, InferError> {
        let uncorrected = self
            .with_law_uncertainty(models[0])?
            .with_channels(self.likelihood.channels.scaled(OPEN_LOOP_NOISE_FACTOR, 1.0));
        let pose = self.likelihood.channels.pose;
        let mut simulated = vec![];
        for (episode, predicted_sds) in self.data.training.iter().zip(uncorrected.predicted_sds()) {
            let [a, b] = models.map(|fitted| self.open_loop(fitted, episode));
            let (a, b) = (a?.unwrap_or_default(), b?.unwrap_or_default());
            let at = |&(t, sd): &(f64, [f64; 3])| {
                let k = episode.pose.partition_point(|p| p.t < t - 1e-6);
                let sd = [0, 1, 2].map(|c| sd[c].hypot(pose[c]));
                Some((t, [*a.get(k)?, *b.get(k)?], sd))
            };
            let samples = predicted_sds.iter().filter_map(at).collect();
            simulated.push(SimulatedPair { episode: episode.name.clone(), samples });
        }
        let costs = models.map(|fitted| fitted.fit.cost);
        Ok(certificate_from_simulations(names, costs, &simulated, self.data.dof))
    }
}
