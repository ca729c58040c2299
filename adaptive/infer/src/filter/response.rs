//! Effect of a missing wrench on the whitened innovations, to first order.
//!
//! A filter with fixed transitions and gains is a linear system. A missing wrench enters it like the error of
//! the reading and moves the state away from the filter's estimate; each correction removes part of the
//! deviation (Willsky & Jones 1976; de Jong & Penzer 1998). The response to any missing wrench requires one
//! pass over the episode, so thousands of hypotheses cost no more than a fit.

use crate::covariance::{Matrix, Vector};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Index of the first state of the reading's error.
const FIRST_ERROR_STATE: usize = 6;

/// A filtered episode as a linear system.
pub struct Response {
    pub(super) system: Box<dyn LinearSystem>,
    /// Whitened innovations, three for each pose sample. They are independent and standard normal under the
    /// correct model, and zero along blocked directions.
    pub innovations: Vec<f64>,
    /// Middle of each step, s.
    pub t: Vec<f64>,
    /// Duration of each step, s.
    pub dt: Vec<f64>,
}

impl Response {
    /// Contribution of a missing wrench over each step, object axes about the object origin, to
    /// [`Response::innovations`].
    pub fn respond(&self, missing: &[[f64; 3]]) -> Vec<f64> {
        self.system.respond(0, missing)
    }

    /// The same for a wrench that is missing from step `first` on, for the given number of steps.
    pub fn respond_from(&self, first: usize, missing: &[[f64; 3]]) -> Vec<f64> {
        self.system.respond(first, missing)
    }
}

/// A linear system with any number of states.
pub(super) trait LinearSystem: Send + Sync {
    fn respond(&self, first: usize, missing: &[[f64; 3]]) -> Vec<f64>;
}

/// One step of the linear system.
pub(super) struct Stage<const N: usize> {
    pub transition: Matrix<N>,
    /// Map from a missing wrench, object axes, to the error of the reading.
    pub error_map: Matrix3<f64>,
    /// Gain and whitener of the pose measured at the end of the step.
    pub seen: Option<(SMatrix<f64, N, 3>, Matrix3<f64>)>,
}

impl<const N: usize> LinearSystem for Vec<Stage<N>> {
    fn respond(&self, first: usize, missing: &[[f64; 3]]) -> Vec<f64> {
        let before = self.iter().take(first).filter(|s| s.seen.is_some()).count();
        let mut response = vec![0.0; 3 * before];
        let mut deviation = Vector::<N>::zeros();
        for (k, stage) in self.iter().enumerate().skip(first) {
            let error = missing.get(k - first).map(|w| stage.error_map * Vector3::from(*w));
            deviation = stage.after(deviation, error.unwrap_or_default());
            if let Some((gain, whitener)) = &stage.seen {
                let pose: Vector3<f64> = deviation.fixed_rows::<3>(0).into_owned();
                response.extend((whitener * pose).iter());
                deviation -= gain * pose;
            }
        }
        response
    }
}

impl<const N: usize> Stage<N> {
    /// Deviation of the state from the filter's after a step with the additional reading error `error`.
    fn after(&self, mut deviation: Vector<N>, error: Vector3<f64>) -> Vector<N> {
        for k in 0..3 {
            deviation[FIRST_ERROR_STATE + k] += error[k];
        }
        let mut moved = self.transition * deviation;
        for k in 0..3 {
            moved[FIRST_ERROR_STATE + k] -= error[k];
        }
        moved
    }
}
