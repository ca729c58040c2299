//! Kalman filter along a linearised path.
//!
//! Its gains do not depend on measurements. Given the gains, the effect of a wrench on the whitened innovations
//! is a linear filter.
//!
//! State: deviation from the smoothed motion (6), tare error in reading axes (3), and a random-walk wrench in
//! object axes (3).

use super::linearisation::IntervalMap;
use super::path::Path;
use nalgebra::{Matrix3, Matrix6, Matrix6x3, SMatrix, SVector, Vector3, Vector6};
use std::f64::consts::TAU;
use trundle_infer::{Channels, Residual};
use trundle_model::transport;
use trundle_record::Motion;

const STATES: usize = 12;
type FilterMatrix = SMatrix<f64, STATES, STATES>;
type FilterState = SVector<f64, STATES>;

/// Initial variance of the random-walk wrench, as the time in which it would accumulate, s.
const INITIAL_WANDER_S: f64 = 1.0;

/// Lower bound of a variance, which keeps covariances invertible, N².
const MIN_VARIANCE: f64 = 1e-14;

/// Filter gains of an episode.
#[derive(Clone, Debug)]
pub(crate) struct Gains {
    transition: Vec<FilterMatrix>,
    /// For each interval and direction: the gain and the reciprocal of the innovation's standard deviation.
    update: Vec<[Option<(FilterState, f64)>; 3]>,
    start: FilterState,
    /// Σ ½ ln 2πs over the innovation variances s.
    pub normaliser: f64,
    /// Covariances that smoothing and prediction need; `None` unless requested.
    history: Option<Vec<FilterStep>>,
}

/// Covariances of one interval.
#[derive(Clone, Debug)]
struct FilterStep {
    /// After and before the update with the pose at its end.
    posterior: FilterMatrix,
    prior: FilterMatrix,
    /// Process noise of the interval.
    process: FilterMatrix,
}

/// Prediction of the pose at the end of a span of intervals from the poses before the span.
pub(crate) struct WindowPrediction {
    /// Indices of the intervals at whose ends the span begins and ends.
    pub from: usize,
    pub to: usize,
    /// Covariance of the prediction error.
    pub covariance: Matrix3<f64>,
}

impl Gains {
    /// Computes the gains of a path. `law_covariances` holds the covariance of the laws' wrench in each interval, or
    /// nothing. `keep_history` stores what [`Gains::residuals`] and [`Gains::predict_windows`] need.
    pub fn new(
        path: &Path,
        maps: &[IntervalMap],
        channels: &Channels,
        dof: [bool; 3],
        law_covariances: &[Matrix3<f64>],
        keep_history: bool,
    ) -> Self {
        let mut covariance = start_covariance(path, channels);
        let mut gains = Self {
            transition: Vec::with_capacity(maps.len()),
            update: Vec::with_capacity(maps.len()),
            start: FilterState::zeros(),
            normaliser: 0.0,
            history: keep_history.then(Vec::new),
        };
        gains.start.fixed_rows_mut::<6>(0).copy_from(&Vector6::from(path.start.0));
        for (index, (interval, map)) in path.intervals.iter().zip(maps).enumerate() {
            let reading = map.b * transport_matrix(interval.steps[0].frame);
            let transition = transition_matrix(map, &reading);
            let propagated = transition * covariance * transition.transpose();
            covariance = propagated;
            let variance =
                Matrix3::from_diagonal(&Vector3::from(channels.reading.map(|s| s * s * interval.thinning)));
            let noise: Matrix6<f64> = reading * variance * reading.transpose();
            let law_noise =
                law_covariances.get(index).map_or_else(Matrix6::zeros, |d| map.b * d * map.b.transpose());
            let mut block = covariance.fixed_view_mut::<6, 6>(0, 0);
            block += noise + law_noise;
            for k in 0..3 {
                covariance[(9 + k, 9 + k)] += channels.wander[k].powi(2) * interval.span;
            }
            let prior = covariance;
            let update = gains.updated(&mut covariance, interval.pose_variance(channels), dof);
            gains.transition.push(transition);
            gains.update.push(update);
            if let Some(history) = &mut gains.history {
                history.push(FilterStep { posterior: covariance, prior, process: prior - propagated });
            }
        }
        gains
    }

