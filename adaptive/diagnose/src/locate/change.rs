//! When something changed for good.
//!
//! A moment is judged by how much better the missing wrench is explained when damping, or mass, is another after it
//! than before, than when it is another all along (a local test in the sense of Benveniste, Basseville &
//! Moustakides 1987, on the smoothed residual, in which both are linear however large the change).

use super::Seen;
use super::screen::{Column, surprise};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rayon::prelude::*;
use trundle_infer::Residual;
use trundle_model::to_body;

/// Candidates that are handed on, of each kind.
const RANKED: usize = 3;
/// Candidates of a kind are at least this far apart, s.
const APART: f64 = 0.4;
/// Error of the smoothed wrench beside its covariance, as a share of the whole.
const LOOSE: f64 = 0.03;
/// Samples before and after a moment that are needed.
const FEWEST: usize = 40;
/// A date is looked for so far around a change, s, and so finely.
const AROUND: f64 = 0.4;
const FINE: f64 = 0.02;
/// Strength below which a change is none.
const TOLD: f64 = 2.0;

/// What may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// The damping: a wheel locks, comes free, or is another.
    Damping,
    /// The mass: a load is put on or taken off.
    Mass,
}

/// A moment from which on something is another.
#[derive(Clone, Debug)]
#[allow(dead_code)] // its kind is for the search
pub(crate) struct Change {
    /// Index among the training episodes.
    pub episode: usize,
    /// The table's t, s.
    pub time: f64,
    /// −log10 p, corrected for the moments among which it was chosen.
    pub strength: f64,
    /// Share of the missing wrench, squared, that it explains.
    pub share: f64,
    /// What changed.
    pub kind: Kind,
}

/// Numbers of a damping matrix, and the mass.
pub(crate) const NUMBERS: usize = 7;

impl Kind {
    const ALL: [Self; 2] = [Self::Damping, Self::Mass];

    /// Which numbers change.
    fn numbers(self) -> std::ops::Range<usize> {
        match self {
            Self::Damping => 0..6,
            Self::Mass => 6..NUMBERS,
        }
    }
}

/// What a unit of each number of damping (xx, xy, yy, xθ, yθ, θθ) and mass adds to the missing wrench. Angles count at
/// `arm`; a direction that does not move takes no part.
fn units(seen: &Residual, acceleration: [f64; 3], arm: f64, dof: [bool; 3]) -> [[f64; 3]; NUMBERS] {
    let [x, y, spin] = to_body(seen.twist, seen.pose[2]);
    let [ax, ay, turn] = acceleration;
    let units = [
        [-x, 0.0, 0.0],
        [-y, -x, 0.0],
        [0.0, -y, 0.0],
        [-arm * spin, 0.0, -arm * x],
        [0.0, -arm * spin, -arm * y],
        [0.0, 0.0, -arm * arm * spin],
        [-ax, -ay, -arm * arm * turn],
    ];
    units.map(|w| [0, 1, 2].map(|k| if dof[k] { w[k] } else { 0.0 }))
}

/// Accelerations at each step, object axes, from the smoothed twist.
fn accelerations(course: &[Residual]) -> Vec<[f64; 3]> {
    let at = |k: usize| {
        let (before, after) = (&course[k.saturating_sub(1)], &course[(k + 1).min(course.len() - 1)]);
        let dt = (after.t - before.t).max(1e-9);
        to_body([0, 1, 2].map(|i| (after.twist[i] - before.twist[i]) / dt), course[k].pose[2])
    };
    (0..course.len()).map(at).collect()
}

/// What other damping and mass would add to the missing wrench at each step of an episode.
pub(crate) fn others(course: &[Residual], arm: f64, dof: [bool; 3]) -> Vec<[[f64; 3]; NUMBERS]> {
    course.iter().zip(accelerations(course)).map(|(s, a)| units(s, a, arm, dof)).collect()
}

/// Normal equations over some samples.
#[derive(Clone)]
struct Normal {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
}

impl Normal {
    fn zero() -> Self {
        Self { matrix: DMatrix::zeros(NUMBERS, NUMBERS), right: DVector::zeros(NUMBERS) }
    }

