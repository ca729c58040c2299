//! Detection of contact and of rest.
//!
//! Contact begins with the first reading above its noise, or with a sustained load that is too weak to show in one reading.

use super::samples::PoseSample;
use super::sampling::{median, median_step, quantile};

/// Length of the window over which a weak load must last, s.
const SUSTAINED_WINDOW_S: f64 = 0.1;
/// Minimum number of samples in the window.
const MIN_WINDOW_SAMPLES: usize = 4;
/// Variance of a median relative to that of a mean. The median is insensitive to single spikes.
const MEDIAN_VARIANCE_RATIO: f64 = 1.6;
/// χ² (3 degrees of freedom) of a load. Noise exceeds it with a probability of 10⁻¹², with margin for an error of the tare.
const LOAD_CHI2: f64 = 60.0;
/// χ² (3 degrees of freedom) above which preceding readings belong to the rising load: about three standard deviations.
const RISING_CHI2: f64 = 14.0;
/// Share of the episode's peak load below which a load may be a drift of the tare.
const MIN_PEAK_SHARE: f64 = 0.02;
/// Slope of the poses before contact, in standard deviations, above which an object is not at rest.
const MAX_RESTING_SLOPE_SD: f64 = 6.0;

/// Start of contact, s; `None` without any load. An impact in a single reading counts, so that no recorded impulse lies
/// before contact.
///
/// `readings` are planar tared wrenches, `sd` is their noise for force and torque, and `tare_sd` that of the tare.
pub(crate) fn begins(t: &[f64], readings: &[[f64; 3]], sd: [f64; 2], tare_sd: &[f64; 3]) -> Option<f64> {
    let width = window(t);
    if t.len() < width {
        return None;
    }
    let peak = peaks(readings);
    let noise = [sd[0], sd[0], sd[1]];
    let floor = [0, 1, 2].map(|k| MIN_PEAK_SHARE * peak[k / 2]);
    let scale = |share: f64| {
        let variance = |k: usize| noise[k] * noise[k] * share + tare_sd[k] * tare_sd[k];
        [0, 1, 2].map(|k| variance(k).max(floor[k] * floor[k] / LOAD_CHI2))
    };
    let load = |reading: &[f64; 3], scale: &[f64; 3]| -> f64 {
        (0..3).map(|k| ratio(reading[k].powi(2), scale[k])).sum()
    };
    let (single, of_median) = (scale(1.0), scale(MEDIAN_VARIANCE_RATIO / width as f64));
    let impact = readings.iter().position(|r| load(r, &single) > LOAD_CHI2).map(|at| {
        let before = readings[..at].iter().rev().take_while(|r| load(r, &single) > RISING_CHI2).count();
        at - before
    });
    let sustained = |at: &usize| {
        let median_of = |k: usize| median(readings[*at..*at + width].iter().map(|r| r[k])).unwrap_or(0.0);
        load(&[0, 1, 2].map(median_of), &of_median) > LOAD_CHI2
    };
    let last = impact.unwrap_or(t.len()).min(t.len() - width);
    // The window may begin before the load, so the load starts at the first sample above the noise.
    let leaves = |r: &[f64; 3]| (0..3).any(|k| r[k].abs() > (4.0 * noise[k]).max(floor[k]) && r[k] != 0.0);
    let weak = (0..=last)
        .find(sustained)
        .map(|first| first + readings[first..first + width].iter().position(leaves).unwrap_or(0));
    impact.into_iter().chain(weak).min().map(|at| t[at])
}

/// Whether the object is at rest until `until`, s: the regression of its poses on time has no significant slope. True if
/// there are too few poses.
pub(crate) fn rests(poses: &[PoseSample], sd: [f64; 3], until: f64) -> bool {
    let before = &poses[..poses.partition_point(|p| p.t <= until)];
    let n = before.len() as f64;
    if before.len() < MIN_WINDOW_SAMPLES {
        return true;
    }
    let middle = before.iter().map(|p| p.t).sum::<f64>() / n;
    let spread: f64 = before.iter().map(|p| (p.t - middle).powi(2)).sum();
    let slope = |k: usize| before.iter().map(|p| (p.t - middle) * p.pose[k]).sum::<f64>() / spread;
    (0..3).all(|k| slope(k).abs() <= MAX_RESTING_SLOPE_SD * sd[k] / spread.sqrt())
}

