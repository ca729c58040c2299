//! Intervals of time in which a missing wrench differs from zero.

use super::likelihood::PathLikelihood;
use crate::answer::Window;
use crate::locate::MAX_WINDOW_GAP_S;
use nalgebra::Vector3;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use trundle_infer::Residual;

/// Maximum p-value of a sample in a window.
const MAX_SAMPLE_P: f64 = 1e-4;
const MIN_DURATION_S: f64 = 0.1;
/// Maximum number of reported windows.
const MAX_WINDOWS: usize = 24;

/// Windows in which a missing wrench differs from zero.
pub(super) fn windows(residuals: &[Vec<Residual>], likelihood: &PathLikelihood) -> Vec<Window> {
    let directions = likelihood.dof.iter().filter(|d| **d).count().max(1);
    let mut all = Vec::new();
    for (episode, path) in residuals.iter().zip(&likelihood.paths) {
        let mut windows: Vec<Window> = Vec::new();
        for residual in episode {
            let strength = minus_log10_p(squared_mahalanobis(residual, likelihood.dof), directions);
            match windows.last_mut() {
                _ if strength < -MAX_SAMPLE_P.log10() => {}
                Some(open) if residual.t - open.end <= MAX_WINDOW_GAP_S => {
                    open.end = residual.t;
                    open.strength = open.strength.max(strength);
                }
                _ => windows.push(Window {
                    episode: path.name.clone(),
                    start: residual.t,
                    end: residual.t,
                    strength,
                }),
            }
        }
        all.extend(windows.into_iter().filter(|w| w.end - w.start >= MIN_DURATION_S));
    }
    all.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    all.truncate(MAX_WINDOWS);
    all.sort_by(|a, b| a.episode.cmp(&b.episode).then(a.start.total_cmp(&b.start)));
    all
}

/// Squared Mahalanobis distance of a residual wrench from zero, over the free directions.
fn squared_mahalanobis(residual: &Residual, dof: [bool; 3]) -> f64 {
    let (mut covariance, mut wrench) = (residual.covariance, Vector3::from(residual.wrench));
    for k in (0..3).filter(|&k| !dof[k]) {
        covariance.row_mut(k).fill(0.0);
        covariance.column_mut(k).fill(0.0);
        (covariance[(k, k)], wrench[k]) = (1.0, 0.0);
    }
    covariance.cholesky().map_or(0.0, |c| wrench.dot(&c.solve(&wrench)))
}

/// −log10 of the tail probability of χ² with `dof` degrees of freedom, finite for any value.
fn minus_log10_p(chi_square: f64, dof: usize) -> f64 {
    let tail = ChiSquared::new(dof as f64).map_or(1.0, |d| d.sf(chi_square));
    if tail > 1e-280 {
        return -tail.log10();
    }
    // Leading term of the incomplete gamma function.
    let half = chi_square / 2.0;
    (half - (dof as f64 / 2.0 - 1.0) * half.ln()) / std::f64::consts::LN_10
}
