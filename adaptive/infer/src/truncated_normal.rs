//! Standard normal distribution and its truncation to an interval, accurate in the tails.

use statrs::function::erf::{erfc, erfc_inv};
use std::f64::consts::{SQRT_2, TAU};

/// Cumulative distribution function.
pub(crate) fn cdf(x: f64) -> f64 {
    0.5 * erfc(-x / SQRT_2)
}

/// Probability density function.
pub(crate) fn pdf(x: f64) -> f64 {
    (-0.5 * x * x).exp() / TAU.sqrt()
}

/// Inverse of the cumulative distribution function.
pub(crate) fn quantile(p: f64) -> f64 {
    let x = -SQRT_2 * erfc_inv(2.0 * p);
    // One Newton step, because the series alone is accurate to 1e-9 only.
    let step = (cdf(x) - p) / pdf(x);
    if step.is_finite() { x - step } else { x }
}

/// Probability of the interval from `a` to `b`.
fn probability(a: f64, b: f64) -> f64 {
    if a > 0.0 { cdf(-a) - cdf(-b) } else { cdf(b) - cdf(a) }
}

/// Standard normal distribution truncated to the interval from `low` to `high`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TruncatedNormal {
    pub low: f64,
    pub high: f64,
}

impl TruncatedNormal {
    /// The point whose cumulative probability in the truncated distribution is that of `z` in the full one,
    /// and its derivative by `z`.
    pub fn value(self, z: f64) -> (f64, f64) {
        let mass = probability(self.low, self.high);
        let (under, over) = (cdf(self.low) + cdf(z) * mass, cdf(-self.high) + cdf(-z) * mass);
        // Computed from the nearer end, because the difference from one loses all digits in the tail.
        let t = if under < over { quantile(under) } else { -quantile(over) };
        let t = t.clamp(self.low, self.high);
        (t, mass * (0.5 * (t * t - z * z)).exp())
    }

    /// Inverse of [`TruncatedNormal::value`].
    pub fn point(self, t: f64) -> f64 {
        let t = t.clamp(self.low, self.high);
        let mass = probability(self.low, self.high);
        let (under, over) = (probability(self.low, t) / mass, probability(t, self.high) / mass);
        if under < over { quantile(under) } else { -quantile(over) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTERVALS: [(f64, f64); 6] =
        [(-1.0, 2.0), (0.5, f64::INFINITY), (f64::NEG_INFINITY, -1.0), (5.5, 6.0), (-6.0, -5.9), (-7.0, 7.0)];

    #[test]
    fn quantiles_invert_probabilities_far_into_the_tails() {
        for k in -75..=75 {
            let x = 0.1 * f64::from(k);
            let found = if x < 0.0 { quantile(cdf(x)) } else { -quantile(cdf(-x)) };
            assert!((found - x).abs() < 1e-12 * (1.0 + x.abs()), "{x} {found}");
        }
    }

    #[test]
    fn points_invert_values_and_slopes_match_differences() {
        for (low, high) in INTERVALS {
            let truncated = TruncatedNormal { low, high };
            for z in [-4.0, -1.5, -0.1, 0.0, 0.7, 3.0] {
                let (t, slope) = truncated.value(z);
                assert!((low..=high).contains(&t));
                assert!((truncated.point(t) - z).abs() < 1e-6, "{low} {high} {z}: {}", truncated.point(t));
                let numeric = (truncated.value(z + 1e-4).0 - truncated.value(z - 1e-4).0) / 2e-4;
                assert!((numeric - slope).abs() < 1e-5 * slope, "{low} {high} {z}: {numeric} {slope}");
            }
        }
    }

    /// ∫φ(t)/W dt from `low` to `value(z)` by Simpson's rule is Φ(z).
    #[test]
    fn the_density_is_the_truncated_normal() {
        for (low, high) in INTERVALS {
            let truncated = TruncatedNormal { low, high };
            let from = low.max(-9.0);
            let area = |to: f64| {
                let n = 4000;
                let h = (to - from) / f64::from(n);
                let weight = |k: i32| if k == 0 || k == n { 1.0 } else { 2.0 + 2.0 * f64::from(k % 2) };
                (0..=n).map(|k| weight(k) * pdf(from + f64::from(k) * h) * h / 3.0).sum::<f64>()
            };
            let mass = area(high.min(9.0));
            for z in [-1.0, 0.0, 1.0] {
                let share = area(truncated.value(z).0) / mass;
                assert!((share - cdf(z)).abs() < 1e-6, "{low} {high} {z}: {share}");
            }
        }
    }
}
