//! Poses at arbitrary times, by cubic Hermite interpolation of the smoothed motion, with uncertainty.

use super::noise::Noise;
use super::samples::PoseSample;
use super::sampling::latest;
use super::transform::wrapped;
use crate::motion::{self, Motion};

/// A planar pose with the variance of each coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PoseAt {
    /// x, y in m and the continuous angle in rad.
    pub pose: [f64; 3],
    /// Variances, m², m², rad².
    pub variance: [f64; 3],
    /// Correlation time of the error, s: the interval between the neighbouring samples.
    pub correlation: f64,
}

/// Poses of a frame over time.
#[derive(Debug, Clone)]
pub(crate) enum Trajectory {
    /// Smoothed poses and velocities at the samples.
    Smoothed(Vec<Motion>),
    /// The latest sample (equation 13 of the paper); also used if there are too few samples.
    Latest(Vec<PoseSample>),
}

impl Trajectory {
    /// Trajectory through poses with continuous angle. Fewer than [`motion::MIN_POSES_FOR_MOTION`] poses are not smoothed.
    pub fn new(samples: &[PoseSample], noise: &Noise, smoothed: bool) -> Self {
        let motion = if smoothed { motion::smooth(samples, noise, false) } else { vec![] };
        if motion.is_empty() { Self::Latest(samples.to_vec()) } else { Self::Smoothed(motion) }
    }

    /// Pose at time `t`, s. Before the first sample it is that of the first sample; after the last one of a smoothed
    /// trajectory the velocity is kept. `None` without samples.
    pub fn at(&self, t: f64) -> Option<PoseAt> {
        match self {
            Self::Latest(samples) => {
                let after = samples.partition_point(|p| p.t <= t).max(1);
                let exact = |p: &PoseSample| PoseAt { pose: p.pose, variance: [0.0; 3], correlation: 0.0 };
                samples.get(after - 1).map(exact)
            }
            Self::Smoothed(motion) => {
                let after = motion.partition_point(|m| m.t <= t);
                match (after.checked_sub(1).and_then(|k| motion.get(k)), motion.get(after)) {
                    (Some(before), Some(next)) => Some(between(before, next, t)),
                    (Some(last), None) => Some(beyond(last, t)),
                    (None, Some(first)) => Some(beyond(first, first.t)),
                    (None, None) => None,
                }
            }
        }
    }
}

/// Hermite interpolation in an interval of length `h`. With the elapsed share `s` and `u = s (1 − s)`, a unit error of the
/// velocities changes the pose by up to `h u`, and a unit error of the acceleration by up to `h² u / 2`.
fn between(a: &Motion, b: &Motion, t: f64) -> PoseAt {
    let h = b.t - a.t;
    let s = (t - a.t) / h;
    let u = s * (1.0 - s);
    let rise = s * s * (3.0 - 2.0 * s);
    let value = |k: usize| {
        let bend = u * h * ((1.0 - s) * a.twist[k] - s * b.twist[k]);
        a.pose[k] + rise * (b.pose[k] - a.pose[k]) + bend
    };
    let variance = |k: usize| {
        let mixed = |i: usize| (1.0 - s) * a.cov[k][i][i] + s * b.cov[k][i][i];
        mixed(0) + (h * u).powi(2) * mixed(1) + (h * h * u / 2.0).powi(2) * mixed(2)
    };
    PoseAt { pose: [0, 1, 2].map(value), variance: [0, 1, 2].map(variance), correlation: h }
}

/// Pose after the last sample, at constant velocity. The acceleration there is a measure of what this neglects.
fn beyond(last: &Motion, t: f64) -> PoseAt {
    let h = t - last.t;
    let variance = |k: usize| {
        let [pose, twist, accel] = [0, 1, 2].map(|i| last.cov[k][i][i]);
        pose + h * h * twist + (h * h / 2.0).powi(2) * (last.accel[k].powi(2) + accel)
    };
    let pose = [0, 1, 2].map(|k| last.pose[k] + h * last.twist[k]);
    PoseAt { pose, variance: [0, 1, 2].map(variance), correlation: h }
}

/// `samples` with a continuous angle.
pub(crate) fn continuous(samples: impl IntoIterator<Item = PoseSample>) -> Vec<PoseSample> {
    let mut last: Option<f64> = None;
    let follow = |PoseSample { t, pose: [x, y, angle] }| {
        let angle = last.map_or(angle, |before| before + wrapped(angle - before));
        last = Some(angle);
        PoseSample { t, pose: [x, y, angle] }
    };
    samples.into_iter().map(follow).collect()
}

/// Index of the last sample not after `t`, and the elapsed share of the interval after it. Clamped to the first and the last
/// sample; `None` without samples.
pub(crate) fn share(times: &[f64], t: f64) -> Option<(usize, f64)> {
    let before = latest(times, t);
    match (before, times.get(before.map_or(0, |k| k + 1))) {
        (None, first) => first.map(|_| (0, 0.0)),
        (Some(k), None) => Some((k, 0.0)),
        (Some(k), Some(next)) => Some((k, (t - times[k]) / (next - times[k]))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: Noise =
        Noise { pose: [1e-4, 1e-4, 1e-4], force: 0.4, torque: 0.05, time: 0.0, stated: true };

    fn swing(step: f64, until: f64) -> Vec<PoseSample> {
        let pose = |t: f64| [0.1 * t * t, 0.3, 0.8 * (2.0 * t).sin()];
        let count = (until / step).round() as usize;
        (0..=count).map(|k| PoseSample { t: k as f64 * step, pose: pose(k as f64 * step) }).collect()
    }

    #[test]
    fn interpolation_is_accurate_between_slow_samples() {
        let trajectory = Trajectory::new(&swing(0.1, 3.0), &NOISE, true);
        for k in 3..27 {
            let t = 0.1 * f64::from(k) + 0.05;
            let at = trajectory.at(t).unwrap();
            let truth = 0.8 * (2.0 * t).sin();
            assert!((at.pose[2] - truth).abs() < 2e-3, "{t}: {} for {truth}", at.pose[2]);
            assert!((at.pose[2] - truth).abs() < 4.0 * at.variance[2].sqrt(), "sd {}", at.variance[2].sqrt());
        }
    }

    #[test]
    fn beyond_the_last_sample_the_velocity_is_kept_and_the_uncertainty_grows() {
        let trajectory = Trajectory::new(&swing(0.02, 3.0), &NOISE, true);
        for late in [0.1, 0.3] {
            let at = trajectory.at(3.0 + late).unwrap();
            let error = (at.pose[2] - 0.8 * (2.0 * (3.0 + late)).sin()).abs();
            assert!(error < 3.0 * at.variance[2].sqrt(), "{late}: {error}, sd {}", at.variance[2].sqrt());
            assert!(error < 0.1 * late, "{late}: {error}");
        }
        let [before, first] = [-1.0, 0.0].map(|t| trajectory.at(t).unwrap().pose);
        assert_eq!(before, first, "before the first sample the pose is not extrapolated");
    }

    #[test]
    fn latest_uses_the_sample_before() {
        let trajectory = Trajectory::new(&swing(0.1, 3.0), &NOISE, false);
        assert_eq!(trajectory.at(1.04), trajectory.at(1.0));
        assert_eq!(trajectory.at(-1.0), trajectory.at(0.0));
    }
}
