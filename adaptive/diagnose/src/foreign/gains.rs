//! The Kalman filter along a linearised path. Its gains depend on no measurement: once they are known, what any wrench
//! changes in the whitened innovations is a linear filter.
//!
//! State: deviation from the smoothed motion (6), error of the tare in reading axes (3), and an unnamed wrench that
//! wanders, object axes (3).

use super::linear::Map;
use super::path::Path;
use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};
use std::f64::consts::TAU;
use trundle_infer::{Channels, Residual};
use trundle_model::transport;
use trundle_record::Motion;

const N: usize = 12;
type Wide = SMatrix<f64, N, N>;
type Long = SVector<f64, N>;

/// Variance of the unnamed wrench where an episode begins, in what it wanders in a second.
const BEGIN: f64 = 1.0;

/// Variance of what is certain: keeps covariances invertible, N².
const TINY: f64 = 1e-14;

/// Gains of an episode.
#[derive(Clone, Debug)]
pub(crate) struct Gains {
    transition: Vec<Wide>,
    /// For each interval and direction: gain, and one over the innovation's standard deviation.
    update: Vec<[Option<(Long, f64)>; 3]>,
    start: Long,
    /// Σ ½ ln 2πs.
    pub normaliser: f64,
    /// What smoothing and prediction need, where asked for.
    history: Option<Vec<Stage>>,
}

/// Covariances of one interval.
#[derive(Clone, Debug)]
struct Stage {
    /// After the update by the pose at its end, and before.
    after: Wide,
    before: Wide,
    /// What the interval adds.
    process: Wide,
}

/// A prediction of the pose at the end of some intervals by the poses before them.
pub(crate) struct Ahead {
    /// Intervals after which it begins and ends.
    pub from: usize,
    pub to: usize,
    /// Covariance of its error.
    pub covariance: Matrix3<f64>,
}

impl Gains {
    /// Of a path; `doubts` are covariances of each interval's wrench beside the sensor's, none where empty; `kept` keeps
    /// what [`Gains::residuals`] needs.
    pub fn new(
        path: &Path,
        maps: &[Map],
        channels: &Channels,
        dof: [bool; 3],
        doubts: &[Matrix3<f64>],
        kept: bool,
    ) -> Self {
        let mut covariance = Wide::zeros();
        for k in 0..6 {
            covariance[(k, k)] = path.start.1[k].max(1e-12);
        }
        for k in 0..3 {
            covariance[(6 + k, 6 + k)] = path.tare[k].max(TINY);
            covariance[(9 + k, 9 + k)] = (BEGIN * channels.wander[k].powi(2)).max(TINY);
        }
        let mut gains = Self {
            transition: Vec::with_capacity(maps.len()),
            update: Vec::with_capacity(maps.len()),
            start: Long::zeros(),
            normaliser: 0.0,
            history: kept.then(Vec::new),
        };
        gains.start.fixed_rows_mut::<6>(0).copy_from(&Vector6::from(path.start.0));
        for (index, (interval, map)) in path.intervals.iter().zip(maps).enumerate() {
            let reading = map.b * carried(interval.steps[0].frame);
            let mut transition = Wide::identity();
            transition.fixed_view_mut::<6, 6>(0, 0).copy_from(&map.a);
            transition.fixed_view_mut::<6, 3>(0, 6).copy_from(&reading);
            transition.fixed_view_mut::<6, 3>(0, 9).copy_from(&map.b);
            let carried_on = transition * covariance * transition.transpose();
            covariance = carried_on;
            let variance =
                Matrix3::from_diagonal(&Vector3::from(channels.reading.map(|s| s * s * interval.thinning)));
            let noise: Matrix6<f64> = reading * variance * reading.transpose();
            let doubt = doubts.get(index).map_or_else(Matrix6::zeros, |d| map.b * d * map.b.transpose());
            let mut block = covariance.fixed_view_mut::<6, 6>(0, 0);
            block += noise + doubt;
            for k in 0..3 {
                covariance[(9 + k, 9 + k)] += channels.wander[k].powi(2) * interval.span;
            }
            let before = covariance;
            let mut update = [None; 3];
            for k in (0..3).filter(|&k| dof[k]) {
                let column: Long = covariance.column(k).into_owned();
                let variance = (column[k] + channels.pose[k].powi(2)).max(1e-18);
                let gain = column / variance;
                covariance -= gain * column.transpose();
                gains.normaliser += 0.5 * (TAU * variance).ln();
                update[k] = Some((gain, variance.sqrt().recip()));
            }
            covariance = (covariance + covariance.transpose()) * 0.5;
            gains.transition.push(transition);
            gains.update.push(update);
            if let Some(history) = &mut gains.history {
                history.push(Stage { after: covariance, before, process: before - carried_on });
            }
        }
        gains
    }

    /// Whitened innovations, one for each interval and direction (zero where it does not move), when each interval
    /// adds `inputs` to the state: with the poses seen where `path` is given; without, what the inputs change.
    pub fn whiten(&self, inputs: impl Fn(usize) -> Vector6<f64>, path: Option<&Path>) -> Vec<f64> {
        self.whiten_first(usize::MAX, inputs, path)
    }

    /// The same of the first `count` intervals.
    pub fn whiten_first(
        &self,
        count: usize,
        inputs: impl Fn(usize) -> Vector6<f64>,
        path: Option<&Path>,
    ) -> Vec<f64> {
        let mut found = Vec::with_capacity(3 * count.min(self.update.len()));
        self.follow(count, inputs, path, |_, _, innovations| found.extend(innovations));
        found
    }

