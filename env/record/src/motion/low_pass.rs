//! Zero-phase low-pass filter for irregularly sampled signals, based on the Kalman smoother.

use super::kalman::Axis;

/// Low-pass filtered `signal` at its sample times `t`, s, with cutoff `frequency`, Hz.
///
/// The filter is a third-order Butterworth filter run forwards and backwards. Its gain is `1/(1 + (ω/ω₀)⁶)`, one half at
/// the cutoff `ω₀`. Samples may be irregular.
///
/// It is the smoother of a signal driven by white jerk of intensity `q`, measured every `T` seconds with noise of variance
/// `r`. In the steady state, `ω₀⁶ = q/(r T)`: the gain is the ratio of the spectrum of the signal, `q/ω⁶`, to the sum of
/// this and the spectrum of the noise, `r T` (Wiener 1949, "Extrapolation, interpolation and smoothing of stationary time
/// series", chapter 3).
pub fn low_pass(t: &[f64], signal: &[f64], frequency: f64) -> Vec<f64> {
    let rms = (signal.iter().map(|z| z * z).sum::<f64>() / signal.len().max(1) as f64).sqrt();
    let (Some(first), Some(last)) = (t.first(), t.last()) else { return vec![] };
    if rms == 0.0 || last <= first {
        return signal.to_vec();
    }
    let spacing = (last - first) / (t.len() - 1) as f64;
    // Only the ratio of signal to noise matters. The scale of the signal keeps the prior of the first sample diffuse.
    let jerk = rms * rms * spacing * (std::f64::consts::TAU * frequency).powi(6);
    Axis::new(t, signal, rms, None).smooth(jerk).iter().map(|state| state.mean[0]).collect()
}

#[cfg(test)]
mod tests {
    use super::low_pass;
    use std::f64::consts::TAU;

    /// Gain for a sine wave in the middle of 20 s.
    fn gain(frequency: f64, t: &[f64]) -> f64 {
        let wave = |t: f64| (TAU * frequency * t).sin();
        let signal: Vec<f64> = t.iter().map(|&t| wave(t)).collect();
        let filtered = low_pass(t, &signal, 2.0);
        let middle = || t.iter().zip(&filtered).filter(|(t, _)| (5.0..15.0).contains(*t));
        let power: f64 = middle().map(|(&t, _)| wave(t).powi(2)).sum();
        middle().map(|(&t, y)| wave(t) * y).sum::<f64>() / power
    }

    #[test]
    fn gain_equals_that_of_a_zero_phase_butterworth_filter() {
        let regular: Vec<f64> = (0..2000).map(|k| f64::from(k) * 0.01).collect();
        let irregular: Vec<f64> =
            regular.iter().enumerate().filter(|(k, _)| k % 7 != 3).map(|(_, &t)| t).collect();
        for t in [&regular, &irregular] {
            for frequency in [0.5, 1.0, 2.0, 3.0, 5.0] {
                let expected = 1.0 / (1.0 + (frequency / 2.0_f64).powi(6));
                let found = gain(frequency, t);
                assert!((found - expected).abs() < 0.03, "{frequency} Hz: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn signals_below_the_cutoff_pass_at_any_scale() {
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
