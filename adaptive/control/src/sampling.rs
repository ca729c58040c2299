//! Sampling of plans around a mean, and their weighted average.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::Settings;

/// Fill `plan` with actions around `mean`, within the bounds. The deviations are a stationary first-order autoregressive
/// process. Each `number` of each `round` has its own random stream, so the result does not depend on the threads.
pub(crate) fn draw_plan(
    settings: &Settings,
    scale: f64,
    mean: &[[f64; 3]],
    seed: u64,
    (round, number): (u32, u32),
    plan: &mut [[f64; 3]],
) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::from(round) << 32 | u64::from(number));
    let sd = settings.half_range().map(|half| half * settings.spread * scale);
    let keep = settings.smoothness;
    let renew = (1.0 - keep * keep).sqrt();
    let mut normal = || -> [f64; 3] { std::array::from_fn(|_| rng.sample(StandardNormal)) };
    let mut deviation = normal();
    for (action, mean) in plan.iter_mut().zip(mean) {
        *action = settings.clamp([0, 1, 2].map(|k| mean[k] + sd[k] * deviation[k]));
        let fresh = normal();
        deviation = [0, 1, 2].map(|k| keep * deviation[k] + renew * fresh[k]);
    }
}

/// Fraction of the plans whose costs determine the temperature.
const LOW_COST_FRACTION: f64 = 0.2;
/// Distance, in standard deviations, between the minimum of some hundred normal costs and their quantile
/// [`LOW_COST_FRACTION`].
const LOW_COST_RANGE_SDS: f64 = 2.0;

/// Average of `plans`, each of `mean.len()` actions, with the weights `exp(−(cost − min cost)/λ)`.
///
/// λ is `temperature` times the standard deviation of the costs. The standard deviation is estimated from the lowest costs,
/// because the high costs of collisions would dominate it. Plans of infinite cost have no weight.
pub(crate) fn weighted_average(plans: &[[f64; 3]], costs: &[f64], temperature: f64, mean: &mut [[f64; 3]]) {
    let mut ordered: Vec<f64> = costs.iter().copied().filter(|cost| cost.is_finite()).collect();
    ordered.sort_unstable_by(f64::total_cmp);
    let cutoff =
        ((ordered.len() as f64 * LOW_COST_FRACTION).ceil() as usize).min(ordered.len().saturating_sub(1));
    let min_cost = ordered.first().copied().unwrap_or(0.0);
    let spread = ordered.get(cutoff).map_or(0.0, |cost| (cost - min_cost) / LOW_COST_RANGE_SDS);
    let lambda = (temperature * spread).max(f64::MIN_POSITIVE);
    let horizon = mean.len();
    mean.fill([0.0; 3]);
    let mut total = 0.0;
    for (plan, cost) in plans.chunks_exact(horizon).zip(costs).filter(|(_, cost)| cost.is_finite()) {
        let weight = (-(cost - min_cost) / lambda).exp();
        total += weight;
        for (sum, action) in mean.iter_mut().zip(plan) {
            *sum = [0, 1, 2].map(|k| sum[k] + weight * action[k]);
        }
    }
    for sum in mean {
        *sum = sum.map(|s| s / total);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> Settings {
        Settings::within([-10.0, -10.0, -1.0], [10.0, 10.0, 1.0])
    }

    #[test]
    fn plans_stay_within_the_bounds_and_differ_by_number_and_round() {
        let mean = vec![[9.0, 0.0, 0.0]; 20];
        let plan = |at| {
            let mut plan = vec![[0.0; 3]; 20];
            draw_plan(&settings(), 1.0, &mean, 1, at, &mut plan);
            plan
        };
        assert!(plan((0, 1)).iter().all(|a| a[0].abs() <= 10.0 && a[1].abs() <= 10.0 && a[2].abs() <= 1.0));
        assert_eq!(plan((0, 1)), plan((0, 1)));
        assert_ne!(plan((0, 1)), plan((0, 2)));
        assert_ne!(plan((0, 1)), plan((1, 1)));
    }

    #[test]
    fn deviations_have_the_specified_spread_and_correlation() {
        let settings = settings();
        let mut plan = vec![[0.0; 3]; 200_000];
        let mean = vec![[0.0; 3]; 200_000];
        // The spread is small, so the bounds have no effect.
        draw_plan(&settings, 0.2, &mean, 1, (0, 1), &mut plan);
        let n = plan.len() as f64;
        let variance = plan.iter().map(|a| a[0] * a[0]).sum::<f64>() / n;
        let covariance = plan.windows(2).map(|p| p[0][0] * p[1][0]).sum::<f64>() / n;
        assert!((variance.sqrt() - 0.2 * settings.spread * 10.0).abs() < 0.02, "{}", variance.sqrt());
        assert!((covariance / variance - settings.smoothness).abs() < 0.01, "{}", covariance / variance);
    }

    #[test]
    fn the_average_favours_low_costs_and_ignores_infinite_ones() {
        let plans = [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [9.0, 0.0, 0.0]];
        let mut mean = [[0.0; 3]];
        weighted_average(&plans, &[1.0, 1.0, f64::INFINITY], 1.0, &mut mean);
        assert_eq!(mean, [[2.0, 0.0, 0.0]]);
        weighted_average(&plans, &[1.0, 2.0, f64::INFINITY], 0.01, &mut mean);
        assert!((mean[0][0] - 1.0).abs() < 1e-9);
    }
}
