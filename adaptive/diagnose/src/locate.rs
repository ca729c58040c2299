//! Where the simulation goes wrong: in time, by channel, over the body, over speed.
//!
//! Everything is read off the smoothed residual wrench of the filter with a wandering wrench (see
//! `adequacy`), which comes with its covariance.

use crate::answer::{Channels, Mismatch, Point, Window};
use nalgebra::{Matrix3, Vector3};
use trundle_infer::{Comparison, Fit, InferError, Residual};
use trundle_model::{Model, to_body};

/// The missing wrench along each episode, object axes.
pub(crate) type Residuals = Vec<Vec<Residual>>;

/// p of a sample that belongs to a window.
const SAMPLE_P: f64 = 1e-4;
/// Windows closer than this are one, s.
const BRIDGE: f64 = 0.15;
/// Shorter windows are not told, s.
const SHORTEST: f64 = 0.1;
/// At most this many windows are told.
const MOST: usize = 24;

/// Locate what a fitted model misses.
pub(crate) fn locate(
    comparison: &Comparison,
    fit: &Fit,
    residuals: &Residuals,
    names: &[String],
) -> Result<Mismatch, InferError> {
    let mut windows: Vec<Window> =
        residuals.iter().zip(names).flat_map(|(episode, name)| scan(episode, name, fit.model.dof)).collect();
    windows.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    windows.truncate(MOST);
    windows.sort_by(|a, b| {
        (&a.episode, a.start).partial_cmp(&(&b.episode, b.start)).unwrap_or(std::cmp::Ordering::Equal)
    });
    Ok(Mismatch {
        windows,
        channels: channels(comparison, fit)?,
        body_point: line_of_action(residuals, &fit.model).map(|p| p.mean),
        world_region: None,
        regime: regime(residuals, fit.model.dof),
    })
}

/// −log10 of the tail probability of χ² with `dof` degrees of freedom, finite for any value.
fn surprise(chi_square: f64, dof: usize) -> f64 {
    use statrs::distribution::{ChiSquared, ContinuousCDF};
    let tail = ChiSquared::new(dof as f64).map_or(1.0, |d| d.sf(chi_square));
    if tail > 1e-280 {
        return -tail.log10();
    }
    // Leading term of the incomplete gamma function.
    let half = chi_square / 2.0;
    (half - (dof as f64 / 2.0 - 1.0) * half.ln()) / std::f64::consts::LN_10
}

/// Squared size of a residual wrench in units of its uncertainty, over the directions that move.
fn standardised(residual: &Residual, dof: [bool; 3]) -> f64 {
    let mut covariance: Matrix3<f64> = residual.covariance;
    let mut wrench = Vector3::from(residual.wrench);
    for k in (0..3).filter(|&k| !dof[k]) {
        covariance.row_mut(k).fill(0.0);
        covariance.column_mut(k).fill(0.0);
        (covariance[(k, k)], wrench[k]) = (1.0, 0.0);
    }
    covariance.cholesky().map_or(0.0, |c| wrench.dot(&c.solve(&wrench)))
}

/// Stretches in which the residual wrench is not zero.
fn scan(episode: &[Residual], name: &str, dof: [bool; 3]) -> Vec<Window> {
    let directions = dof.iter().filter(|d| **d).count();
    let mut found: Vec<Window> = Vec::new();
    for residual in episode {
        let strength = surprise(standardised(residual, dof), directions);
        if strength < -SAMPLE_P.log10() {
            continue;
        }
        match found.last_mut() {
            Some(open) if residual.t - open.end <= BRIDGE => {
                open.end = residual.t;
                open.strength = open.strength.max(strength);
            }
            _ => {
                found.push(Window { episode: name.to_owned(), start: residual.t, end: residual.t, strength })
            }
        }
    }
    found.retain(|w| w.end - w.start >= SHORTEST);
    found
}

