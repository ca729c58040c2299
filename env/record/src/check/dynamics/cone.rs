//! Least squares over passive bodies: masses and dry friction not negative, damping positive semidefinite.
//!
//! Non-negative least squares by active sets (Bro & de Jong 1997, "A fast non-negativity-constrained least squares
//! algorithm"), in which the damping enters as rank-one terms `w wᵀ`. Terms are added along the steepest descent over
//! all `w`, the leading eigenvectors of the gradient, until none helps: the cone of positive semidefinite matrices is
//! then reached exactly, extreme rays (one wheel that blocks) included.

use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen};

use super::moments::{Linear, Moments};
use super::regressors::{COLUMNS, CONSTANTS, DAMPING, MASSES, PAIRS};

/// Rounds of new damping terms; each brings two.
const ROUNDS: usize = 8;
/// Share of the misfit that a round must take off to be followed by another.
const PROGRESS: f64 = 1e-3;
/// Relative ridge that keeps columns without motion solvable; far below any material share.
const RIDGE: f64 = 1e-8;

/// The best passive body.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// Unexplained share of the load's square.
    pub share: f64,
    /// One for each column of the regression.
    pub coefficients: DVector<f64>,
    /// The damping terms found, to start the next search from.
    pub terms: Vec<[f64; 3]>,
}

impl Fit {
    /// Mass of the body, kg.
    pub fn mass(&self) -> f64 {
        self.coefficients.rows(0, MASSES).sum()
    }

    /// Unexplained share of the load of other rows, after `change`.
    pub fn share_of(&self, moments: &Moments, change: &Linear) -> f64 {
        let (right, total) = moments.changed(change);
        let explained = 2.0 * right.dot(&self.coefficients)
            - self.coefficients.dot(&(&moments.normal * &self.coefficients));
        if total > 0.0 { 1.0 - explained / total } else { 0.0 }
    }
}

/// Fits a passive body to `moments` after `change` of the load, from the damping `terms` of a similar fit.
pub(crate) fn fit(moments: &Moments, change: &Linear, terms: &[[f64; 3]]) -> Fit {
    let (right, total) = moments.changed(change);
    let mut terms = terms.to_vec();
    let mut last = f64::INFINITY;
    let mut rounds = 0;
    loop {
        let basis = basis(&terms);
        let coefficients = &basis * solve(&moments.normal, &right, &basis);
        let gradient = &right - &moments.normal * &coefficients;
        let misfit = total - right.dot(&coefficients) - gradient.dot(&coefficients);
        let new = descent(&gradient, &moments.normal);
        rounds += 1;
        if rounds > ROUNDS || new.is_empty() || last - misfit < PROGRESS * misfit {
            let share = if total > 0.0 { (misfit / total).max(0.0) } else { 0.0 };
            return Fit { share, coefficients, terms };
        }
        last = misfit;
        terms.extend(new);
    }
}

/// Columns of the cone: masses, dry friction, damping terms, constants.
fn basis(terms: &[[f64; 3]]) -> DMatrix<f64> {
    let bounded = 2 * MASSES;
    let mut basis = DMatrix::zeros(COLUMNS, bounded + terms.len() + CONSTANTS);
    (0..bounded).for_each(|k| basis[(k, k)] = 1.0);
    for (at, term) in terms.iter().enumerate() {
        for (element, (i, j)) in PAIRS.into_iter().enumerate() {
            basis[(bounded + element, bounded + at)] = term[i] * term[j];
        }
    }
    let first = bounded + terms.len();
    (0..CONSTANTS).for_each(|k| basis[(COLUMNS - CONSTANTS + k, first + k)] = 1.0);
    basis
}

