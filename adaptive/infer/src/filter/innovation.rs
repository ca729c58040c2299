//! Innovation of one pose sample, and the correction that it implies.

use crate::covariance::{Belief, POSE_STATES, STATES, whitener};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Innovation of one pose sample.
#[derive(Clone, Debug)]
pub struct Innovation {
    /// Time, s.
    pub t: f64,
    /// Measured minus predicted pose.
    pub error: Vector3<f64>,
    /// Covariance of the error.
    pub covariance: Matrix3<f64>,
    /// Filter gain.
    pub gain: SMatrix<f64, STATES, 3>,
    /// Inverse of the Cholesky factor of the covariance; rows of blocked directions are zero.
    pub whitener: Matrix3<f64>,
    /// −log density of the sample.
    pub cost: f64,
}

/// Innovation of one pose sample for a filter with `N` states.
pub(super) struct PoseInnovation<const N: usize> {
    pub t: f64,
    pub error: Vector3<f64>,
    /// Variances of the measured pose.
    pub noise: [f64; 3],
    pub covariance: Matrix3<f64>,
    pub gain: SMatrix<f64, N, POSE_STATES>,
    pub whitener: Matrix3<f64>,
    pub cost: f64,
}

impl<const N: usize> PoseInnovation<N> {
    /// Compares a belief with a measured pose. Directions not in `dof` are blocked; `noise` holds variances.
    /// `None` if a number is not finite.
    pub fn new(belief: &Belief<N>, t: f64, seen: [f64; 3], dof: [bool; 3], noise: [f64; 3]) -> Option<Self> {
        let mut covariance: Matrix3<f64> = belief.covariance.fixed_view::<3, 3>(0, 0).into_owned();
        let mut error = Vector3::zeros();
        for k in 0..3 {
            if dof[k] {
                covariance[(k, k)] += noise[k];
                error[k] = seen[k] - belief.mean[k];
            } else {
                covariance[(k, k)] = 1.0;
            }
        }
        let mut whitener = whitener(&covariance)?;
        let gain = belief.covariance.fixed_view::<N, POSE_STATES>(0, 0) * (whitener.transpose() * whitener);
        let whitened = whitener * error;
        let mut cost = 0.5 * whitened.norm_squared();
        let mut density = 1.0;
        for k in 0..3 {
            if dof[k] {
                density *= whitener[(k, k)];
                cost += 0.5 * std::f64::consts::TAU.ln();
            } else {
                whitener.row_mut(k).fill(0.0);
            }
        }
        cost -= density.ln();
        cost.is_finite().then_some(Self { t, error, noise, covariance, gain, whitener, cost })
    }

    pub fn innovation(&self) -> Innovation {
        let Self { t, error, covariance, whitener, cost, .. } = *self;
        let mut gain = SMatrix::<f64, STATES, POSE_STATES>::zeros();
        gain.fixed_view_mut::<N, POSE_STATES>(0, 0).copy_from(&self.gain);
        Innovation { t, error, covariance, gain, whitener, cost }
    }
}
