//! Stretches of time in which a missing wrench is not zero.

use super::likelihood::Along;
use crate::answer::Window;
use nalgebra::Vector3;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use trundle_infer::Residual;

/// p of a sample that belongs to a window.
const SAMPLE_P: f64 = 1e-4;
/// Windows closer than this are one, shorter ones are not told, s.
const BRIDGE: f64 = 0.15;
const SHORTEST: f64 = 0.1;
/// At most this many windows are told.
const MOST: usize = 24;

/// Stretches in which a missing wrench is not zero.
pub(super) fn windows(residuals: &[Vec<Residual>], along: &Along) -> Vec<Window> {
    let directions = along.dof.iter().filter(|d| **d).count().max(1);
    let mut all = Vec::new();
    for (episode, path) in residuals.iter().zip(&along.paths) {
        let mut found: Vec<Window> = Vec::new();
        for residual in episode {
            let strength = surprise(standardised(residual, along.dof), directions);
            match found.last_mut() {
                _ if strength < -SAMPLE_P.log10() => {}
                Some(open) if residual.t - open.end <= BRIDGE => {
                    open.end = residual.t;
                    open.strength = open.strength.max(strength);
                }
                _ => found.push(Window {
                    episode: path.name.clone(),
                    start: residual.t,
                    end: residual.t,
                    strength,
                }),
            }
        }
        all.extend(found.into_iter().filter(|w| w.end - w.start >= SHORTEST));
    }
    all.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    all.truncate(MOST);
    all.sort_by(|a, b| a.episode.cmp(&b.episode).then(a.start.total_cmp(&b.start)));
    all
}

/// Squared size of a residual wrench in units of its uncertainty, over the directions that move.
fn standardised(residual: &Residual, dof: [bool; 3]) -> f64 {
    let (mut covariance, mut wrench) = (residual.covariance, Vector3::from(residual.wrench));
    for k in (0..3).filter(|&k| !dof[k]) {
        covariance.row_mut(k).fill(0.0);
        covariance.column_mut(k).fill(0.0);
        (covariance[(k, k)], wrench[k]) = (1.0, 0.0);
    }
    covariance.cholesky().map_or(0.0, |c| wrench.dot(&c.solve(&wrench)))
}

/// −log10 of the tail probability of χ² with `dof` degrees of freedom, finite for any value.
fn surprise(chi_square: f64, dof: usize) -> f64 {
    let tail = ChiSquared::new(dof as f64).map_or(1.0, |d| d.sf(chi_square));
    if tail > 1e-280 {
        return -tail.log10();
    }
    // Leading term of the incomplete gamma function.
    let half = chi_square / 2.0;
    (half - (dof as f64 / 2.0 - 1.0) * half.ln()) / std::f64::consts::LN_10
}
