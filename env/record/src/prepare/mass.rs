//! Initial guess of the mass for a fit.

use nalgebra::{Matrix3, Vector3};

use crate::motion::Motion;

use super::dataset::Prepared;
use super::noise::Noise;
use super::sampling::{latest, quantile};
use trundle_model::STANDARD_GRAVITY_M_PER_S2;

/// Friction coefficient of a dragged object, used if the motion does not determine the mass.
const DEFAULT_FRICTION_COEFFICIENT: f64 = 0.3;
/// Plausible range of the acceleration of a pushed object under its largest force, m/s².
const PLAUSIBLE_ACCELERATION_M_PER_S2: [f64; 2] = [0.01, 20.0];
/// Guess without any recorded force, kg.
const DEFAULT_MASS_KG: f64 = 1.0;

/// Mass from a regression of the force on acceleration, velocity and direction of motion, kg. If the result is not
/// plausible, as for slow pushes, the mass that the force would drag against dry friction.
pub(crate) fn guess(episodes: &[Prepared], noise: &Noise) -> f64 {
    let forces = episodes.iter().flat_map(|e| e.wrench.iter().map(|w| w.reading[0].hypot(w.reading[1])));
    let peak = quantile(forces, 0.95).unwrap_or(0.0);
    if peak <= 0.0 {
        return DEFAULT_MASS_KG;
    }
    let plausible = peak / PLAUSIBLE_ACCELERATION_M_PER_S2[1]..peak / PLAUSIBLE_ACCELERATION_M_PER_S2[0];
    regressed(episodes, noise)
        .filter(|mass| plausible.contains(mass))
        .unwrap_or(peak / (DEFAULT_FRICTION_COEFFICIENT * STANDARD_GRAVITY_M_PER_S2))
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

/// Regressors of the force along one axis: acceleration, velocity and direction of motion.
fn regressors(motion: &Motion, axis: usize) -> Vector3<f64> {
    let sd = motion.cov[axis][1][1].sqrt();
    let direction = motion.twist[axis] / (motion.twist[axis].hypot(3.0 * sd)).max(1e-9);
    Vector3::new(motion.accel[axis], motion.twist[axis], direction)
}
