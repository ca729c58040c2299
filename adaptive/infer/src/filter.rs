//! An extended Kalman filter over an episode: the exact likelihood of poses under wrench noise, up
//! to linearisation.
//!
//! The state is pose, twist and the error of the wrench reading. That error starts as the
//! tare's and may wander: its smoothed course is the wrench that the model misses.

use crate::{Channels, Track, track::Step};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use trundle_model::{Dual, Plant, Real, State, transport};

/// Pose, twist and wrench error.
const N: usize = 9;
/// Pose and twist.
const MOTION: usize = 6;
type Matrix = SMatrix<f64, N, N>;
type Vector = SVector<f64, N>;

/// What one pose sample said.
#[derive(Clone, Debug)]
pub struct Innovation {
    /// Time, s.
    pub t: f64,
    /// Seen less predicted pose.
    pub error: Vector3<f64>,
    /// Its covariance.
    pub covariance: Matrix3<f64>,
    /// Filter gain: what the sample moves in the state.
    pub gain: SMatrix<f64, N, 3>,
    /// Inverse of the Cholesky factor of the covariance; rows of blocked directions are zero.
    pub whitener: Matrix3<f64>,
    /// −log density of the sample.
    pub cost: f64,
}

/// The wrench that the model misses at one time, object axes about the object origin.
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
    /// Its covariance.
    pub covariance: Matrix3<f64>,
}

struct Belief {
    mean: Vector,
    covariance: Matrix,
}

/// One prediction, kept for smoothing.
struct Stage {
    transition: Matrix,
    predicted: Belief,
    filtered: Belief,
    frame: [f64; 3],
    t: f64,
}

/// Filters one episode with one plant.
pub(crate) struct Filter<'a> {
    pub plant: Plant<Dual<N>>,
    pub channels: &'a Channels,
    pub dof: [bool; 3],
}

impl Filter<'_> {
    /// The innovation of every pose sample, in order; `None` where a number is not finite.
    pub fn run(&self, track: &Track) -> Option<Vec<Innovation>> {
        let mut innovations = Vec::with_capacity(track.observations());
        let mut belief = self.begin(track);
        let mut t = track.start;
        for step in &track.steps {
            (belief, _) = self.predict(&belief, step);
            t += step.dt;
            if let Some(seen) = step.pose {
                let innovation = self.observe(&belief, t, seen)?;
                belief = self.update(belief, &innovation);
                innovations.push(innovation);
            }
        }
        Some(innovations)
    }

    /// The wrench error at every pose sample, given the whole episode (Rauch-Tung-Striebel).
    pub fn smooth(&self, track: &Track) -> Option<Vec<Residual>> {
        let mut stages: Vec<Stage> = Vec::with_capacity(track.steps.len());
        let mut belief = self.begin(track);
        let mut t = track.start;
        for step in &track.steps {
            let (predicted, transition) = self.predict(&belief, step);
            t += step.dt;
            let filtered = match step.pose {
                Some(seen) => {
                    let innovation = self.observe(&predicted, t, seen)?;
                    let copy = Belief { mean: predicted.mean, covariance: predicted.covariance };
                    self.update(copy, &innovation)
                }
                None => Belief { mean: predicted.mean, covariance: predicted.covariance },
            };
            belief = Belief { mean: filtered.mean, covariance: filtered.covariance };
            stages.push(Stage { transition, predicted, filtered, frame: step.frame, t });
        }
        Some(backward(stages))
    }

    /// The density of every pose sample as predicted from the track's start alone.
    pub fn predict_only(&self, track: &Track) -> Option<Vec<Innovation>> {
        let mut belief = self.begin(track);
        let mut t = track.start;
        let mut predictions = Vec::with_capacity(track.observations());
        for step in &track.steps {
            (belief, _) = self.predict(&belief, step);
            t += step.dt;
            if let Some(seen) = step.pose {
                predictions.push(self.observe(&belief, t, seen)?);
            }
        }
        Some(predictions)
    }

    fn begin(&self, track: &Track) -> Belief {
        let ((pose, pose_var), (twist, twist_var)) = (track.pose, track.twist);
        let mut mean = Vector::zeros();
        let mut covariance = Matrix::zeros();
        for k in (0..3).filter(|&k| self.dof[k]) {
            (mean[k], mean[k + 3]) = (pose[k], twist[k]);
            (covariance[(k, k)], covariance[(k + 3, k + 3)]) = (pose_var[k], twist_var[k]);
            covariance[(k + 6, k + 6)] = track.tare[k];
        }
        Belief { mean, covariance }
    }

    fn predict(&self, belief: &Belief, step: &Step) -> (Belief, Matrix) {
        let variable = |k: usize| Dual::<N>::variable(belief.mean[k], k);
        let state = State { pose: [0, 1, 2].map(variable), twist: [3, 4, 5].map(variable) };
        let error = [6, 7, 8].map(variable);
        let after = push(&self.plant, &state, error, step);
        let mut transition = Matrix::identity();
        let mut mean = belief.mean;
        for (row, value) in after.pose.iter().chain(&after.twist).enumerate() {
            mean[row] = value.re;
            for column in 0..N {
                transition[(row, column)] = value.eps[column];
            }
        }
        let mut covariance = moved(&transition, &belief.covariance);
        for k in (0..3).filter(|&k| self.dof[k]) {
            let reading = self.channels.reading[k];
            let variance = reading * reading * step.thinning;
            // The reading's noise enters as its error does.
            let input: SVector<f64, MOTION> = transition.fixed_view::<MOTION, 1>(0, k + MOTION).into_owned();
            for column in 0..MOTION {
                for row in 0..MOTION {
                    covariance[(row, column)] += input[row] * (variance * input[column]);
                }
            }
            covariance[(k + 6, k + 6)] += self.channels.wander[k] * self.channels.wander[k] * step.dt;
        }
        (Belief { mean, covariance }, transition)
    }

    fn observe(&self, belief: &Belief, t: f64, seen: [f64; 3]) -> Option<Innovation> {
        let mut covariance: Matrix3<f64> = belief.covariance.fixed_view::<3, 3>(0, 0).into_owned();
        let mut error = Vector3::zeros();
        for k in 0..3 {
            if self.dof[k] {
                covariance[(k, k)] += self.channels.pose[k] * self.channels.pose[k];
                error[k] = seen[k] - belief.mean[k];
            } else {
                covariance[(k, k)] = 1.0;
            }
        }
        let factor = covariance.cholesky()?;
        let mut whitener = factor.l().try_inverse()?;
        let gain = belief.covariance.fixed_view::<N, 3>(0, 0) * factor.inverse();
        let whitened = whitener * error;
        let mut cost = 0.5 * whitened.norm_squared();
        for k in 0..3 {
            if self.dof[k] {
                cost += factor.l()[(k, k)].ln() + 0.5 * std::f64::consts::TAU.ln();
            } else {
                whitener.row_mut(k).fill(0.0);
            }
        }
        cost.is_finite().then_some(Innovation { t, error, covariance, gain, whitener, cost })
    }

    fn update(&self, belief: Belief, innovation: &Innovation) -> Belief {
        let mean = belief.mean + innovation.gain * innovation.error;
        let (gain, prior) = (&innovation.gain, &belief.covariance);
        // Joseph's form (I − KH) P (I − KH)ᵀ + K R Kᵀ stays positive. H takes the pose out of the state, so that
        // its products are of three columns.
        let kept = minus(prior, gain, &prior.fixed_view::<N, 3>(0, 0).into_owned());
        let mut pose: SMatrix<f64, N, 3> = kept.fixed_view::<N, 3>(0, 0).into_owned();
        for k in 0..3 {
            let variance = self.channels.pose[k] * self.channels.pose[k];
            for row in 0..N {
                pose[(row, k)] -= gain[(row, k)] * variance;
            }
        }
        Belief { mean, covariance: symmetric(&minus(&kept, &pose, gain)) }
    }
}

