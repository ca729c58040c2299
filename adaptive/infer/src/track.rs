//! An episode divided into simulation steps.

use crate::InferError;
use crate::curve::{Curve, MeanReading};
use crate::timing::Timing;
use std::sync::Arc;
use trundle_model::{Clock, Real};
use trundle_record::{Motion, Noise, PoseSample, Prepared};

/// Minimum spacing of the poses used in a fit, as a share of the maximum step. Closer poses cost time and add
/// little information.
const MIN_POSE_SPACING: f64 = 0.5;

/// Factor on the steps of a coarse track.
const COARSE_STEP_FACTOR: f64 = 3.0;

/// Standard deviation of the twist of an object at rest, m/s and rad/s.
const RESTING_TWIST_SD: f64 = 1e-4;

/// A simulation step: the mean reading over it, and the pose measured at its end, if any.
#[derive(Clone, Debug)]
pub struct Step {
    /// Duration, s.
    pub dt: f64,
    /// Mean reading over the step, reading axes, N, N, N·m.
    pub reading: [f64; 3],
    /// Pose of the reading frame in the object frame, m, m, rad.
    pub frame: [f64; 3],
    /// Clock at the middle of the step.
    pub clock: Clock,
    /// Ratio of the variance of the mean reading to that of one sample: sample spacing over `dt`.
    pub thinning: f64,
    /// Variance of the mean reading in addition to the sensor noise, reading axes: from the frame's
    /// uncertainty and from variation between samples.
    pub spread: [f64; 3],
    /// Pose measured at the end.
    pub pose: Option<[f64; 3]>,
    /// Variances of that pose due to the error of its time stamp.
    pub timing_variance: [f64; 3],
}

impl Step {
    /// Mean reading over the step, corrected for delays and lags where `timing` is given.
    #[inline]
    pub(crate) fn reading<T: Real>(&self, curve: &Curve, timing: Option<&Timing<T>>) -> [T; 3] {
        match timing {
            None => self.reading.map(T::lift),
            Some(timing) => timing.mean(curve, self.clock.t - self.dt / 2.0, self.clock.t + self.dt / 2.0),
        }
    }
}

/// An episode as processed by the filter and the sensitivities.
#[derive(Clone, Debug)]
pub struct Track {
    /// The episode's name.
    pub name: String,
    /// Start time of the first step, s.
    pub start: f64,
    /// Initial pose and the variances of its coordinates.
    pub pose: ([f64; 3], [f64; 3]),
    /// Initial twist, world axes, and its variances.
    pub twist: ([f64; 3], [f64; 3]),
    /// Variance of the tare error, reading axes.
    pub tare: [f64; 3],
    /// The steps.
    pub steps: Vec<Step>,
    /// All readings of the episode.
    pub(crate) curve: Arc<Curve>,
}

impl Track {
    /// Divides an episode into steps. An object at rest is followed from contact on.
    ///
    /// # Errors
    /// When fewer than five poses or two wrench samples are left.
    pub fn new(episode: &Prepared, noise: &Noise) -> Result<Self, InferError> {
        Self::with_steps(episode, noise, 1.0)
    }

    /// The same in longer steps, for a first search.
    ///
    /// # Errors
    /// As [`Track::new`].
    pub fn coarse(episode: &Prepared, noise: &Noise) -> Result<Self, InferError> {
        Self::with_steps(episode, noise, COARSE_STEP_FACTOR)
    }

    /// The same with steps longer by the factor `times`.
    fn with_steps(episode: &Prepared, noise: &Noise, times: f64) -> Result<Self, InferError> {
        let no_data = |reason: &str| InferError::NoData {
            recording: episode.name.clone(),
            reason: reason.to_owned(),
            remedy: "leave the episode out, or record more of it".to_owned(),
        };
        if episode.wrench.len() < 2 {
            return Err(no_data("fewer than two wrench samples are left"));
        }
        let poses = &episode.pose;
        let first = if episode.at_rest { last_resting_pose(episode, noise) } else { 0 };
        if poses.len() < first + 5 {
            return Err(no_data("fewer than five poses are left from contact on"));
        }
        let (pose, twist) = start(episode, noise, first);
        let curve = Arc::new(Curve::with_noise(episode, noise));
        let max_step = times * curve.max_step();
        let min_spacing = MIN_POSE_SPACING * max_step;
        let mut steps = Vec::new();
        let mut from = poses[first].t;
        let timing = episode.timing_variances(noise);
        for (index, pose) in poses.iter().enumerate().skip(first + 1) {
            if pose.t - from > 0.99 * min_spacing {
                cut_into_steps(from, pose, &curve, max_step, &mut steps);
                set_timing_variance(&mut steps, &timing, index);
                from = pose.t;
            }
        }
        let tare = crate::noise::tare_variance(episode);
        Ok(Self { name: episode.name.clone(), start: poses[first].t, pose, twist, tare, steps, curve })
    }

    /// The poses `first + 1..end` of an episode, from a known state at the pose `first`. `timing`: see
    /// [`Prepared::timing_variances`].
    pub(crate) fn between(
        episode: &Prepared,
        curve: &Arc<Curve>,
        first: usize,
        end: usize,
        known: &Motion,
        timing: &[[f64; 3]],
    ) -> Self {
        let mut steps = Vec::new();
        for (index, pair) in (first + 1..).zip(episode.pose[first..end.max(first + 1)].windows(2)) {
            cut_into_steps(pair[0].t, &pair[1], curve, curve.max_step(), &mut steps);
            set_timing_variance(&mut steps, timing, index);
        }
        Self {
            name: episode.name.clone(),
            start: known.t,
            pose: (known.pose, [0, 1, 2].map(|k| known.cov[k][0][0])),
            twist: (known.twist, [0, 1, 2].map(|k| known.cov[k][1][1])),
            tare: crate::noise::tare_variance(episode),
            steps,
            curve: curve.clone(),
        }
    }