    /// Update a covariance with a pose, one free direction after the other, and add to the normaliser. Returns the gain and the
    /// reciprocal of the innovation's standard deviation of each.
    fn updated(
        &mut self,
        covariance: &mut FilterMatrix,
        pose_variance: [f64; 3],
        dof: [bool; 3],
    ) -> [Option<(FilterState, f64)>; 3] {
        let mut update = [None; 3];
        for k in (0..3).filter(|&k| dof[k]) {
            let column: FilterState = covariance.column(k).into_owned();
            let variance = (column[k] + pose_variance[k]).max(1e-18);
            let gain = column / variance;
            *covariance -= gain * column.transpose();
            self.normaliser += 0.5 * (TAU * variance).ln();
            update[k] = Some((gain, variance.sqrt().recip()));
        }
        *covariance = (*covariance + covariance.transpose()) * 0.5;
        update
    }

    /// Whitened innovations if each interval adds `inputs` to the state: one value for each interval and direction,
    /// zero in fixed directions. With `path` they include the measured poses. Without it they are the change due to
    /// the inputs.
    pub fn whiten(&self, inputs: impl Fn(usize) -> Vector6<f64>, path: Option<&Path>) -> Vec<f64> {
        self.whiten_first(usize::MAX, inputs, path)
    }

    /// [`Gains::whiten`] for the first `count` intervals.
    pub fn whiten_first(
        &self,
        count: usize,
        inputs: impl Fn(usize) -> Vector6<f64>,
        path: Option<&Path>,
    ) -> Vec<f64> {
        let mut whitened = Vec::with_capacity(3 * count.min(self.update.len()));
        self.run_filter(count, inputs, path, |_, _, innovations| whitened.extend(innovations));
        whitened
    }

    /// Variances of the innovations of each interval; infinite in fixed directions.
    pub fn variances(&self) -> impl Iterator<Item = [f64; 3]> {
        let one =
            |update: &Option<(FilterState, f64)>| update.map_or(f64::INFINITY, |(_, scale)| scale.powi(-2));
        self.update.iter().map(move |updates| [0, 1, 2].map(|c| one(&updates[c])))
    }

    /// Propagates the mean over the first `count` intervals. `each` receives it before and after every update, and
    /// the whitened innovations.
    fn run_filter(
        &self,
        count: usize,
        inputs: impl Fn(usize) -> Vector6<f64>,
        path: Option<&Path>,
        mut each: impl FnMut(FilterState, FilterState, [f64; 3]),
    ) {
        let mut mean = if path.is_some() { self.start } else { FilterState::zeros() };
        for (k, (transition, update)) in self.transition.iter().zip(&self.update).enumerate().take(count) {
            mean = transition * mean;
            let mut moved = mean.fixed_rows_mut::<6>(0);
            moved += inputs(k);
            let before = mean;
            let mut innovations = [0.0; 3];
            for c in 0..3 {
                let Some((gain, scale)) = &update[c] else { continue };
                let measured = path.map_or(0.0, |p| p.intervals[k].measured[c] - p.intervals[k].to[c]);
                let innovation = measured - mean[c];
                innovations[c] = innovation * scale;
                mean += gain * innovation;
            }
            each(before, mean, innovations);
        }
    }

    /// Smoothed random-walk wrench along the path (Rauch, Tung and Striebel 1965); empty without a history.
    pub fn residuals(&self, inputs: impl Fn(usize) -> Vector6<f64>, path: &Path) -> Vec<Residual> {
        let Some(history) = &self.history else { return vec![] };
        let mut means = Vec::with_capacity(history.len());
        self.run_filter(usize::MAX, inputs, Some(path), |before, after, _| means.push((before, after)));
        let mut smoothed: Option<(FilterState, FilterMatrix)> = None;
        let mut residuals = Vec::with_capacity(history.len());
        for k in (0..history.len()).rev() {
            let (mut mean, mut covariance) = (means[k].1, history[k].posterior);
            if let Some((later, later_covariance)) = &smoothed
                && let Some(inverse) = history[k + 1].prior.try_inverse()
            {
                let gain = covariance * self.transition[k + 1].transpose() * inverse;
                mean += gain * (later - means[k + 1].0);
                covariance += gain * (later_covariance - history[k + 1].prior) * gain.transpose();
            }
            residuals.push(residual(path, k, &mean, &covariance));
            smoothed = Some((mean, covariance));
        }
        residuals.reverse();
        residuals
    }
}