    /// Variances of the innovations of each interval; infinite in directions that do not move.
    pub fn variances(&self) -> impl Iterator<Item = [f64; 3]> {
        let one = |update: &Option<(Long, f64)>| update.map_or(f64::INFINITY, |(_, scale)| scale.powi(-2));
        self.update.iter().map(move |updates| [0, 1, 2].map(|c| one(&updates[c])))
    }

    /// Walk the mean over the first `count` intervals; `each` sees it before and after every update, with the whitened innovations.
    fn follow(
        &self,
        count: usize,
        inputs: impl Fn(usize) -> Vector6<f64>,
        path: Option<&Path>,
        mut each: impl FnMut(Long, Long, [f64; 3]),
    ) {
        let mut mean = if path.is_some() { self.start } else { Long::zeros() };
        for (k, (transition, update)) in self.transition.iter().zip(&self.update).enumerate().take(count) {
            mean = transition * mean;
            let mut moved = mean.fixed_rows_mut::<6>(0);
            moved += inputs(k);
            let before = mean;
            let mut innovations = [0.0; 3];
            for c in 0..3 {
                let Some((gain, scale)) = &update[c] else { continue };
                let seen = path.map_or(0.0, |p| p.intervals[k].seen[c] - p.intervals[k].to[c]);
                let innovation = seen - mean[c];
                innovations[c] = innovation * scale;
                mean += gain * innovation;
            }
            each(before, mean, innovations);
        }
    }

    /// The unnamed wrench along the path from all poses (Rauch, Tung and Striebel 1965); empty where nothing was kept.
    pub fn residuals(&self, inputs: impl Fn(usize) -> Vector6<f64>, path: &Path) -> Vec<Residual> {
        let Some(history) = &self.history else { return vec![] };
        let mut means = Vec::with_capacity(history.len());
        self.follow(usize::MAX, inputs, Some(path), |before, after, _| means.push((before, after)));
        let mut smoothed: Option<(Long, Wide)> = None;
        let mut found = Vec::with_capacity(history.len());
        for k in (0..history.len()).rev() {
            let (mut mean, mut covariance) = (means[k].1, history[k].after);
            if let Some((later, wide)) = &smoothed
                && let Some(inverse) = history[k + 1].before.try_inverse()
            {
                let gain = covariance * self.transition[k + 1].transpose() * inverse;
                mean += gain * (later - means[k + 1].0);
                covariance += gain * (wide - history[k + 1].before) * gain.transpose();
            }
            found.push(residual(path, k, &mean, &covariance));
            smoothed = Some((mean, covariance));
        }
        found.reverse();
        found
    }
}

impl Gains {
    /// Simulations over successive spans of `seconds`, each from what the poses up to its beginning tell of the motion,
    /// with the error of the tare; none where nothing was kept.
    pub fn ahead(&self, path: &Path, known: &[Motion], channels: &Channels, seconds: f64) -> Vec<Ahead> {
        let Some(history) = &self.history else { return vec![] };
        let (mut found, mut from) = (vec![], 0);
        while from < history.len() {
            let end = path.intervals[from].t + path.intervals[from].span + seconds;
            let to = path.intervals.partition_point(|i| i.t + i.span <= end + 1e-9).saturating_sub(1);
            if to <= from || path.intervals[to].t + path.intervals[to].span < end - 0.1 * seconds {
                break;
            }
            let begin = end - seconds;
            let Some(motion) = known.get(known.partition_point(|m| m.t <= begin + 1e-9).saturating_sub(1))
            else {
                break;
            };
            let mut covariance = beginning(motion, path);
            for (transition, stage) in self.transition.iter().zip(history).take(to + 1).skip(from + 1) {
                covariance = transition * covariance * transition.transpose() + stage.process;
            }
            let noise = Matrix3::from_diagonal(&Vector3::from(channels.pose.map(|s| s * s)));
            found.push(Ahead { from, to, covariance: covariance.fixed_view::<3, 3>(0, 0) + noise });
            from = to;
        }
        found
    }
}

/// Covariance where a simulation begins.
fn beginning(motion: &Motion, path: &Path) -> Wide {
    let mut covariance = Wide::zeros();
    for k in 0..3 {
        for (i, row) in [k, 3 + k].into_iter().enumerate() {
            for (j, column) in [k, 3 + k].into_iter().enumerate() {
                covariance[(row, column)] = motion.cov[k][i][j];
            }
        }
        covariance[(6 + k, 6 + k)] = path.tare[k].max(TINY);
    }
    covariance
}

fn residual(path: &Path, k: usize, mean: &Long, covariance: &Wide) -> Residual {
    let interval = &path.intervals[k];
    Residual {
        t: interval.t + interval.span / 2.0,
        pose: interval.middle.pose,
        twist: interval.middle.twist,
        wrench: [mean[9], mean[10], mean[11]],
        covariance: covariance.fixed_view::<3, 3>(9, 9).into_owned(),
    }
}

/// The matrix that carries a wrench from a reading's frame to the object's.
fn carried(frame: [f64; 3]) -> Matrix3<f64> {
    let column = |k: usize| Vector3::from(transport([0, 1, 2].map(|i| f64::from(u8::from(i == k))), frame));
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}
