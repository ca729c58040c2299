//! A first guess of the mass, for a fit to start from.

use nalgebra::{Matrix3, Vector3};

use crate::motion::Motion;

use super::sampling::{latest, quantile};
use super::tare::GRAVITY;
use super::{Noise, Prepared};

/// Friction coefficient of a thing that is dragged, where the motion says nothing about its mass.
const DRAG: f64 = 0.3;
/// Accelerations of a pushed thing under its largest force, m/s²: a guess outside is no guess.
const PLAUSIBLE: [f64; 2] = [0.01, 20.0];
/// Where not even a force was recorded, kg.
const UNKNOWN: f64 = 1.0;

/// Mass that explains force by acceleration beside a viscous and a dry resistance, kg. Where that is not
/// plausible, as in slow pushes, the mass that such a force would drag along.
pub(crate) fn guess(episodes: &[Prepared], noise: &Noise) -> f64 {
    let forces = episodes.iter().flat_map(|e| e.wrench.iter().map(|w| w.reading[0].hypot(w.reading[1])));
    let peak = quantile(forces, 0.95).unwrap_or(0.0);
    if peak <= 0.0 {
        return UNKNOWN;
    }
    let plausible = peak / PLAUSIBLE[1]..peak / PLAUSIBLE[0];
    regressed(episodes, noise).filter(|mass| plausible.contains(mass)).unwrap_or(peak / (DRAG * GRAVITY))
}

fn regressed(episodes: &[Prepared], noise: &Noise) -> Option<f64> {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for episode in episodes {
        let times: Vec<f64> = episode.wrench.iter().map(|w| w.t).collect();
        for motion in episode.motion(noise) {
            let Some(at) = latest(&times, motion.t) else { continue };
            let wrench = &episode.wrench[at];
            let (sin, cos) = (motion.pose[2] + wrench.frame[2]).sin_cos();
            let [fx, fy, _] = wrench.reading;
            for (axis, force) in [cos * fx - sin * fy, sin * fx + cos * fy].into_iter().enumerate() {
                let row = regressors(&motion, axis);
                normal += row * row.transpose();
                right += row * force;
            }
        }
    }
    let solution = normal.pseudo_inverse(1e-9 * normal.norm()).ok()? * right;
    Some(solution[0]).filter(|mass| mass.is_finite())
}

/// Acceleration, velocity and direction of motion along one axis.
fn regressors(motion: &Motion, axis: usize) -> Vector3<f64> {
    let sd = motion.cov[axis][1][1].sqrt();
    let direction = motion.twist[axis] / (motion.twist[axis].hypot(3.0 * sd)).max(1e-9);
    Vector3::new(motion.accel[axis], motion.twist[axis], direction)
}
