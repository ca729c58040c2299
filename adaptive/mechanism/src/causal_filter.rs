//! Causal estimates of states, from earlier positions alone: a Kalman filter of a motion whose jerk is white noise.
//!
//! The spectral density of the jerk relative to the noise of the positions has the maximum likelihood on the training
//! episodes. The span of the filter thus follows noise and bandwidth: positions without noise are differentiated over few
//! samples, quantised ones over many.

use nalgebra::{Matrix3, Vector3};

/// Decimal logarithms of the jerk's density that are compared, in units of the noise's variance per interval to the fifth power.
const LOG_DENSITIES: std::ops::RangeInclusive<i32> = -14..=6;
/// Most samples of an episode that decide about the density.
const MAX_SAMPLES: usize = 4000;
/// Variance of the first velocity and acceleration, in units of the noise's: unknown.
const UNKNOWN: f64 = 1e10;
/// First samples whose innovations are not compared: they set the state.
const FIRST: usize = 4;

/// A filter of positions at an interval. The state is the position, the velocity times the interval, and the acceleration
/// times its square.
struct Filter {
    step: Matrix3<f64>,
    jerk: Matrix3<f64>,
    state: Vector3<f64>,
    covariance: Matrix3<f64>,
}

impl Filter {
    fn new(first: f64, density: f64) -> Self {
        Self {
            step: Matrix3::new(1.0, 1.0, 0.5, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0),
            jerk: density
                * Matrix3::new(1.0 / 20.0, 0.125, 1.0 / 6.0, 0.125, 1.0 / 3.0, 0.5, 1.0 / 6.0, 0.5, 1.0),
            state: Vector3::new(first, 0.0, 0.0),
            covariance: Matrix3::from_diagonal(&Vector3::new(1.0, UNKNOWN, UNKNOWN)),
        }
    }

    /// Takes the next position; returns the innovation and its variance.
    fn update(&mut self, position: f64) -> [f64; 2] {
        self.state = self.step * self.state;
        let ahead = self.step * self.covariance * self.step.transpose() + self.jerk;
        let variance = ahead[(0, 0)] + 1.0;
        let gain = ahead.column(0) / variance;
        let innovation = position - self.state[0];
        self.state += gain * innovation;
        let rest = ahead - gain * ahead.row(0);
        self.covariance = 0.5 * (rest + rest.transpose());
        [innovation, variance]
    }
}

/// Density of the jerk that makes uniformly sampled positions of the episodes most probable, in the units of the filter.
pub(crate) fn jerk_density(episodes: &[&[f64]]) -> f64 {
    let cost = |density: f64| {
        let (mut squares, mut logs, mut count) = (0.0, 0.0, 0.0);
        for positions in episodes.iter().filter(|positions| positions.len() > FIRST) {
            let mut filter = Filter::new(positions[0], density);
            for (k, position) in positions.iter().enumerate().take(MAX_SAMPLES).skip(1) {
                let [innovation, variance] = filter.update(*position);
                if k >= FIRST {
                    squares += innovation * innovation / variance;
                    logs += variance.ln();
                    count += 1.0;
                }
            }
        }
        // The variance of the noise is the one of largest likelihood.
        count * f64::max(squares / f64::max(count, 1.0), f64::MIN_POSITIVE).ln() + logs
    };
    let densities = LOG_DENSITIES.map(|log| 10f64.powi(log));
    let costs = densities.map(|density| (density, cost(density)));
    costs.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(1.0, |(density, _)| density)
}

/// Position and velocity at each sample from the positions up to it; `dt` is the interval, s.
pub(crate) fn causal_states(positions: &[f64], dt: f64, density: f64) -> Vec<[f64; 2]> {
    let Some(first) = positions.first() else { return vec![] };
    let mut filter = Filter::new(*first, density);
    let mut found = vec![[*first, 0.0]];
    for position in &positions[1..] {
        filter.update(*position);
        found.push([filter.state[0], filter.state[1] / dt]);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{causal_states, jerk_density};

    /// A position that follows steps of a target every half second within some 30 ms.
    fn stepped(dt: f64, noise: impl Fn(usize, f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let (w, mut q, mut v) = (40.0, 0.0, 0.0);
        let (mut positions, mut velocities) = (vec![], vec![]);
        for k in 0..(5.0 / dt) as usize {
            let target = if ((k as f64 * dt / 0.5) as usize).is_multiple_of(2) { 0.3 } else { -0.3 };
            v += dt * (w * w * (target - q) - 2.0 * w * v);
            q += dt * v;
            positions.push(noise(k, q));
            velocities.push(v);
        }
        (positions, velocities)
    }

    fn error(positions: &[f64], velocities: &[f64], dt: f64) -> f64 {
        let states = causal_states(positions, dt, jerk_density(&[positions]));
        let square = |k: usize| (states[k][1] - velocities[k]).powi(2);
        let rows = 50..positions.len();
        (rows.clone().map(square).sum::<f64>() / rows.len() as f64).sqrt()
    }

    #[test]
    fn the_span_follows_the_noise() {
        let dt = 0.002;
        let (positions, velocities) = stepped(dt, |_, q| q);
        let clean = error(&positions, &velocities, dt);
        let (quantised, _) = stepped(dt, |_, q| (q / 1.5e-3).round() * 1.5e-3);
        let coarse = error(&quantised, &velocities, dt);
        // Velocities reach 4.4 rad/s; differences of neighbours would have an error of 0.3 rad/s with the steps.
        assert!(clean < 0.15, "{clean}");
        assert!(coarse < 0.25, "{coarse}");
    }
}
