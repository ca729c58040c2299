//! Change points: times from which the damping or the mass differs.
//!
//! A change point is judged by how much better the missing wrench is explained by different damping or mass after
//! it than by constant ones (a local test as by Benveniste, Basseville & Moustakides 1987). The test uses the
//! smoothed residual, which is linear in damping and mass for changes of any size.

use super::scan_data::ScanData;
use super::score_test::{Column, minus_log10_p};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rayon::prelude::*;
use trundle_infer::Residual;
use trundle_model::to_body;

/// Maximum number of candidates of each kind.
const MAX_CANDIDATES: usize = 3;
/// Model error of a smoothed force or moment in addition to its covariance, relative to the root mean square of the force, or
/// to the missing force at the radius of gyration. It covers nonlinearity and the blur of the smoother.
pub(super) const MODEL_ERROR_SHARE: f64 = 0.03;
/// Minimum spacing of candidates of one kind, s.
const MIN_SPACING_S: f64 = 0.4;
/// Minimum number of samples before and after a change point.
const MIN_SAMPLES: usize = 40;
/// Search radius and step for the refined time of a change point, s.
const SEARCH_RADIUS_S: f64 = 0.4;
const TIME_STEP_S: f64 = 0.02;
/// Minimum strength of a change point.
const MIN_STRENGTH: f64 = 2.0;

/// Kind of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ChangeKind {
    /// Damping: a wheel locks, comes free, or changes its friction.
    Damping,
    /// Mass: a load is added or removed.
    Mass,
}

/// Time from which the damping or the mass differs.
#[derive(Clone, Debug)]
pub(crate) struct ChangePoint {
    /// Index among the training episodes.
    pub episode: usize,
    /// Time on the clock of the table, s.
    pub time: f64,
    /// −log10 p, corrected for the number of tested times.
    pub strength: f64,
    /// Explained share of the squared missing wrench.
    pub share: f64,
    /// Kind of the change.
    pub kind: ChangeKind,
}

/// Number of parameters: six of a damping matrix, and the mass.
pub(crate) const PARAMETERS: usize = 7;

impl ChangeKind {
    const ALL: [Self; 2] = [Self::Damping, Self::Mass];

    /// Indices of the parameters that change.
    fn parameters(self) -> std::ops::Range<usize> {
        match self {
            Self::Damping => 0..6,
            Self::Mass => 6..PARAMETERS,
        }
    }
}

/// Contributions of a unit of each damping parameter (xx, xy, yy, xθ, yθ, θθ) and of the mass to the missing
/// wrench. Angles count at `arm`. Fixed directions are zero.
fn unit_wrenches(
    residual: &Residual,
    acceleration: [f64; 3],
    arm: f64,
    dof: [bool; 3],
) -> [[f64; 3]; PARAMETERS] {
    let [x, y, spin] = to_body(residual.twist, residual.pose[2]);
    let [ax, ay, turn] = acceleration;
    let unit_wrenches = [
        [-x, 0.0, 0.0],
        [-y, -x, 0.0],
        [0.0, -y, 0.0],
        [-arm * spin, 0.0, -arm * x],
        [0.0, -arm * spin, -arm * y],
        [0.0, 0.0, -arm * arm * spin],
        [-ax, -ay, -arm * arm * turn],
    ];
    unit_wrenches.map(|w| [0, 1, 2].map(|k| if dof[k] { w[k] } else { 0.0 }))
}

/// Accelerations at each step from the smoothed twist, object axes.
fn accelerations(residuals: &[Residual]) -> Vec<[f64; 3]> {
    let at = |k: usize| {
        let (before, after) = (&residuals[k.saturating_sub(1)], &residuals[(k + 1).min(residuals.len() - 1)]);
        let dt = (after.t - before.t).max(1e-9);
        to_body([0, 1, 2].map(|i| (after.twist[i] - before.twist[i]) / dt), residuals[k].pose[2])
    };
    (0..residuals.len()).map(at).collect()
}

/// Contributions of different damping and mass to the missing wrench at each step of an episode.
pub(crate) fn parameter_wrenches(
    residuals: &[Residual],
    arm: f64,
    dof: [bool; 3],
) -> Vec<[[f64; 3]; PARAMETERS]> {
    residuals.iter().zip(accelerations(residuals)).map(|(s, a)| unit_wrenches(s, a, arm, dof)).collect()
}

/// Normal equations of some samples.
#[derive(Clone)]
struct NormalEquations {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
}

impl NormalEquations {
    fn zero() -> Self {
        Self { matrix: DMatrix::zeros(PARAMETERS, PARAMETERS), right: DVector::zeros(PARAMETERS) }
    }