/// The mean of a matrix and its transpose: rounding makes a covariance lopsided, and over a minute that grows
/// until it is none.
fn symmetric(a: &Matrix) -> Matrix {
    let mut even = *a;
    for column in 0..N {
        for row in 0..column {
            let mean = 0.5 * (a[(row, column)] + a[(column, row)]);
            (even[(row, column)], even[(column, row)]) = (mean, mean);
        }
    }
    even
}

/// `F P Fᵀ`, where the last three rows of `F` are the identity's: a reading's error stays what it is.
fn moved(transition: &Matrix, covariance: &Matrix) -> Matrix {
    let mut half = *covariance;
    for column in 0..N {
        let mut sum = [0.0; MOTION];
        for k in 0..N {
            let by = covariance[(k, column)];
            for (row, sum) in sum.iter_mut().enumerate() {
                *sum += transition[(row, k)] * by;
            }
        }
        half.fixed_view_mut::<MOTION, 1>(0, column).copy_from_slice(&sum);
    }
    let mut product = half;
    for column in 0..MOTION {
        let mut sum = [0.0; MOTION];
        for k in 0..N {
            let by = transition[(column, k)];
            for (row, sum) in sum.iter_mut().enumerate() {
                *sum += half[(row, k)] * by;
            }
        }
        product.fixed_view_mut::<MOTION, 1>(0, column).copy_from_slice(&sum);
        for error in MOTION..N {
            product[(error, column)] = half[(column, error)];
        }
    }
    product
}

/// `A − B Cᵀ`.
fn minus(a: &Matrix, b: &SMatrix<f64, N, 3>, c: &SMatrix<f64, N, 3>) -> Matrix {
    let mut difference = *a;
    for column in 0..N {
        for k in 0..3 {
            let by = c[(column, k)];
            for row in 0..N {
                difference[(row, column)] -= b[(row, k)] * by;
            }
        }
    }
    difference
}

/// One step of a plant under a reading with an error.
#[inline]
pub(crate) fn push<T: Real>(plant: &Plant<T>, state: &State<T>, error: [T; 3], step: &Step) -> State<T> {
    let reading = [0, 1, 2].map(|k| -error[k] + step.reading[k]);
    let applied = transport(plant.correct(reading, step.clock), step.frame);
    plant.step(state, applied, step.clock, step.dt)
}

fn backward(stages: Vec<Stage>) -> Vec<Residual> {
    let mut residuals = Vec::with_capacity(stages.len());
    let mut next: Option<(Belief, Belief, Matrix)> = None;
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

/// Inverse of a covariance whose blocked directions have no variance.
fn inverse(covariance: &Matrix) -> Matrix {
    let mut scaled = *covariance;
    let scale = Vector::from_fn(|k, _| {
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

/// The reading's error, as the wrench on the object that the model lacks.
fn residual(belief: &Belief, frame: [f64; 3], t: f64) -> Residual {
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
