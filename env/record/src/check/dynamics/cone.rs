//! Least squares over passive bodies: masses and dry friction are non-negative, damping is positive semidefinite.
//!
//! The solver is an active-set method for non-negative least squares (Bro & de Jong 1997, "A fast non-negativity-constrained
//! least squares algorithm"). The damping is a sum of rank-one terms `w wᵀ`. Each round adds terms along the steepest
//! descent over all `w`, the leading eigenvectors of the gradient, until none reduces the misfit. This reaches the optimum
//! over the cone of positive semidefinite matrices, including extreme rays such as one locked wheel.

use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen};

use super::normal_equations::{LoadTransform, NormalEquations};
use super::regressors::{COLUMNS, CONSTANT_TERMS, DAMPING_ELEMENTS, DAMPING_INDICES, MASS_POINTS};

/// Maximum number of rounds that add damping terms.
const MAX_ROUNDS: usize = 8;
/// Relative reduction of the misfit below which the rounds end.
const MIN_PROGRESS: f64 = 1e-3;
/// Relative ridge for columns without motion; negligible in the unexplained share.
const RIDGE: f64 = 1e-8;

/// Least-squares fit of a passive body.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// Unexplained share of the sum of squares of the load.
    pub unexplained: f64,
    /// One coefficient per column of the regression.
    pub coefficients: DVector<f64>,
    /// Damping terms, for a warm start of another fit.
    pub terms: Vec<[f64; 3]>,
}

impl Fit {
    /// Mass, kg.
    pub fn mass(&self) -> f64 {
        self.coefficients.rows(0, MASS_POINTS).sum()
    }

    /// Unexplained share of the corrected load in other rows.
    pub fn unexplained_share_of(&self, equations: &NormalEquations, correction: &LoadTransform) -> f64 {
        let (right, total) = equations.transformed(correction);
        let explained = 2.0 * right.dot(&self.coefficients)
            - self.coefficients.dot(&(&equations.normal * &self.coefficients));
        if total > 0.0 { 1.0 - explained / total } else { 0.0 }
    }
}

/// Fits a passive body to the corrected load, starting with the damping `terms` of a similar fit.
pub(crate) fn fit(equations: &NormalEquations, correction: &LoadTransform, terms: &[[f64; 3]]) -> Fit {
    let (right, total) = equations.transformed(correction);
    let mut terms = terms.to_vec();
    let mut last = f64::INFINITY;
    let mut rounds = 0;
    loop {
        let basis = basis(&terms);
        let coefficients = &basis * solve(&equations.normal, &right, &basis);
        let gradient = &right - &equations.normal * &coefficients;
        let misfit = total - right.dot(&coefficients) - gradient.dot(&coefficients);
        let new = descent(&gradient, &equations.normal);
        rounds += 1;
        if rounds > MAX_ROUNDS || new.is_empty() || last - misfit < MIN_PROGRESS * misfit {
            let unexplained = if total > 0.0 { (misfit / total).max(0.0) } else { 0.0 };
            return Fit { unexplained, coefficients, terms };
        }
        last = misfit;
        terms.extend(new);
    }
}

/// Generators of the cone: masses, dry friction, damping terms, constants.
fn basis(terms: &[[f64; 3]]) -> DMatrix<f64> {
    let bounded = 2 * MASS_POINTS;
    let mut basis = DMatrix::zeros(COLUMNS, bounded + terms.len() + CONSTANT_TERMS);
    (0..bounded).for_each(|k| basis[(k, k)] = 1.0);
    for (at, term) in terms.iter().enumerate() {
        for (element, (i, j)) in DAMPING_INDICES.into_iter().enumerate() {
            basis[(bounded + element, bounded + at)] = term[i] * term[j];
        }
    }
    let first = bounded + terms.len();
    (0..CONSTANT_TERMS).for_each(|k| basis[(COLUMNS - CONSTANT_TERMS + k, first + k)] = 1.0);
    basis
}

