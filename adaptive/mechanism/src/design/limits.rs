//! The recorded range of each joint's motion, within which trajectories are planned.

use crate::motion::Motion;
use crate::problem::Problem;
use serde::Serialize;

/// Range and largest values of a joint's motion in the training episodes.
#[derive(Clone, Debug, Serialize)]
pub struct JointLimits {
    /// Name of the joint.
    pub joint: String,
    /// Smallest and largest position, rad or m.
    pub position: [f64; 2],
    /// Largest speed.
    pub speed: f64,
    /// Largest acceleration.
    pub acceleration: f64,
    /// Largest effort of the drive.
    pub effort: f64,
    /// Speed below which samples are not compared.
    pub rest_speed: f64,
}

/// Limits of joint `j`.
pub(super) fn recorded_limits(problem: &Problem, motion: &Motion, j: usize) -> JointLimits {
    let setup = &problem.joints[j];
    let largest = |of: &dyn Fn(usize, usize) -> f64| {
        let mut found = 0.0f64;
        for (e, episode) in motion.episodes.iter().enumerate().filter(|(_, e)| !e.held_out) {
            let usable = (0..episode.usable[j].len()).filter(|k| episode.usable[j][*k]);
            found = usable.fold(found, |found, k| found.max(of(e, k).abs()));
        }
        found
    };
    let gain = problem.episodes.iter().find_map(|e| e.joints[j].gain).unwrap_or(setup.reference_gain);
    JointLimits {
        joint: setup.name.clone(),
        position: setup.scales.range,
        speed: largest(&|e, k| motion.episodes[e].v[j][k]),
        acceleration: largest(&|e, k| motion.episodes[e].a[j][k]),
        effort: setup.largest_command * gain.abs(),
        rest_speed: setup.rest_speed,
    }
}