/// Shares of the innovations' excess over their own covariance.
fn channels(comparison: &Comparison, fit: &Fit) -> Result<Channels, InferError> {
    let mut excess = [0.0; 3];
    match comparison.with_channels(fit.channels) {
        Comparison::Motion(motion) => {
            for innovation in motion.innovations(&fit.model, &fit.values)?.iter().flatten().flatten() {
                for k in (0..3).filter(|&k| fit.model.dof[k]) {
                    excess[k] += innovation.error[k].powi(2) / innovation.covariance[(k, k)];
                }
            }
        }
        Comparison::Wrench(wrench) => {
            let plant = fit.model.plant(&fit.values)?;
            let rho = fit.model.body.gyration;
            for sample in wrench.samples() {
                let [x, y, torque] = sample.residual(&plant);
                let [x, y, _] = trundle_model::to_world([x, y, 0.0], sample.pose[2]);
                for (sum, r) in excess.iter_mut().zip([x, y, torque / rho]) {
                    *sum += r * r;
                }
            }
        }
    }
    let total: f64 = excess.iter().sum();
    if total <= 0.0 {
        return Ok(Channels::default());
    }
    let [x, y, theta] = excess.map(|e| e / total);
    Ok(Channels { x, y, theta })
}

/// The body point through which all residual wrenches pass, τ = x f_y − y f_x, if there is one:
/// within the footprint, within 10 cm, and explaining most of the moment.
pub(crate) fn line_of_action(residuals: &Residuals, model: &Model) -> Option<Point> {
    if model.on_rail() {
        return None;
    }
    let (mut normal, mut rhs, mut moment) = (nalgebra::Matrix2::zeros(), nalgebra::Vector2::zeros(), 0.0);
    let mut count = 0.0;
    for residual in residuals.iter().flatten() {
        let [fx, fy, torque] = residual.wrench;
        let weight = residual.covariance[(2, 2)].max(1e-12).recip();
        let row = nalgebra::Vector2::new(fy, -fx);
        normal += weight * row * row.transpose();
        rhs += weight * torque * row;
        moment += weight * torque * torque;
        count += 1.0;
    }
    let spread = normal.try_inverse()?;
    let point = spread * rhs;
    let unexplained = moment - point.dot(&rhs);
    let scale = (unexplained / count).max(1.0);
    // Neighbouring samples are nearly the same: count one in ten.
    let sd = [0, 1].map(|k| (10.0 * scale * spread[(k, k)]).max(0.0).sqrt());
    let [low, high] = model.body.bounds();
    let inside = (0..2).all(|k| (low[k] - 0.05..=high[k] + 0.05).contains(&point[k]));
    let sharp = sd.iter().all(|s| *s < 0.1) && unexplained < 0.3 * moment;
    (inside && sharp).then_some(Point { mean: [point[0], point[1]], sd })
}

/// Whether the residual belongs to slow or to fast motion.
fn regime(residuals: &Residuals, dof: [bool; 3]) -> Option<String> {
    let mut samples: Vec<(f64, f64)> = residuals
        .iter()
        .flatten()
        .map(|r| {
            let [vx, vy, _] = to_body(r.twist, r.pose[2]);
            (vx.hypot(vy), standardised(r, dof))
        })
        .collect();
    if samples.len() < 30 {
        return None;
    }
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let third = samples.len() / 3;
    let mean = |part: &[(f64, f64)]| part.iter().map(|s| s.1).sum::<f64>() / part.len() as f64;
    let (slow, fast) = (mean(&samples[..third]), mean(&samples[2 * third..]));
    let directions = dof.iter().filter(|d| **d).count() as f64;
    if slow.max(fast) < 3.0 * directions {
        return None;
    }
    Some(if slow > 2.0 * fast {
        format!("below {:.2} m/s and at reversals", samples[third].0)
    } else if fast > 2.0 * slow {
        format!("above {:.2} m/s", samples[2 * third].0)
    } else {
        "at every speed".to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surprise_is_finite_and_grows() {
        let values: Vec<f64> =
            [1.0, 20.0, 1000.0, 1200.0, 1400.0, 1e6].iter().map(|c| surprise(*c, 3)).collect();
        assert!(values.windows(2).all(|w| w[0] < w[1] && w[1].is_finite()), "{values:?}");
        // χ²₃ = 16.27 has p = 10⁻³.
        assert!((surprise(16.266, 3) - 3.0).abs() < 1e-3);
    }
}
