//! Mean and covariance of the filter's states, and their propagation and correction.
//!
//! A filter spends most of its time in this module. Columns are plain arrays, and only one triangle of a
//! symmetric product is computed; the other mirrors it. The covariance therefore stays exactly symmetric.
//! Otherwise it loses positive definiteness after minutes of data.

use nalgebra::{Matrix3, SMatrix, SVector};
use trundle_model::MAX_INNER_STATES;

/// Number of states for pose, twist and wrench error.
pub(crate) const BASE_STATES: usize = 9;
/// Maximum number of states: pose, twist, wrench error and the laws' own states.
pub(crate) const STATES: usize = BASE_STATES + MAX_INNER_STATES;
/// Number of states for pose and twist.
pub(crate) const MOTION_STATES: usize = 6;
/// Number of states for the pose.
pub(crate) const POSE_STATES: usize = 3;

pub(crate) type Matrix<const N: usize> = SMatrix<f64, N, N>;
pub(crate) type Vector<const N: usize> = SVector<f64, N>;

/// Mean and covariance of the states: pose, twist, error of the wrench reading, and the laws' own states.
#[derive(Clone)]
pub(crate) struct Belief<const N: usize> {
    pub mean: Vector<N>,
    pub covariance: Matrix<N>,
}

/// First computed row of a column of the lower triangle. It is even, so that rows are processed in pairs.
const fn first_row(column: usize) -> usize {
    column & !1
}

/// Copies the lower triangle to the upper one.
fn mirror<const N: usize>(columns: &mut [[f64; N]; N]) {
    for column in 1..N {
        let (before, after) = columns.split_at_mut(column);
        let Some(above) = after.first_mut() else { return };
        for (above, left) in above.iter_mut().zip(before) {
            *above = left[column];
        }
    }
}

/// Propagated covariance `F P Fᵀ + G diag(noise) Gᵀ`. Three rows of `F` are those of the identity, because
/// the error of the reading is constant. `G` consists of the columns of `F` for that error: noise of the
/// reading has the same effect on the motion but leaves the error state unchanged. `SHIFTS` means that the
/// first two columns of `F` are those of the identity, for translation-invariant motion.
#[inline]
pub(crate) fn propagated<const N: usize, const SHIFTS: bool>(
    transition: &Matrix<N>,
    covariance: &Matrix<N>,
    noise: [f64; 3],
) -> Matrix<N> {
    let (by, before) = (&transition.data.0, &covariance.data.0);
    // Without states of the laws, the rows of the error are the last.
    let rows = if N == BASE_STATES { MOTION_STATES } else { N };
    let mut half = [[0.0; N]; N];
    for (half, before) in half.iter_mut().zip(before) {
        let kept = if SHIFTS { 2 } else { 0 };
        half[..kept].copy_from_slice(&before[..kept]);
        half[rows..].copy_from_slice(&before[rows..]);
        for (by, share) in by.iter().zip(before).skip(kept) {
            for (sum, by) in half[..rows].iter_mut().zip(&by[..rows]) {
                *sum += by * share;
            }
        }
    }
    let mut noisy_half = half;
    for ((noisy_half, by), variance) in
        noisy_half[MOTION_STATES..BASE_STATES].iter_mut().zip(&by[MOTION_STATES..BASE_STATES]).zip(noise)
    {
        for row in (0..MOTION_STATES).chain(BASE_STATES..N) {
            noisy_half[row] += by[row] * variance;
        }
    }
    let mut product = half;
    for column in (0..MOTION_STATES).chain(BASE_STATES..N) {
        let from = first_row(column);
        let mut sum = [0.0; N];
        if SHIFTS && column < 2 {
            sum = noisy_half[column];
        }
        for (noisy_half, by) in noisy_half.iter().zip(by).skip(if SHIFTS { 2 } else { 0 }) {
            let share = by[column];
            for (sum, noisy_half) in sum[from..rows].iter_mut().zip(&noisy_half[from..rows]) {
                *sum += noisy_half * share;
            }
        }
        // The covariance of the error with the other states has no noise term.
        for (k, half) in half[MOTION_STATES..BASE_STATES].iter().enumerate() {
            sum[MOTION_STATES + k] = half[column];
        }
        product[column] = sum;
    }
    mirror(&mut product);
    SMatrix::from_data(nalgebra::ArrayStorage(product))
}