/// Directions in which a new rank-one damping takes off most, the best last.
fn descent(gradient: &DVector<f64>, normal: &DMatrix<f64>) -> Vec<[f64; 3]> {
    let first = 2 * MASSES;
    let mut slope = Matrix3::zeros();
    for (element, (i, j)) in PAIRS.into_iter().enumerate() {
        let value = gradient[first + element] * if i == j { 1.0 } else { 0.5 };
        (slope[(i, j)], slope[(j, i)]) = (value, value);
    }
    // Per unit of what a damping of that axis alone would explain, so that no axis wins by its unit.
    let scale = [0, 1, 2].map(|k| {
        let power = normal[(first + k, first + k)];
        if power > 0.0 { power.powf(-0.25) } else { 0.0 }
    });
    for i in 0..3 {
        (0..3).for_each(|j| slope[(i, j)] *= scale[i] * scale[j]);
    }
    let eigen = SymmetricEigen::new(slope);
    let largest = eigen.eigenvalues.amax();
    let uphill = (0..3).filter(|&k| eigen.eigenvalues[k] > 1e-3 * largest && eigen.eigenvalues[k] > 0.0);
    uphill.map(|k| [0, 1, 2].map(|i| scale[i] * eigen.eigenvectors[(i, k)])).collect()
}

/// Coefficients of the columns of `basis`; all but the last [`CONSTANTS`] are not negative.
fn solve(normal: &DMatrix<f64>, right: &DVector<f64>, basis: &DMatrix<f64>) -> DVector<f64> {
    let mut gram = basis.transpose() * normal * basis;
    let mut slope = basis.transpose() * right;
    let n = slope.len();
    let least = 1e-12 * gram.diagonal().amax();
    let scale: Vec<f64> =
        gram.diagonal().iter().map(|d| d.max(least).max(f64::MIN_POSITIVE).sqrt()).collect();
    for i in 0..n {
        (0..n).for_each(|j| gram[(i, j)] /= scale[i] * scale[j]);
        gram[(i, i)] += RIDGE;
        slope[i] /= scale[i];
    }
    let mut x = not_negative(&gram, &slope, n - CONSTANTS);
    (0..n).for_each(|i| x[i] /= scale[i]);
    x
}

/// Minimises `½ xᵀ G x − sᵀ x` with the first `bounded` elements not negative.
fn not_negative(gram: &DMatrix<f64>, slope: &DVector<f64>, bounded: usize) -> DVector<f64> {
    let n = slope.len();
    let mut free: Vec<bool> = (0..n).map(|k| k >= bounded).collect();
    let mut x = DVector::zeros(n);
    let tolerance = 1e-10 * slope.amax();
    for _ in 0..3 * n {
        x = inward(gram, slope, &mut free, bounded, x);
        let pull = slope - gram * &x;
        let next = (0..bounded).filter(|&k| !free[k] && pull[k] > tolerance);
        match next.max_by(|&a, &b| pull[a].total_cmp(&pull[b])) {
            Some(k) => free[k] = true,
            None => break,
        }
    }
    x
}

/// From the feasible `x` to the minimum over the free elements, which lose those that would become negative.
fn inward(
    gram: &DMatrix<f64>,
    slope: &DVector<f64>,
    free: &mut [bool],
    bounded: usize,
    mut x: DVector<f64>,
) -> DVector<f64> {
    loop {
        let wanted = unbounded(gram, slope, free);
        let blocked = (0..bounded).filter(|&k| free[k] && wanted[k] <= 0.0);
        let step = blocked.map(|k| (x[k] / (x[k] - wanted[k]).max(f64::MIN_POSITIVE), k));
        let Some((share, first)) = step.min_by(|a, b| a.0.total_cmp(&b.0)) else { return wanted };
        x += share.clamp(0.0, 1.0) * (wanted - &x);
        free[first] = false;
        x[first] = 0.0;
    }
}

/// The minimum over the free elements; the others are 0.
fn unbounded(gram: &DMatrix<f64>, slope: &DVector<f64>, free: &[bool]) -> DVector<f64> {
    let kept: Vec<usize> = (0..free.len()).filter(|&k| free[k]).collect();
    let part = gram.select_rows(&kept).select_columns(&kept);
    let right = slope.select_rows(&kept);
    let mut x = DVector::zeros(free.len());
    if let Some(cholesky) = part.cholesky() {
        let solution = cholesky.solve(&right);
        kept.iter().enumerate().for_each(|(i, &k)| x[k] = solution[i]);
    }
    x
}

const _: () = assert!(DAMPING == PAIRS.len());
