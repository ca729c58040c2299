//! When contact begins: the start of the first sustained load above the noise.

use super::sampling::{median, median_step, quantile};

/// Length of the window over which a load must last, s.
const SUSTAINED: f64 = 0.1;
/// Fewest samples of it.
const FEWEST: usize = 4;
/// Variance of a median over that of a mean: the price of not taking one spike for a load.
const MEDIAN_COST: f64 = 1.6;
/// χ² (3 degrees of freedom) of a window's median that noise does not reach, one in 10⁸, with room for a tare error.
const GATE: f64 = 60.0;
/// Share of the episode's peak load below which a load may be a drift of the tare.
const SHARE: f64 = 0.02;

/// Time at which contact begins, s: the first reading if it already bears load, and `None` if nothing ever does.
///
/// `readings`: planar wrenches after the tare; `sd`: their noise for force and torque; `tare_sd`: of the tare.
pub(crate) fn begins(t: &[f64], readings: &[[f64; 3]], sd: [f64; 2], tare_sd: &[f64; 3]) -> Option<f64> {
    let width = window(t);
    if t.len() < width {
        return None;
    }
    let peak = peaks(readings);
    let noise = [sd[0], sd[0], sd[1]];
    let floor = [0, 1, 2].map(|k| SHARE * peak[k / 2]);
    let scale = [0, 1, 2].map(|k| {
        let of_median = MEDIAN_COST * noise[k] * noise[k] / width as f64 + tare_sd[k] * tare_sd[k];
        of_median.max(floor[k] * floor[k] / GATE)
    });
    let bears = |at: usize| {
        let load = |k: usize| median(readings[at..at + width].iter().map(|r| r[k])).unwrap_or(0.0);
        (0..3).map(|k| ratio(load(k).powi(2), scale[k])).sum::<f64>() > GATE
    };
    let first = (0..=t.len() - width).find(|&at| bears(at))?;
    // The window may begin before the load: its first sample that leaves the noise is the start.
    let leaves = |r: &[f64; 3]| (0..3).any(|k| r[k].abs() > (4.0 * noise[k]).max(floor[k]) && r[k] != 0.0);
    let within = readings[first..first + width].iter().position(leaves);
    Some(t[first + within.unwrap_or(0)])
}

fn ratio(square: f64, variance: f64) -> f64 {
    if square == 0.0 { 0.0 } else { square / variance }
}

fn window(t: &[f64]) -> usize {
    let step = median_step(t).unwrap_or(SUSTAINED);
    ((SUSTAINED / step).round() as usize).max(FEWEST)
}

/// Load that is exceeded a twentieth of the time: force, torque.
fn peaks(readings: &[[f64; 3]]) -> [f64; 2] {
    let force = quantile(readings.iter().map(|r| r[0].hypot(r[1])), 0.95);
    let torque = quantile(readings.iter().map(|r| r[2].abs()), 0.95);
    [force.unwrap_or(0.0), torque.unwrap_or(0.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SD: [f64; 2] = [0.4, 0.05];

    /// A little noise without a random generator: a sum of incommensurable sines, variance 1.
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
    fn a_push_already_on_begins_with_the_first_reading() {
        let (t, readings) = pushed_from(-1.0);
        assert_eq!(begins(&t, &readings, SD, &[0.0; 3]), Some(0.0));
    }

    #[test]
    fn a_knock_is_no_sustained_load() {
        let (t, mut readings) = pushed_from(1.7);
        readings[40] = [90.0, 0.0, 3.0];
        let begin = begins(&t, &readings, SD, &[0.04, 0.04, 0.005]).unwrap();
        assert!((begin - 1.7).abs() < 0.02, "{begin}");
    }

    #[test]
    fn noise_alone_is_no_contact() {
        let (t, readings) = pushed_from(99.0);
        assert_eq!(begins(&t, &readings, SD, &[0.04, 0.04, 0.005]), None);
        assert_eq!(begins(&[], &[], SD, &[0.0; 3]), None);
        assert_eq!(begins(&t, &vec![[0.0; 3]; t.len()], [1e-6; 2], &[0.0; 3]), None);
    }
}