fn ratio(square: f64, variance: f64) -> f64 {
    if square == 0.0 { 0.0 } else { square / variance }
}

fn window(t: &[f64]) -> usize {
    let step = median_step(t).unwrap_or(SUSTAINED_WINDOW_S);
    ((SUSTAINED_WINDOW_S / step).round() as usize).max(MIN_WINDOW_SAMPLES)
}

/// The 95 % quantile of force and torque.
fn peaks(readings: &[[f64; 3]]) -> [f64; 2] {
    let force = quantile(readings.iter().map(|r| r[0].hypot(r[1])), 0.95);
    let torque = quantile(readings.iter().map(|r| r[2].abs()), 0.95);
    [force.unwrap_or(0.0), torque.unwrap_or(0.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SD: [f64; 2] = [0.4, 0.05];

    /// Deterministic noise of variance 1: a sum of incommensurable sines.
    fn noise(i: usize) -> f64 {
        [12.9898, 78.233, 37.719, 93.989].iter().map(|w| (w * i as f64).sin()).sum::<f64>() / 2f64.sqrt()
    }

    fn pushed_from(start: f64) -> (Vec<f64>, Vec<[f64; 3]>) {
        let t: Vec<f64> = (0..1000).map(|i| i as f64 * 0.005).collect();
        let load = |t: f64| if t < start { 0.0 } else { 20.0 };
        let reading = |(i, &t): (usize, &f64)| {
            [load(t) + SD[0] * noise(i), SD[0] * noise(i + 7000), SD[1] * noise(i + 9000)]
        };
        let readings = t.iter().enumerate().map(reading).collect();
        (t, readings)
    }

    #[test]
    fn a_push_is_found_where_it_starts() {
        let (t, readings) = pushed_from(1.7);
        let begin = begins(&t, &readings, SD, &[0.04, 0.04, 0.005]).unwrap();
        assert!((begin - 1.7).abs() < 0.02, "{begin}");
    }

    #[test]
    fn a_push_from_the_start_begins_with_the_first_reading() {
        let (t, readings) = pushed_from(-1.0);
        assert_eq!(begins(&t, &readings, SD, &[0.0; 3]), Some(0.0));
    }

    #[test]
    fn an_impact_in_one_reading_is_contact() {
        let (t, mut readings) = pushed_from(1.7);
        readings[40] = [90.0, 0.0, 3.0];
        let begin = begins(&t, &readings, SD, &[0.04, 0.04, 0.005]).unwrap();
        assert_eq!(begin, t[40]);
    }

    #[test]
    fn a_weak_load_is_found_once_it_lasts() {
        let (t, mut readings) = pushed_from(99.0);
        readings.iter_mut().zip(&t).filter(|(_, t)| **t >= 1.7).for_each(|(r, _)| r[0] += 1.6);
        let begin = begins(&t, &readings, SD, &[0.0; 3]).unwrap();
        assert!((begin - 1.7).abs() < 0.12, "{begin}");
    }

    #[test]
    fn a_moving_object_is_not_at_rest() {
        let poses = |speed: f64| -> Vec<PoseSample> {
            let pose = |k: usize| [speed * k as f64 / 60.0 + 5e-4 * noise(k), 5e-4 * noise(k + 300), 0.0];
            (0..60).map(|k| PoseSample { t: k as f64 / 60.0, pose: pose(k) }).collect()
        };
        let sd = [5e-4, 5e-4, 2e-3];
        assert!(rests(&poses(0.0), sd, 0.9));
        assert!(!rests(&poses(0.02), sd, 0.9));
        assert!(rests(&poses(0.02), sd, 0.01), "too few poses");
    }

    #[test]
    fn noise_alone_is_no_contact() {
        let (t, readings) = pushed_from(99.0);
        assert_eq!(begins(&t, &readings, SD, &[0.04, 0.04, 0.005]), None);
        assert_eq!(begins(&[], &[], SD, &[0.0; 3]), None);
        assert_eq!(begins(&t, &vec![[0.0; 3]; t.len()], [1e-6; 2], &[0.0; 3]), None);
    }
}