    fn add(&mut self, unit_wrenches: &[[f64; 3]; PARAMETERS], wrench: &Vector3<f64>, weight: &Matrix3<f64>) {
        let columns = DMatrix::from_fn(3, PARAMETERS, |i, j| unit_wrenches[j][i]);
        let weighted = weight * &columns;
        self.matrix += columns.tr_mul(&weighted);
        self.right += weighted.tr_mul(wrench);
    }

    /// Sum of squares that the parameters explain if those in `changed` have a second value in the samples of
    /// `after`.
    fn explained(&self, after: &Self, changed: std::ops::Range<usize>) -> f64 {
        let n = PARAMETERS + changed.len();
        let source = |k: usize| if k < PARAMETERS { k } else { changed.start + k - PARAMETERS };
        let part = |i: usize, j: usize| if i < PARAMETERS && j < PARAMETERS { self } else { after };
        let right = |i: usize| if i < PARAMETERS { self.right[i] } else { after.right[source(i)] };
        let matrix = DMatrix::from_fn(n, n, |i, j| part(i, j).matrix[(source(i), source(j))]);
        let scale = DVector::from_fn(n, |i, _| matrix[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip());
        let ridge = |i: usize, j: usize| if i == j { 1e-7 } else { 0.0 };
        let scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * scale[i] * scale[j] + ridge(i, j));
        let right = DVector::from_fn(n, |i, _| right(i) * scale[i]);
        scaled.cholesky().map_or(0.0, |c| right.dot(&c.solve(&right)))
    }
}

/// Samples of all episodes in order, with their weights.
struct WeightedSamples {
    /// Episode and time.
    at: Vec<(usize, f64)>,
    unit_wrenches: Vec<[[f64; 3]; PARAMETERS]>,
    wrench: Vec<Vector3<f64>>,
    weight: Vec<Matrix3<f64>>,
    /// Number of correlated samples that are equivalent to one independent sample.
    correlation_length: f64,
}

impl WeightedSamples {
    fn new(data: &ScanData) -> Self {
        let score_test = &data.score_test;
        let all = || score_test.episodes.iter().flat_map(|r| &r.residuals);
        let square: f64 = all().map(|r| r.wrench[0].powi(2) + r.wrench[1].powi(2)).sum();
        let floor = (MODEL_ERROR_SHARE * MODEL_ERROR_SHARE * square / all().count().max(1) as f64).max(1e-12);
        let model_error =
            Matrix3::from_diagonal(&Vector3::new(floor, floor, floor * score_test.arm * score_test.arm));
        let weigh = |r: &Residual| {
            let mut covariance = r.covariance + model_error;
            for k in (0..3).filter(|&k| !score_test.dof[k]) {
                covariance.row_mut(k).fill(0.0);
                covariance.column_mut(k).fill(0.0);
                covariance[(k, k)] = 1.0;
            }
            covariance.cholesky().map_or_else(Matrix3::zeros, |c| c.inverse())
        };
        let moving = |r: &Residual| {
            Vector3::from([0, 1, 2].map(|k| if score_test.dof[k] { r.wrench[k] } else { 0.0 }))
        };
        let at = score_test
            .episodes
            .iter()
            .enumerate()
            .flat_map(|(e, r)| r.residuals.iter().map(move |s| (e, s.t)));
        let mut samples = Self {
            at: at.collect(),
            unit_wrenches: score_test
                .episodes
                .iter()
                .flat_map(|r| parameter_wrenches(&r.residuals, score_test.arm, score_test.dof))
                .collect(),
            wrench: all().map(moving).collect(),
            weight: all().map(weigh).collect(),
            correlation_length: 1.0,
        };
        samples.correlation_length = samples.autocorrelation_length();
        samples
    }

    /// Integrated autocorrelation of the weighted samples within episodes, in samples.
    fn autocorrelation_length(&self) -> f64 {
        let unit: Vec<Vector3<f64>> = self
            .wrench
            .iter()
            .zip(&self.weight)
            .map(|(w, weight)| weight.cholesky().map_or(*w, |c| c.l().transpose() * w))
            .map(|w| w / w.norm().max(1.0))
            .collect();
        let lagged = |lag: usize| {
            let pairs = (lag..unit.len()).filter(|&k| self.at[k].0 == self.at[k - lag].0);
            pairs.map(|k| unit[k].dot(&unit[k - lag])).sum::<f64>()
        };
        let variance = lagged(0).max(f64::MIN_POSITIVE);
        let mut sum = 1.0;
        for lag in 1..unit.len().min(400) {
            let correlation = lagged(lag) / variance;
            if correlation < 0.05 {
                break;
            }
            sum += 2.0 * correlation;
        }
        sum
    }

    fn normal(&self, samples: std::ops::Range<usize>) -> NormalEquations {
        samples.fold(NormalEquations::zero(), |mut sum, k| {
            sum.add(&self.unit_wrenches[k], &self.wrench[k], &self.weight[k]);
            sum
        })
    }

