//! Difference quotients, delays and lags of uniformly sampled signals.

use trundle_model::Real;

/// Central difference.
pub(crate) fn slope(samples: &[f64], k: usize, dt: f64) -> f64 {
    let (before, after) = (k.saturating_sub(1), (k + 1).min(samples.len() - 1));
    if after == before { 0.0 } else { (samples[after] - samples[before]) / ((after - before) as f64 * dt) }
}

/// Samples at earlier times, by the cubic through the neighbours (Catmull-Rom); `delay` is in intervals.
pub(crate) fn delayed<T: Real>(samples: &[f64], delay: T) -> Vec<T> {
    let last = samples.len().saturating_sub(1);
    let one = |k: usize| {
        let at = -delay + k as f64;
        if at.re() <= 0.0 || at.re() >= last as f64 {
            return T::lift(samples[if at.re() <= 0.0 { 0 } else { last }]);
        }
        let i = at.re().floor() as usize;
        let x = at - i as f64;
        let [a, b, c, d] = [i.saturating_sub(1), i, i + 1, (i + 2).min(last)].map(|k| samples[k]);
        let (slope, next) = ((c - a) / 2.0, (d - b) / 2.0);
        let cubic = x * (2.0 * (b - c) + slope + next) + (3.0 * (c - b) - 2.0 * slope - next);
        x * (x * cubic + slope) + b
    };
    (0..samples.len()).map(one).collect()
}

/// Second difference quotient of samples; at the ends, the end is repeated.
pub(crate) fn curvature(samples: &[f64], k: usize, dt: f64) -> f64 {
    let (before, after) = (k.saturating_sub(1), (k + 1).min(samples.len() - 1));
    (samples[after] - 2.0 * samples[k] + samples[before]) / (dt * dt)
}

/// First-order lag; a negative time constant inverts the lag of a reading. Lags shorter than an interval are
/// approximated to second order.
pub(crate) fn lagged<T: Real>(samples: &[T], lag: T, dt: f64) -> Vec<T> {
    if lag.re() <= dt {
        let one = |k: usize| {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(samples.len() - 1));
            let span = (after - before).max(1) as f64 * dt;
            let first = samples[k] - lag * ((samples[after] - samples[before]) / span);
            // The inverse of a lag has no second order.
            let second = (samples[after] - samples[k] * 2.0 + samples[before]) / (dt * dt);
            if lag.re() > 0.0 { first + lag * lag * second } else { first }
        };
        return (0..samples.len()).map(one).collect();
    }
    let share = -(-(lag.recip() * dt)).exp() + 1.0;
    let mut state = samples.first().copied().unwrap_or_else(T::zero);
    let mut before = state;
    let one = |sample: &T| {
        let input = (before + *sample) * 0.5;
        before = *sample;
        state += share * (input - state);
        state
    };
    samples.iter().map(one).collect()
}
