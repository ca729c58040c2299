//! Twist and acceleration from poses, with uncertainty, by Kalman smoothing.
//!
//! Each axis is driven by white jerk of unknown intensity and measured with white noise of known variance. The intensity is
//! estimated by maximum likelihood. Errors of the time stamps add noise in proportion to the velocity, which a first
//! estimate without them gives.

mod bank;
mod cache;
mod intensity;
mod kalman;
mod low_pass;
mod spikes;
mod state;
mod symmetric;

use crate::prepare::{Noise, PoseSample};
use bank::Bank;
pub use cache::MotionCache;
use kalman::{Axis, Estimate};
pub use low_pass::low_pass;
use rayon::prelude::*;
pub(crate) use spikes::spikes;
pub use state::Motion;

/// Minimum number of poses of an episode for an estimate of its velocity.
pub const MIN_POSES_FOR_MOTION: usize = 5;

/// Motion at each pose from all poses (fixed-interval smoother).
///
/// If `at_rest`, the object does not move at the first pose. Returns nothing for fewer than [`MIN_POSES_FOR_MOTION`] poses.
pub fn smooth(pose: &[PoseSample], noise: &Noise, at_rest: bool) -> Vec<Motion> {
    smooth_from(pose, noise, rest_at_first(pose, at_rest))
}

/// Like [`smooth`], for an object at rest until `rest_until`, s. With `None` it may move from the start.
pub fn smooth_from(pose: &[PoseSample], noise: &Noise, rest_until: Option<f64>) -> Vec<Motion> {
    motions(pose, noise, rest_until, |axis| axis.smooth(intensity::maximum_likelihood(axis)))
}

/// Motion at each pose from the poses up to that time (causal filter).
///
/// If `at_rest`, the object does not move at the first pose. Returns nothing for fewer than [`MIN_POSES_FOR_MOTION`] poses.
pub fn filter(pose: &[PoseSample], noise: &Noise, at_rest: bool) -> Vec<Motion> {
    filter_from(pose, noise, rest_at_first(pose, at_rest))
}

/// Like [`filter`], for an object at rest until `rest_until`, s. With `None` it may move from the start.
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
    if pose.len() < MIN_POSES_FOR_MOTION {
        return vec![];
    }
    let t: Vec<f64> = pose.iter().map(|p| p.t).collect();
    let axis = |k: usize| {
        let z: Vec<f64> = pose.iter().map(|p| p.pose[k]).collect();
        let plain = Axis::new(&t, &z, noise.pose[k], rest_until);
        if noise.time == 0.0 {
            return estimate(&plain);
        }
        let extra = estimate(&plain).iter().map(|e| timing_variance(e.mean[1], noise)).collect();
        estimate(&plain.with_extra(extra))
    };
    let axes: Vec<Vec<Estimate>> = (0..3).into_par_iter().map(axis).collect();
    (0..t.len()).map(|i| motion(t[i], [0, 1, 2].map(|k| &axes[k][i]))).collect()
}

/// Variance of a coordinate due to the error of the time stamps, at its velocity.
pub(crate) fn timing_variance(velocity: f64, noise: &Noise) -> f64 {
    (velocity * noise.time).powi(2)
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
