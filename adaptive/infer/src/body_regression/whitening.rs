//! Least squares with errors that are correlated between successive steps.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::equation::StepEquation;
use super::parameters::{PARAMETERS, Parameters, Precision};

/// Normal equations of whitened steps.
pub(super) struct Whitened {
    /// `Aᵀ R⁻¹ A`.
    pub precision: Precision,
    /// `Aᵀ R⁻¹ y`.
    pub information: Parameters,
    /// `yᵀ R⁻¹ y`.
    pub square: f64,
    /// Half the logarithm of the determinant of `R`.
    pub log_determinant: f64,
}

type Row = SMatrix<f64, 3, { PARAMETERS + 1 }>;

/// Sum the normal equations. The covariance `R` of the errors is block tridiagonal: `2 twist + other / weight` on the
/// diagonal, `−twist` next to it. Returns `None` if it is not positive definite.
pub(super) fn whiten(
    equations: &[StepEquation],
    weights: &[f64],
    twist: &[f64; 9],
    other: &[f64; 3],
) -> Option<Whitened> {
    let twist = Matrix3::from_column_slice(twist);
    let other = Matrix3::from_diagonal(&Vector3::from(*other));
    let mut sum = SMatrix::<f64, { PARAMETERS + 1 }, { PARAMETERS + 1 }>::zeros();
    let mut log_determinant = 0.0;
    let mut previous: Option<(Matrix3<f64>, Row)> = None;
    for (equation, weight) in equations.iter().zip(weights) {
        let mut block = twist * 2.0 + other / *weight;
        let mut row = Row::zeros();
        row.fixed_columns_mut::<PARAMETERS>(0).copy_from(&equation.regressors);
        row.set_column(PARAMETERS, &equation.impulse);
        if let Some((factor, whitened)) = &previous {
            // Block below the diagonal of the Cholesky factor: −twist L⁻ᵀ, transposed.
            let below = -factor.solve_lower_triangular(&twist)?;
            block -= below.transpose() * below;
            row -= below.transpose() * whitened;
        }
        let factor = block.cholesky()?.l();
        let whitened = factor.solve_lower_triangular(&row)?;
        sum += whitened.transpose() * whitened;
        log_determinant += factor.diagonal().iter().map(|d| d.ln()).sum::<f64>();
        previous = Some((factor, whitened));
    }
    Some(Whitened {
        precision: sum.fixed_view::<PARAMETERS, PARAMETERS>(0, 0).into_owned(),
        information: sum.fixed_view::<PARAMETERS, 1>(0, PARAMETERS).into_owned(),
        square: sum[(PARAMETERS, PARAMETERS)],
        log_determinant,
    })
}