/// Covariance after a pose sample with variances `noise`: `P − K (H P)`, where the gain `K` is the pose
/// columns over the covariance of the sample. The pose columns of the result are `K R`, which avoids a
/// difference of two numbers.
#[inline]
pub(crate) fn corrected<const N: usize>(
    covariance: &Matrix<N>,
    gain: &SMatrix<f64, N, POSE_STATES>,
    noise: [f64; POSE_STATES],
) -> Matrix<N> {
    let (before, gain) = (&covariance.data.0, &gain.data.0);
    let mut after = *before;
    for ((after, gain), variance) in after.iter_mut().zip(gain).zip(noise) {
        *after = gain.map(|k| k * variance);
    }
    for (column, after) in after.iter_mut().enumerate().skip(POSE_STATES) {
        let from = first_row(column);
        for (gain, pose) in gain.iter().zip(before) {
            let share = pose[column];
            for (after, gain) in after[from..].iter_mut().zip(&gain[from..]) {
                *after -= gain * share;
            }
        }
    }
    mirror(&mut after);
    SMatrix::from_data(nalgebra::ArrayStorage(after))
}

/// Inverse `W` of the Cholesky factor of a covariance, `W S Wᵀ = I`; `None` if it is not positive definite.
#[inline]
pub(crate) fn whitener(covariance: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = covariance.data.0;
    let a = inverse_root(xx)?;
    let (b, c) = (xy * a, xz * a);
    let d = inverse_root(yy - b * b)?;
    let e = (yz - b * c) * d;
    let f = inverse_root(zz - c * c - e * e)?;
    let ba = -b * a * d;
    Some(Matrix3::new(a, 0.0, 0.0, ba, d, 0.0, -(c * a + e * ba) * f, -e * d * f, f))
}

fn inverse_root(x: f64) -> Option<f64> {
    let root = x.sqrt().recip();
    (x > 0.0 && root.is_finite()).then_some(root)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// Numbers without a pattern.
    fn mixed(k: usize) -> f64 {
        (12.9898 * (k + 1) as f64).sin()
    }

    fn positive<const N: usize>() -> Matrix<N> {
        let root = Matrix::<N>::from_fn(|i, j| mixed(3 * i + 7 * j));
        root * root.transpose() + Matrix::identity()
    }

    fn check<const N: usize, const SHIFTS: bool>() {
        let mut by = Matrix::<N>::from_fn(|i, j| mixed(5 * i + 11 * j));
        by.fixed_rows_mut::<3>(MOTION_STATES).fill(0.0);
        for k in MOTION_STATES..BASE_STATES {
            by[(k, k)] = 1.0;
        }
        if SHIFTS {
            by.fixed_columns_mut::<2>(0).copy_from(&Matrix::<N>::identity().fixed_columns::<2>(0));
        }
        let (before, noise) = (positive::<N>(), [0.3, 0.2, 0.7]);
        let mut input = by.fixed_columns::<3>(MOTION_STATES).into_owned();
        input.fixed_rows_mut::<3>(MOTION_STATES).fill(0.0);
        let noisy = input * Matrix3::from_diagonal(&Vector3::from(noise)) * input.transpose();
        let after = propagated::<N, SHIFTS>(&by, &before, noise);
        assert!((after - (by * before * by.transpose() + noisy)).amax() < 1e-12, "{after}");
        assert_eq!(after, after.transpose());
        let spread = before.fixed_view::<3, 3>(0, 0) + Matrix3::from_diagonal(&Vector3::from(noise));
        let white = whitener(&spread).unwrap();
        assert!((white * spread * white.transpose() - Matrix3::identity()).amax() < 1e-12, "{white}");
        let gain = before.fixed_columns::<3>(0) * white.transpose() * white;
        let seen = corrected(&before, &gain, noise);
        assert!((seen - (before - gain * before.fixed_rows::<3>(0))).amax() < 1e-12, "{seen}");
        assert_eq!(seen, seen.transpose());
    }

    #[test]
    fn products_match_full_matrices() {
        check::<9, false>();
        check::<9, true>();
        check::<14, false>();
    }

    #[test]
    fn an_indefinite_matrix_has_no_whitener() {
        for bad in [0.0, -1.0, f64::NAN] {
            assert!(whitener(&Matrix3::from_diagonal(&Vector3::new(1.0, bad, 1.0))).is_none());
        }
    }
}
