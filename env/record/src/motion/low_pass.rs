//! A zero-phase low-pass filter for samples at irregular times: the smoother of this module, used on any signal.

use super::kalman::Axis;

/// The part of a signal below a frequency, Hz, at its own sample times `t`, s.
///
/// In the steady state the smoother of a signal driven by white jerk of intensity q, seen through white noise of variance r every
/// T seconds, has the transfer 1/(1 + (ω/ω₀)⁶) with ω₀⁶ = q/(r T): the signal's spectrum q/ω⁶ over its sum with the noise's,
/// r T (Wiener 1949, "Extrapolation, interpolation and smoothing of stationary time series", chapter 3). Here ω₀ is given: a
/// Butterworth filter of third order, run forwards and backwards, that needs no regular samples. Its transfer at
/// `frequency` is one half.
pub fn low_pass(t: &[f64], signal: &[f64], frequency: f64) -> Vec<f64> {
    let rms = (signal.iter().map(|z| z * z).sum::<f64>() / signal.len().max(1) as f64).sqrt();
    let (Some(first), Some(last)) = (t.first(), t.last()) else { return vec![] };
    if rms == 0.0 || last <= first {
        return signal.to_vec();
    }
    let spacing = (last - first) / (t.len() - 1) as f64;
    // Only the ratio of signal to noise counts; the signal's own size keeps the first sample's prior vague.
    let jerk = rms * rms * spacing * (std::f64::consts::TAU * frequency).powi(6);
    Axis::new(t, signal, rms, None).smooth(jerk).iter().map(|state| state.mean[0]).collect()
}

#[cfg(test)]
mod tests {
    use super::low_pass;
    use std::f64::consts::TAU;

    /// Amplitude of a sine wave after the filter, in the middle of 20 s.
    fn passed(frequency: f64, t: &[f64]) -> f64 {
        let wave = |t: f64| (TAU * frequency * t).sin();
        let signal: Vec<f64> = t.iter().map(|&t| wave(t)).collect();
        let filtered = low_pass(t, &signal, 2.0);
        let middle = || t.iter().zip(&filtered).filter(|(t, _)| (5.0..15.0).contains(*t));
        let power: f64 = middle().map(|(&t, _)| wave(t).powi(2)).sum();
        middle().map(|(&t, y)| wave(t) * y).sum::<f64>() / power
    }

    #[test]
    fn the_transfer_is_that_of_a_butterworth_filter_run_both_ways() {
        let regular: Vec<f64> = (0..2000).map(|k| f64::from(k) * 0.01).collect();
        let irregular: Vec<f64> =
            regular.iter().enumerate().filter(|(k, _)| k % 7 != 3).map(|(_, &t)| t).collect();
        for t in [&regular, &irregular] {
            for frequency in [0.5, 1.0, 2.0, 3.0, 5.0] {
                let expected = 1.0 / (1.0 + (frequency / 2.0_f64).powi(6));
                let found = passed(frequency, t);
                assert!((found - expected).abs() < 0.03, "{frequency} Hz: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn what_is_below_the_frequency_keeps_its_size_whatever_its_unit() {
        let t: Vec<f64> = (0..500).map(|k| f64::from(k) * 0.01).collect();
        for scale in [1e-6, 1.0, 1e6] {
            let signal: Vec<f64> = t.iter().map(|t| scale * (3.0 + 0.2 * t)).collect();
            for (a, b) in low_pass(&t, &signal, 2.0).iter().zip(&signal) {
                assert!((a - b).abs() < 1e-3 * scale, "{a} {b}");
            }
        }
        assert!(low_pass(&[], &[], 2.0).is_empty());
        assert_eq!(low_pass(&[1.0], &[4.0], 2.0), [4.0]);
    }
}
