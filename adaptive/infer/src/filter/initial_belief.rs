//! Initial belief of the filter.

use super::Filter;
use crate::Track;
use crate::covariance::{BASE_STATES, Belief, Matrix, Vector};
use trundle_model::MAX_INNER_STATES;
use trundle_record::Motion;

impl<const N: usize, const D: usize> Filter<N, D> {
    /// Belief at the start of an episode.
    pub(super) fn initial_belief(&self, track: &Track, inner: &[f64; MAX_INNER_STATES]) -> Belief<N> {
        self.at(track.pose, track.twist, track.tare, inner)
    }

    /// Belief at a given motion, with the laws' own states taken from another belief.
    pub(super) fn restarted_belief(&self, track: &Track, motion: &Motion, known: &Belief<N>) -> Belief<N> {
        let variance = |of: usize| [0, 1, 2].map(|k| motion.cov[k][of][of]);
        let mut inner = [0.0; MAX_INNER_STATES];
        (0..self.inner.len()).for_each(|k| inner[k] = known.mean[BASE_STATES + k]);
        let mut belief = self.at((motion.pose, variance(0)), (motion.twist, variance(1)), track.tare, &inner);
        for i in BASE_STATES..BASE_STATES + self.inner.len() {
            (BASE_STATES..BASE_STATES + self.inner.len())
                .for_each(|j| belief.covariance[(i, j)] = known.covariance[(i, j)]);
        }
        belief
    }

    /// Belief at a pose and a twist, given with their variances.
    fn at(
        &self,
        (pose, pose_var): ([f64; 3], [f64; 3]),
        (twist, twist_var): ([f64; 3], [f64; 3]),
        tare: [f64; 3],
        inner: &[f64; MAX_INNER_STATES],
    ) -> Belief<N> {
        let mut mean = Vector::zeros();
        let mut covariance = Matrix::zeros();
        for k in (0..3).filter(|&k| self.dof[k]) {
            (mean[k], mean[k + 3]) = (pose[k], twist[k]);
            (covariance[(k, k)], covariance[(k + 3, k + 3)]) = (pose_var[k], twist_var[k]);
            covariance[(k + 6, k + 6)] = tare[k];
        }
        for (k, own) in self.inner.iter().enumerate() {
            mean[BASE_STATES + k] = inner[k];
            covariance[(BASE_STATES + k, BASE_STATES + k)] = own.sd * own.sd;
        }
        Belief { mean, covariance }
    }
}
