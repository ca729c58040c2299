//! When the poses of an object at rest first show motion.

use trundle_record::{Noise, PoseSample, Prepared};

/// Deviation from rest that noise is unlikely to reach at two successive poses, standard deviations.
const MIN_MOTION_SD: f64 = 6.0;

/// Time for which an object may have moved before its motion is detected, s.
const MAX_UNDETECTED_S: f64 = 0.1;

/// Time before which the poses show no motion, s; infinite if they never show any.
pub(crate) fn earliest_motion(episode: &Prepared, noise: &Noise) -> f64 {
    motion_onset(&episode.pose, noise.pose).map_or(f64::INFINITY, |t| t - MAX_UNDETECTED_S)
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
