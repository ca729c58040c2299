//! Delays and first-order lags between a wrench and its reading.
//!
//! Over an interval from `a` to `b`, with the reading `r`,
//!
//! ```text
//! sensor lag, τ ṙ + r = w:   mean(w) = mean(r) + τ (r(b) − r(a))/(b − a)
//! drive lag,  τ ẇ + w = r:   mean(w) = mean(r) − τ (w(b) − w(a))/(b − a)
//! ```
//! Noisy samples are not differentiated: the differences of successive intervals cancel.

use crate::curve::Curve;
use trundle_model::{Clock, Lags, Plant, Real};

/// Delay and lags of the readings at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Timing<T> {
    delay: T,
    lags: Lags<T>,
}

impl<T: Real> Timing<T> {
    /// Timing of a plant at a time; `None` if the readings have neither delay nor lag.
    #[inline]
    pub fn of(plant: &Plant<T>, clock: Clock) -> Option<Self> {
        let (delay, lags) = (plant.delay(clock), plant.lags());
        let none = Lags { sensor: T::zero(), drive: T::zero() };
        (delay.is_some() || lags.is_some())
            .then(|| Self { delay: delay.unwrap_or_else(T::zero), lags: lags.unwrap_or(none) })
    }

    /// Delay of the readings, s.
    pub fn delay(&self) -> f64 {
        self.delay.re()
    }

    /// Mean wrench over an interval, reading axes.
    pub fn mean(&self, curve: &Curve, from: f64, to: f64) -> [T; 3] {
        let (length, late) = (to - from, self.delay);
        let mut mean = curve.delayed_mean(from, to, late);
        let ends = [from, to].map(|t| t + late.re());
        if !is_zero(self.lags.sensor) {
            let [start, stop] = ends.map(|t| curve.value(t));
            for (k, mean) in mean.iter_mut().enumerate() {
                let (rise, bend) = (stop.0[k] - start.0[k], stop.1[k] - start.1[k]);
                let rise = T::chained(rise, [(late, bend)]);
                *mean += self.lags.sensor * rise / length;
            }
        }
        if !is_zero(self.lags.drive) {
            let drive = self.lags.drive;
            let [start, stop] = ends.map(|t| curve.lagged(t, drive.re()));
            for (k, mean) in mean.iter_mut().enumerate() {
                let rise = stop.value[k] - start.value[k];
                let by_lag = stop.by_lag[k] - start.by_lag[k];
                let bend = stop.rate[k] - start.rate[k];
                *mean += -(drive * T::chained(rise, [(drive, by_lag), (late, bend)])) / length;
            }
        }
        mean
    }
}

/// Whether a time constant is zero and independent of the parameters.
fn is_zero<T: Real>(lag: T) -> bool {
    lag.re() == 0.0 && lag.is_constant()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_model::Dual;
    use trundle_record::{Prepared, WrenchSample};

    /// A command that starts at 0.2 s and oscillates, sampled at 1 kHz.
    fn command(t: f64) -> f64 {
        if t < 0.2 { 0.0 } else { 10.0 * (1.0 + (9.0 * t).sin()) * ((t - 0.2) / 0.05).min(1.0) }
    }

    fn curve(of: impl Fn(usize) -> f64) -> Curve {
        let sample = |k: usize| WrenchSample {
            t: k as f64 * 1e-3,
            reading: [of(k), 0.0, 0.0],
            frame: [0.0; 3],
            ..Default::default()
        };
        Curve::new(&Prepared {
            name: "push".to_owned(),
            wrench: (0..1500).map(sample).collect(),
            ..Default::default()
        })
    }

    /// The command filtered by a lag, integrated with steps of 10 µs.
    fn followed(lag: f64) -> Vec<f64> {
        let (mut y, mut found) = (0.0, vec![]);
        for k in 0..150_000 {
            if k % 100 == 0 {
                found.push(y);
            }
            y += 1e-5 / lag * (command((k as f64 + 0.5) * 1e-5) - y);
        }
        found
    }

    fn timing<const N: usize>([delay, sensor, drive]: [Dual<N>; 3]) -> Timing<Dual<N>> {
        Timing { delay, lags: Lags { sensor, drive } }
    }

    fn given(values: [f64; 3]) -> Timing<Dual<3>> {
        timing([0, 1, 2].map(|k| Dual::variable(values[k], k)))
    }

    #[test]
    fn a_lag_of_the_drive_matches_a_fine_integration() {
        let (read, lag) = (curve(|k| command(k as f64 * 1e-3)), 0.06);
        let truth = followed(lag);
        for from in [210, 260, 700] {
            let exact =
                truth[from..from + 8].iter().sum::<f64>() / 8.0 + (truth[from + 8] - truth[from]) / 16.0;
            let (a, b) = (from as f64 * 1e-3, (from + 8) as f64 * 1e-3);
            let found = given([0.0, 0.0, lag]).mean(&read, a, b)[0].re;
            assert!((found - exact).abs() < 2e-3, "{found} is not {exact}");
        }
    }

    #[test]
    fn a_lag_of_the_sensor_is_undone() {
        let lag = 0.06;
        let truth = followed(lag);
        let read = curve(|k| truth[k]);
        for from in [210, 260, 700] {
            let (a, b) = (from as f64 * 1e-3, (from + 8) as f64 * 1e-3);
            let exact = (0..80).map(|k| command(a + (k as f64 + 0.5) * 1e-4)).sum::<f64>() / 80.0;
            let found = given([0.0, lag, 0.0]).mean(&read, a, b)[0].re;
            assert!((found - exact).abs() < 2e-3, "{found} is not {exact}");
        }
    }

    #[test]
    fn slopes_agree_with_finite_differences() {
        let read = curve(|k| command(k as f64 * 1e-3));
        // The interval avoids a corner of the curve, where the slope by the delay is discontinuous.
        let (at, a, b) = ([0.0123, 0.04, 0.07], 0.3001, 0.3083);
        let exact = given(at).mean(&read, a, b)[0];
        for k in 0..3 {
            let h = 1e-6;
            let moved = |by: f64| {
                let mut moved = at;
                moved[k] += by;
                given(moved).mean(&read, a, b)[0].re
            };
            let difference = (moved(h) - moved(-h)) / (2.0 * h);
            let slope = exact.eps[k];
            assert!(
                (slope - difference).abs() < 1e-4 * (1.0 + slope.abs()),
                "{k}: {slope} is not {difference}"
            );
        }
    }

    #[test]
    fn without_a_lag_nothing_changes() {
        let read = curve(|k| command(k as f64 * 1e-3));
        let (mean, plain) = (given([0.0; 3]).mean(&read, 0.3, 0.308)[0].re, read.mean(0.3, 0.308).reading[0]);
        assert!((mean - plain).abs() < 1e-12, "{mean} is not {plain}");
    }
}