    /// The part of the track up to a time, s.
    pub(crate) fn until(&self, end: f64) -> Self {
        let mut t = self.start;
        let before = self.steps.iter().take_while(|step| {
            t += step.dt;
            t <= end
        });
        Self { steps: before.cloned().collect(), ..self.clone() }
    }

    /// Number of compared pose samples.
    pub fn observations(&self) -> usize {
        self.steps.iter().filter(|s| s.pose.is_some()).count()
    }
}

/// Deviation from rest that noise is unlikely to reach at two successive poses, standard deviations.
const MIN_MOTION_SD: f64 = 6.0;

/// Time for which an object may have moved before its motion is detected, s.
const MAX_UNDETECTED_S: f64 = 0.1;

/// Index of the last pose at rest: before contact and before detected motion, since a late reading also
/// delays the detection of contact.
fn last_resting_pose(episode: &Prepared, noise: &Noise) -> usize {
    let end = motion_onset(&episode.pose, noise.pose)
        .map_or(episode.contact, |t| episode.contact.min(t - MAX_UNDETECTED_S));
    episode.pose.iter().rposition(|p| p.t <= end).unwrap_or(0)
}

/// Time at which the poses leave the mean of the earlier ones, s.
fn motion_onset(poses: &[PoseSample], sd: [f64; 3]) -> Option<f64> {
    let (mut sum, mut left) = ([0.0; 3], None);
    for (n, pose) in poses.iter().enumerate() {
        let away = |k: usize| {
            (pose.pose[k] - sum[k] / n as f64).abs() > MIN_MOTION_SD * sd[k] * (1.0 + 1.0 / n as f64).sqrt()
        };
        match left {
            _ if n == 0 || !(0..3).any(away) => {
                left = None;
                sum = [0, 1, 2].map(|k| sum[k] + pose.pose[k]);
            }
            None => left = Some(pose.t),
            Some(_) => return left,
        }
    }
    None
}

type WithVariance = ([f64; 3], [f64; 3]);

/// Initial pose and twist of the track, with their variances.
fn start(episode: &Prepared, noise: &Noise, first: usize) -> (WithVariance, WithVariance) {
    let variance = noise.pose.map(|s| s * s);
    if episode.at_rest {
        let seen = &episode.pose[..=first];
        let n = seen.len() as f64;
        let mean = [0, 1, 2].map(|k| seen.iter().map(|p| p.pose[k]).sum::<f64>() / n);
        return ((mean, variance.map(|v| v / n)), ([0.0; 3], [RESTING_TWIST_SD * RESTING_TWIST_SD; 3]));
    }
    let motion = episode.motion(noise);
    match motion.first() {
        Some(m) => ((m.pose, variance), (m.twist, [0, 1, 2].map(|k| 4.0 * m.cov[k][1][1]))),
        None => ((episode.pose[0].pose, variance), ([0.0; 3], [1.0; 3])),
    }
}

/// Set the variance of the pose at the end of the last step, which is number `index` of the episode.
fn set_timing_variance(steps: &mut [Step], timing: &[[f64; 3]], index: usize) {
    if let (Some(step), Some(variance)) = (steps.last_mut(), timing.get(index)) {
        step.timing_variance = *variance;
    }
}

/// Divides the time between two poses into equal steps.
pub(crate) fn cut_into_steps(
    from: f64,
    to: &PoseSample,
    curve: &Curve,
    max_step: f64,
    steps: &mut Vec<Step>,
) {
    let pieces = ((to.t - from) / max_step).ceil().max(1.0);
    let dt = (to.t - from) / pieces;
    for k in 0..pieces as usize {
        let begin = from + k as f64 * dt;
        let MeanReading { reading, frame, spacing, spread } = curve.mean(begin, begin + dt);
        let pose = (k + 1 == pieces as usize).then_some(to.pose);
        let clock = curve.clock_of_step(begin + dt / 2.0, dt, frame, spacing);
        let thinning = spacing / dt;
        steps.push(Step { dt, reading, frame, clock, thinning, spread, pose, timing_variance: [0.0; 3] });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motion_onset_is_detected_before_contact() {
        let noise = |k: usize| 2e-4 * ((12.9 * k as f64).sin() + (78.2 * k as f64).sin());
        let pose = |k: usize| {
            let t = k as f64 / 60.0;
            let moved = 0.5 * (t - 0.5).max(0.0).powi(2);
            PoseSample { t, pose: [3.0 + moved + noise(k), -1.0 + noise(k + 7), 0.3] }
        };
        let poses: Vec<_> = (0..100).map(pose).collect();
        let seen = motion_onset(&poses, [5e-4, 5e-4, 1.75e-3]).unwrap();
        assert!((0.52..0.5 + MAX_UNDETECTED_S).contains(&seen), "seen to move at {seen} s");
        assert_eq!(motion_onset(&poses[..30], [5e-4, 5e-4, 1.75e-3]), None);
    }
}