    /// Sum of squares that constant parameters do not explain, and the additional sum that a change at each sample
    /// explains.
    fn gains(&self, kind: ChangeKind) -> (f64, Vec<f64>) {
        let n = self.at.len();
        let all_samples = self.normal(0..n);
        let constant = all_samples.explained(&NormalEquations::zero(), 0..0);
        let square: f64 = self.wrench.iter().zip(&self.weight).map(|(w, m)| w.dot(&(m * w))).sum();
        let mut gains = vec![0.0; n];
        let mut after = NormalEquations::zero();
        for k in (0..n).rev() {
            after.add(&self.unit_wrenches[k], &self.wrench[k], &self.weight[k]);
            if k >= MIN_SAMPLES && n - k >= MIN_SAMPLES {
                gains[k] = (all_samples.explained(&after, kind.parameters()) - constant).max(0.0);
            }
        }
        ((square - constant).max(0.0), gains)
    }
}

/// Change points, strongest first.
pub(crate) fn change_points(data: &ScanData) -> Vec<ChangePoint> {
    let samples = WeightedSamples::new(data);
    let found = |kind: ChangeKind| {
        let mut candidates = candidates(&samples, kind);
        // Refine the time only for a mass: large changes of damping invalidate the linearisation of the innovations,
        // and the smoother blurs them little.
        if kind == ChangeKind::Mass {
            candidates
                .iter_mut()
                .take(1)
                .for_each(|best| best.time = refined_time(data, best).unwrap_or(best.time));
        }
        candidates
    };
    let mut all: Vec<ChangePoint> = ChangeKind::ALL.into_iter().flat_map(found).collect();
    all.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    all
}

fn candidates(samples: &WeightedSamples, kind: ChangeKind) -> Vec<ChangePoint> {
    let (unexplained, gains) = samples.gains(kind);
    let mut order: Vec<usize> = (0..gains.len()).filter(|&k| gains[k] > 0.0).collect();
    order.sort_by(|&a, &b| gains[b].total_cmp(&gains[a]));
    let tests = samples.at.len() as f64 / samples.correlation_length;
    let mut found: Vec<ChangePoint> = Vec::new();
    for k in order {
        let (episode, end) = samples.at[k];
        let start = if k > 0 && samples.at[k - 1].0 == episode { samples.at[k - 1].1 } else { end };
        let near = found.iter().any(|c| c.episode == episode && (c.time - start).abs() < MIN_SPACING_S);
        let strength = minus_log10_p(gains[k] / samples.correlation_length, kind.parameters().len())
            - tests.max(1.0).log10();
        if strength < MIN_STRENGTH || found.len() == MAX_CANDIDATES {
            break;
        }
        if !near {
            found.push(ChangePoint {
                episode,
                time: start,
                strength,
                share: gains[k] / unexplained.max(f64::MIN_POSITIVE),
                kind,
            });
        }
    }
    found
}

/// The time near a change point from which a change explains most of the innovations, which the smoother does not
/// blur.
fn refined_time(data: &ScanData, change: &ChangePoint) -> Option<f64> {
    let score_test = &data.score_test;
    let episode = score_test.episodes.get(change.episode)?;
    let unit_wrenches: Vec<_> = score_test
        .episodes
        .iter()
        .map(|r| parameter_wrenches(&r.residuals, score_test.arm, score_test.dof))
        .collect();
    let step_starts: Vec<f64> =
        episode.response.t.iter().zip(&episode.response.dt).map(|(t, dt)| t - dt / 2.0).collect();
    let count = (2.0 * SEARCH_RADIUS_S / TIME_STEP_S).round() as usize;
    let times = (0..=count).map(|k| change.time - SEARCH_RADIUS_S + k as f64 * TIME_STEP_S);
    let mut first: Vec<usize> = times.map(|t| step_starts.partition_point(|b| *b < t - 1e-9)).collect();
    first.retain(|k| *k < step_starts.len());
    first.dedup();
    let explained = |&from: &usize| {
        let gated = |parameter: usize| -> Column {
            let after = |e: usize, k: usize| e > change.episode || (e == change.episode && k >= from);
            let of = |(e, steps): (usize, &Vec<[[f64; 3]; PARAMETERS]>)| {
                steps
                    .iter()
                    .enumerate()
                    .map(|(k, w)| if after(e, k) { w[parameter] } else { [0.0; 3] })
                    .collect()
            };
            score_test.column(&unit_wrenches.iter().enumerate().map(of).collect())
        };
        let columns: Vec<Column> = change.kind.parameters().map(gated).collect();
        (from, score_test.test(&columns.iter().collect::<Vec<_>>()).chi_square)
    };
    let all: Vec<(usize, f64)> = first.par_iter().map(explained).collect();
    all.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| step_starts[k])
}