    fn add(&mut self, units: &[[f64; 3]; NUMBERS], wrench: &Vector3<f64>, weight: &Matrix3<f64>) {
        let columns = DMatrix::from_fn(3, NUMBERS, |i, j| units[j][i]);
        let weighted = weight * &columns;
        self.matrix += columns.tr_mul(&weighted);
        self.right += weighted.tr_mul(wrench);
    }

    /// The sum of squares that the numbers explain, those in `twice` with another value where `after` counts.
    fn explained(&self, after: &Self, twice: std::ops::Range<usize>) -> f64 {
        let n = NUMBERS + twice.len();
        let source = |k: usize| if k < NUMBERS { k } else { twice.start + k - NUMBERS };
        let part = |i: usize, j: usize| if i < NUMBERS && j < NUMBERS { self } else { after };
        let right = |i: usize| if i < NUMBERS { self.right[i] } else { after.right[source(i)] };
        let matrix = DMatrix::from_fn(n, n, |i, j| part(i, j).matrix[(source(i), source(j))]);
        let scale = DVector::from_fn(n, |i, _| matrix[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip());
        let ridge = |i: usize, j: usize| if i == j { 1e-7 } else { 0.0 };
        let scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * scale[i] * scale[j] + ridge(i, j));
        let right = DVector::from_fn(n, |i, _| right(i) * scale[i]);
        scaled.cholesky().map_or(0.0, |c| right.dot(&c.solve(&right)))
    }
}

/// All samples in order, with their weights.
struct Course {
    /// Episode and time.
    at: Vec<(usize, f64)>,
    units: Vec<[[f64; 3]; NUMBERS]>,
    wrench: Vec<Vector3<f64>>,
    weight: Vec<Matrix3<f64>>,
    /// How many samples say what one would, were they independent.
    dependent: f64,
}

impl Course {
    fn new(seen: &Seen) -> Self {
        let screen = &seen.screen;
        let all = || screen.runs.iter().flat_map(|r| &r.course);
        let square: f64 = all().map(|r| r.wrench[0].powi(2) + r.wrench[1].powi(2)).sum();
        let floor = (LOOSE * LOOSE * square / all().count().max(1) as f64).max(1e-12);
        let loose = Matrix3::from_diagonal(&Vector3::new(floor, floor, floor * screen.arm * screen.arm));
        let weigh = |r: &Residual| {
            let mut covariance = r.covariance + loose;
            for k in (0..3).filter(|&k| !screen.dof[k]) {
                covariance.row_mut(k).fill(0.0);
                covariance.column_mut(k).fill(0.0);
                covariance[(k, k)] = 1.0;
            }
            covariance.cholesky().map_or_else(Matrix3::zeros, |c| c.inverse())
        };
        let moving =
            |r: &Residual| Vector3::from([0, 1, 2].map(|k| if screen.dof[k] { r.wrench[k] } else { 0.0 }));
        let at = screen.runs.iter().enumerate().flat_map(|(e, r)| r.course.iter().map(move |s| (e, s.t)));
        let mut course = Self {
            at: at.collect(),
            units: screen.runs.iter().flat_map(|r| others(&r.course, screen.arm, screen.dof)).collect(),
            wrench: all().map(moving).collect(),
            weight: all().map(weigh).collect(),
            dependent: 1.0,
        };
        course.dependent = course.memory();
        course
    }

    /// Integrated autocorrelation of the weighted samples within episodes, in samples.
    fn memory(&self) -> f64 {
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
        let whole = lagged(0).max(f64::MIN_POSITIVE);
        let mut sum = 1.0;
        for lag in 1..unit.len().min(400) {
            let own = lagged(lag) / whole;
            if own < 0.05 {
                break;
            }
            sum += 2.0 * own;
        }
        sum
    }

    fn normal(&self, samples: std::ops::Range<usize>) -> Normal {
        samples.fold(Normal::zero(), |mut sum, k| {
            sum.add(&self.units[k], &self.wrench[k], &self.weight[k]);
            sum
        })
    }

