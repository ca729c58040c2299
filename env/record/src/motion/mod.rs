//! Twist and acceleration from poses: a Kalman smoother with stated uncertainty.
//!
//! Each axis is a pose driven by white jerk of unknown intensity, seen through white noise of known size.
//! The intensity is the one that makes the poses likeliest.

mod bank;
mod intensity;
mod kalman;
mod low_pass;
mod memo;
mod spikes;
mod symmetric;

use crate::prepare::{Noise, PoseSample};
use bank::Bank;
use kalman::{Axis, Estimate};
pub use low_pass::low_pass;
pub use memo::Memo;
use rayon::prelude::*;
pub(crate) use spikes::spikes;

/// Fewer poses than this in an episode say nothing about velocity.
pub const FEWEST_POSES: usize = 5;

/// What the poses say about the object's motion at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Time, s.
    pub t: f64,
    /// x, y in m and theta in rad of the object frame in the world.
    pub pose: [f64; 3],
    /// Velocity of the object frame's origin in world axes, m/s, and the turn rate, rad/s.
    pub twist: [f64; 3],
    /// Its derivative, m/s² and rad/s².
    pub accel: [f64; 3],
    /// For each axis (x, y, theta) the covariance of its (pose, velocity, acceleration).
    pub cov: [[[f64; 3]; 3]; 3],
}

/// Motion at each pose from all poses, before and after it (a fixed-interval smoother).
///
/// `at_rest`: the object does not move at the first pose. Empty for fewer than [`FEWEST_POSES`] poses.
pub fn smooth(pose: &[PoseSample], noise: &Noise, at_rest: bool) -> Vec<Motion> {
    smooth_from(pose, noise, rest_at_first(pose, at_rest))
}

/// As [`smooth`], for an object that rests until `rest_until`, s; `None`: it may move from the start.
pub fn smooth_from(pose: &[PoseSample], noise: &Noise, rest_until: Option<f64>) -> Vec<Motion> {
    motions(pose, noise, rest_until, |axis| axis.smooth(intensity::likeliest(axis)))
}

/// Motion at each pose from the poses up to it only.
///
/// `at_rest`: the object does not move at the first pose. Empty for fewer than [`FEWEST_POSES`] poses.
pub fn filter(pose: &[PoseSample], noise: &Noise, at_rest: bool) -> Vec<Motion> {
    filter_from(pose, noise, rest_at_first(pose, at_rest))
}

/// As [`filter`], for an object that rests until `rest_until`, s; `None`: it may move from the start.
pub fn filter_from(pose: &[PoseSample], noise: &Noise, rest_until: Option<f64>) -> Vec<Motion> {
    motions(pose, noise, rest_until, Bank::run)
}

fn rest_at_first(pose: &[PoseSample], at_rest: bool) -> Option<f64> {
    pose.first().filter(|_| at_rest).map(|first| first.t)
}

fn motions(
    pose: &[PoseSample],
    noise: &Noise,
    rest_until: Option<f64>,
    estimate: impl Fn(&Axis) -> Vec<Estimate> + Sync,
) -> Vec<Motion> {
    if pose.len() < FEWEST_POSES {
        return vec![];
    }
    let t: Vec<f64> = pose.iter().map(|p| p.t).collect();
    let axis = |k: usize| {
        let z: Vec<f64> = pose.iter().map(|p| p.pose[k]).collect();
        estimate(&Axis::new(&t, &z, noise.pose[k], rest_until))
    };
    let axes: Vec<Vec<Estimate>> = (0..3).into_par_iter().map(axis).collect();
    (0..t.len()).map(|i| motion(t[i], [0, 1, 2].map(|k| &axes[k][i]))).collect()
}

fn motion(t: f64, axes: [&Estimate; 3]) -> Motion {
    Motion {
        t,
        pose: axes.map(|a| a.mean[0]),
        twist: axes.map(|a| a.mean[1]),
        accel: axes.map(|a| a.mean[2]),
        cov: axes.map(|a| a.cov.rows()),
    }
}

#[cfg(test)]
mod tests;