impl Gains {
    /// Open-loop predictions over consecutive spans of `seconds`. Each starts from the motion estimated from the
    /// poses up to its beginning and includes the tare error. Empty without a history.
    pub fn predict_windows(
        &self,
        path: &Path,
        motion_so_far: &[Motion],
        channels: &Channels,
        seconds: f64,
    ) -> Vec<WindowPrediction> {
        let Some(history) = &self.history else { return vec![] };
        let (mut predictions, mut from) = (vec![], 0);
        while from < history.len() {
            let end = path.intervals[from].t + path.intervals[from].span + seconds;
            let to = path.intervals.partition_point(|i| i.t + i.span <= end + 1e-9).saturating_sub(1);
            if to <= from || path.intervals[to].t + path.intervals[to].span < end - 0.1 * seconds {
                break;
            }
            let start = end - seconds;
            let Some(motion) =
                motion_so_far.get(motion_so_far.partition_point(|m| m.t <= start + 1e-9).saturating_sub(1))
            else {
                break;
            };
            let mut covariance = initial_covariance(motion, path);
            for (transition, step) in self.transition.iter().zip(history).take(to + 1).skip(from + 1) {
                covariance = transition * covariance * transition.transpose() + step.process;
            }
            let noise = Matrix3::from_diagonal(&Vector3::from(path.intervals[to].pose_variance(channels)));
            predictions.push(WindowPrediction {
                from,
                to,
                covariance: covariance.fixed_view::<3, 3>(0, 0) + noise,
            });
            from = to;
        }
        predictions
    }
}

/// Covariance of the state at the beginning of a simulation.
fn initial_covariance(motion: &Motion, path: &Path) -> FilterMatrix {
    let mut covariance = FilterMatrix::zeros();
    for k in 0..3 {
        for (i, row) in [k, 3 + k].into_iter().enumerate() {
            for (j, column) in [k, 3 + k].into_iter().enumerate() {
                covariance[(row, column)] = motion.cov[k][i][j];
            }
        }
        covariance[(6 + k, 6 + k)] = path.tare[k].max(MIN_VARIANCE);
    }
    covariance
}

fn residual(path: &Path, k: usize, mean: &FilterState, covariance: &FilterMatrix) -> Residual {
    let interval = &path.intervals[k];
    Residual {
        t: interval.t + interval.span / 2.0,
        pose: interval.middle.pose,
        twist: interval.middle.twist,
        wrench: [mean[9], mean[10], mean[11]],
        covariance: covariance.fixed_view::<3, 3>(9, 9).into_owned(),
    }
}

/// Covariance of the state at the start of a path.
fn start_covariance(path: &Path, channels: &Channels) -> FilterMatrix {
    let mut covariance = FilterMatrix::zeros();
    for k in 0..6 {
        covariance[(k, k)] = path.start.1[k].max(1e-12);
    }
    for k in 0..3 {
        covariance[(6 + k, 6 + k)] = path.tare[k].max(MIN_VARIANCE);
        covariance[(9 + k, 9 + k)] = (INITIAL_WANDER_S * channels.wander[k].powi(2)).max(MIN_VARIANCE);
    }
    covariance
}

/// Transition of the state over an interval. `reading` is the effect of the tare error on the motion.
fn transition_matrix(map: &IntervalMap, reading: &Matrix6x3<f64>) -> FilterMatrix {
    let mut transition = FilterMatrix::identity();
    transition.fixed_view_mut::<6, 6>(0, 0).copy_from(&map.a);
    transition.fixed_view_mut::<6, 3>(0, 6).copy_from(reading);
    transition.fixed_view_mut::<6, 3>(0, 9).copy_from(&map.b);
    transition
}

/// Matrix that transports a wrench from the frame of the reading to the object frame.
fn transport_matrix(frame: [f64; 3]) -> Matrix3<f64> {
    let column = |k: usize| Vector3::from(transport([0, 1, 2].map(|i| f64::from(u8::from(i == k))), frame));
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}
