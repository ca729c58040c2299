//! Rauch-Tung-Striebel smoother (1965) of a filtered episode. The smoothed error of the reading is the wrench
//! that the model misses.

use crate::covariance::{Belief, Matrix, Vector};
use nalgebra::{Matrix3, Vector3};
use trundle_model::transport;

/// Missing wrench at one time, object axes about the object origin.
#[derive(Clone, Debug)]
pub struct Residual {
    /// Time, s.
    pub t: f64,
    /// Smoothed pose.
    pub pose: [f64; 3],
    /// Smoothed twist, world axes.
    pub twist: [f64; 3],
    /// Wrench on the object that the model does not explain, N, N, N·m.
    pub wrench: [f64; 3],
    /// Covariance of the wrench.
    pub covariance: Matrix3<f64>,
}

/// One prediction and correction, stored for the smoother.
pub(super) struct Stage<const N: usize> {
    pub transition: Matrix<N>,
    pub predicted: Belief<N>,
    pub filtered: Belief<N>,
    pub frame: [f64; 3],
    pub t: f64,
}

/// Wrench error at the end of every stage, given all stages.
pub(super) fn backward<const N: usize>(stages: Vec<Stage<N>>) -> Vec<Residual> {
    let mut residuals = Vec::with_capacity(stages.len());
    let mut next: Option<(Belief<N>, Belief<N>, Matrix<N>)> = None;
    for stage in stages.into_iter().rev() {
        let Stage { transition, predicted, filtered, frame, t } = stage;
        let smoothed = match next {
            None => Belief { mean: filtered.mean, covariance: filtered.covariance },
            Some((smoothed, predicted, transition)) => {
                let gain = filtered.covariance * transition.transpose() * inverse(&predicted.covariance);
                let covariance = filtered.covariance
                    + gain * (smoothed.covariance - predicted.covariance) * gain.transpose();
                Belief { mean: filtered.mean + gain * (smoothed.mean - predicted.mean), covariance }
            }
        };
        residuals.push(residual(&smoothed, frame, t));
        next = Some((smoothed, predicted, transition));
    }
    residuals.reverse();
    residuals
}

/// Inverse of a covariance whose blocked directions have zero variance.
fn inverse<const N: usize>(covariance: &Matrix<N>) -> Matrix<N> {
    let mut scaled = *covariance;
    let scale = Vector::<N>::from_fn(|k, _| {
        let variance = covariance[(k, k)];
        if variance > 0.0 { variance.sqrt().recip() } else { 0.0 }
    });
    for i in 0..N {
        for j in 0..N {
            scaled[(i, j)] *= scale[i] * scale[j];
        }
        scaled[(i, i)] = if scale[i] > 0.0 { 1.0 + 1e-12 } else { 1.0 };
    }
    let inverse = scaled.cholesky().map_or_else(Matrix::zeros, |c| c.inverse());
    Matrix::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j])
}

/// Error of the reading as a missing wrench on the object.
fn residual<const N: usize>(belief: &Belief<N>, frame: [f64; 3], t: f64) -> Residual {
    let m = &belief.mean;
    let columns = [0, 1, 2].map(|k| {
        let mut unit = [0.0; 3];
        unit[k] = -1.0;
        Vector3::from(transport(unit, frame))
    });
    let turn = Matrix3::from_columns(&columns);
    let wrench = turn * m.fixed_rows::<3>(6);
    let covariance = turn * belief.covariance.fixed_view::<3, 3>(6, 6) * turn.transpose();
    Residual { t, pose: [m[0], m[1], m[2]], twist: [m[3], m[4], m[5]], wrench: wrench.into(), covariance }
}