/// Directions `w` in which a new rank-one damping term reduces the misfit.
fn descent(gradient: &DVector<f64>, normal: &DMatrix<f64>) -> Vec<[f64; 3]> {
    let first = 2 * MASS_POINTS;
    let mut slope = Matrix3::zeros();
    for (element, (i, j)) in DAMPING_INDICES.into_iter().enumerate() {
        let value = gradient[first + element] * if i == j { 1.0 } else { 0.5 };
        (slope[(i, j)], slope[(j, i)]) = (value, value);
    }
    // Normalise the axes, so that the result does not depend on their units.
    let scale = [0, 1, 2].map(|k| {
        let power = normal[(first + k, first + k)];
        if power > 0.0 { power.powf(-0.25) } else { 0.0 }
    });
    for i in 0..3 {
        (0..3).for_each(|j| slope[(i, j)] *= scale[i] * scale[j]);
    }
    let eigen = SymmetricEigen::new(slope);
    let largest = eigen.eigenvalues.amax();
    let descending = (0..3).filter(|&k| eigen.eigenvalues[k] > 1e-3 * largest && eigen.eigenvalues[k] > 0.0);
    descending.map(|k| [0, 1, 2].map(|i| scale[i] * eigen.eigenvectors[(i, k)])).collect()
}

/// Coefficients of the columns of `basis`; all except the last [`CONSTANT_TERMS`] are non-negative.
fn solve(normal: &DMatrix<f64>, right: &DVector<f64>, basis: &DMatrix<f64>) -> DVector<f64> {
    let mut gram = basis.transpose() * normal * basis;
    let mut slope = basis.transpose() * right;
    let n = slope.len();
    let floor = 1e-12 * gram.diagonal().amax();
    let scale: Vec<f64> =
        gram.diagonal().iter().map(|d| d.max(floor).max(f64::MIN_POSITIVE).sqrt()).collect();
    for i in 0..n {
        (0..n).for_each(|j| gram[(i, j)] /= scale[i] * scale[j]);
        gram[(i, i)] += RIDGE;
        slope[i] /= scale[i];
    }
    let mut x = non_negative(&gram, &slope, n - CONSTANT_TERMS);
    (0..n).for_each(|i| x[i] /= scale[i]);
    x
}

/// Minimises `½ xᵀ G x − sᵀ x` with non-negative first `bounded` elements.
fn non_negative(gram: &DMatrix<f64>, slope: &DVector<f64>, bounded: usize) -> DVector<f64> {
    let n = slope.len();
    let mut free: Vec<bool> = (0..n).map(|k| k >= bounded).collect();
    let mut x = DVector::zeros(n);
    let tolerance = 1e-10 * slope.amax();
    for _ in 0..3 * n {
        x = feasible_step(gram, slope, &mut free, bounded, x);
        let descent = slope - gram * &x;
        let next = (0..bounded).filter(|&k| !free[k] && descent[k] > tolerance);
        match next.max_by(|&a, &b| descent[a].total_cmp(&descent[b])) {
            Some(k) => free[k] = true,
            None => break,
        }
    }
    x
}

/// Moves from the feasible `x` to the minimum over the free elements. Elements that would become negative are fixed at 0.
fn feasible_step(
    gram: &DMatrix<f64>,
    slope: &DVector<f64>,
    free: &mut [bool],
    bounded: usize,
    mut x: DVector<f64>,
) -> DVector<f64> {
    loop {
        let target = unconstrained(gram, slope, free);
        let blocked = (0..bounded).filter(|&k| free[k] && target[k] <= 0.0);
        let step = blocked.map(|k| (x[k] / (x[k] - target[k]).max(f64::MIN_POSITIVE), k));
        let Some((share, first)) = step.min_by(|a, b| a.0.total_cmp(&b.0)) else { return target };
        x += share.clamp(0.0, 1.0) * (target - &x);
        free[first] = false;
        x[first] = 0.0;
    }
}

/// Unconstrained minimum over the free elements; the other elements are 0.
fn unconstrained(gram: &DMatrix<f64>, slope: &DVector<f64>, free: &[bool]) -> DVector<f64> {
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

const _: () = assert!(DAMPING_ELEMENTS == DAMPING_INDICES.len());