    /// Mean square of what numbers that hold all along leave, and how much a change at each sample explains beyond.
    fn gains(&self, kind: Kind) -> (f64, Vec<f64>) {
        let n = self.at.len();
        let whole = self.normal(0..n);
        let always = whole.explained(&Normal::zero(), 0..0);
        let square: f64 = self.wrench.iter().zip(&self.weight).map(|(w, m)| w.dot(&(m * w))).sum();
        let mut gains = vec![0.0; n];
        let mut after = Normal::zero();
        for k in (0..n).rev() {
            after.add(&self.units[k], &self.wrench[k], &self.weight[k]);
            if k >= FEWEST && n - k >= FEWEST {
                gains[k] = (whole.explained(&after, kind.numbers()) - always).max(0.0);
            }
        }
        ((square - always).max(0.0), gains)
    }
}

/// Moments from which on something is another, the strongest first.
pub(crate) fn changes(seen: &Seen) -> Vec<Change> {
    let course = Course::new(seen);
    let told = |kind: Kind| {
        let mut own = of(&course, kind);
        // Where damping changes much the innovations' linear view is off, and the smoother's blur is short.
        if kind == Kind::Mass {
            own.iter_mut().take(1).for_each(|best| best.time = dated(seen, best).unwrap_or(best.time));
        }
        own
    };
    let mut all: Vec<Change> = Kind::ALL.into_iter().flat_map(told).collect();
    all.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    all
}

fn of(course: &Course, kind: Kind) -> Vec<Change> {
    let (left, gains) = course.gains(kind);
    let mut order: Vec<usize> = (0..gains.len()).filter(|&k| gains[k] > 0.0).collect();
    order.sort_by(|&a, &b| gains[b].total_cmp(&gains[a]));
    let tests = course.at.len() as f64 / course.dependent;
    let mut told: Vec<Change> = Vec::new();
    for k in order {
        let (episode, end) = course.at[k];
        let start = if k > 0 && course.at[k - 1].0 == episode { course.at[k - 1].1 } else { end };
        let near = told.iter().any(|c| c.episode == episode && (c.time - start).abs() < APART);
        let strength = surprise(gains[k] / course.dependent, kind.numbers().len()) - tests.max(1.0).log10();
        if strength < TOLD || told.len() == RANKED {
            break;
        }
        if !near {
            told.push(Change {
                episode,
                time: start,
                strength,
                share: gains[k] / left.max(f64::MIN_POSITIVE),
                kind,
            });
        }
    }
    told
}

/// The moment near a change from which on it explains most of the innovations, which the smoother does not blur.
fn dated(seen: &Seen, change: &Change) -> Option<f64> {
    let screen = &seen.screen;
    let run = screen.runs.get(change.episode)?;
    let units: Vec<_> = screen.runs.iter().map(|r| others(&r.course, screen.arm, screen.dof)).collect();
    let begins: Vec<f64> = run.response.t.iter().zip(&run.response.dt).map(|(t, dt)| t - dt / 2.0).collect();
    let count = (2.0 * AROUND / FINE).round() as usize;
    let tried = (0..=count).map(|k| change.time - AROUND + k as f64 * FINE);
    let mut first: Vec<usize> = tried.map(|t| begins.partition_point(|b| *b < t - 1e-9)).collect();
    first.retain(|k| *k < begins.len());
    first.dedup();
    let explained = |&from: &usize| {
        let gated = |number: usize| -> Column {
            let after = |e: usize, k: usize| e > change.episode || (e == change.episode && k >= from);
            let of = |(e, steps): (usize, &Vec<[[f64; 3]; NUMBERS]>)| {
                steps
                    .iter()
                    .enumerate()
                    .map(|(k, w)| if after(e, k) { w[number] } else { [0.0; 3] })
                    .collect()
            };
            screen.column(&units.iter().enumerate().map(of).collect())
        };
        let columns: Vec<Column> = change.kind.numbers().map(gated).collect();
        (from, screen.test(&columns.iter().collect::<Vec<_>>()).chi_square)
    };
    let all: Vec<(usize, f64)> = first.par_iter().map(explained).collect();
    all.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| begins[k])
}
