//! Scaling of residuals: shares by which they are divided, so that no parameter makes them small without explaining anything.

use trundle_model::Real;

/// Least share of the commands that a drive delivers.
const MIN_DELIVERED: f64 = 1e-6;
/// Least response of the equation to the recorded effort.
const MIN_RESPONSE: f64 = 0.05;

/// Inertia of a joint without drive relative to the given one, in an episode; each is the own inertia of the links at every
/// time, and the armature. No effort fixes the size of its equation: residuals are divided by this share, or small masses
/// would make them all small.
pub(crate) fn inertia_share<T: Real>(
    (own, armature): (&dyn Fn(usize) -> T, T),
    (given, given_armature): (&[f64], f64),
) -> Option<T> {
    let (mut sum, mut reference) = (T::zero(), 0.0);
    for (k, given) in given.iter().enumerate() {
        sum += own(k) + armature;
        reference += given + given_armature;
    }
    (reference > 0.0 && sum.re() > 0.0).then(|| sum / reference)
}

/// Share of the changes of a drive's effort that is delivered: the slope of a regression. Residuals are divided by it, or a
/// low limit or a wide play would make all efforts small.
pub(crate) fn delivered_share<T: Real>(wanted: &dyn Fn(usize) -> T, delivered: &[T]) -> T {
    let mut mean = T::zero();
    (0..delivered.len()).for_each(|k| mean += wanted(k) / delivered.len() as f64);
    let (mut product, mut square) = (T::zero(), T::lift(f64::MIN_POSITIVE));
    for (k, effort) in delivered.iter().enumerate() {
        let change = wanted(k) - mean;
        product += *effort * change;
        square += change * change;
    }
    let share = product / square;
    if (MIN_DELIVERED..1.0).contains(&share.re()) {
        share
    } else {
        T::lift(share.re().clamp(MIN_DELIVERED, 1.0))
    }
}

/// Share of the changes of commands or efforts that a lag or an elastic transmission lets pass: the ratio of their standard
/// deviations. Residuals are divided by it, or a drive that hardly responds to its command would make all efforts small.
pub(crate) fn passed_share<T: Real>(sent: &dyn Fn(usize) -> T, passed: &[T]) -> T {
    let spread = |values: &dyn Fn(usize) -> T| {
        let (mut sum, mut square) = (T::zero(), T::zero());
        for k in 0..passed.len() {
            sum += values(k);
            square += values(k).squared();
        }
        square - sum.squared() / passed.len().max(1) as f64
    };
    let [before, after] = [spread(sent), spread(&|k| passed[k])];
    let share = after.re() / before.re();
    match share {
        MIN_DELIVERED..1.0 => (after / before).sqrt(),
        _ => T::lift(if share < MIN_DELIVERED { MIN_DELIVERED.sqrt() } else { 1.0 }),
    }
}

pub(crate) fn at_least_small<T: Real>(response: T) -> T {
    if response.re() <= MIN_RESPONSE { T::lift(MIN_RESPONSE) } else { response }
}

#[cfg(test)]
mod tests {
    use super::{delivered_share, passed_share};
    use crate::signals::lagged;

    fn commands() -> Vec<f64> {
        (0..400).map(|k| 3.0 + (0.1 * f64::from(k)).sin()).collect()
    }

    #[test]
    fn a_long_lag_passes_little() {
        let share = |lag: f64| passed_share(&|k| commands()[k], &lagged(&commands(), lag, 0.01));
        assert!((share(0.1) - 0.5f64.sqrt()).abs() < 0.05, "{}", share(0.1));
        assert!(share(100.0) < 0.01, "{}", share(100.0));
    }

    #[test]
    fn a_drive_that_always_saturates_delivers_nothing() {
        let share = |limit: f64| {
            let delivered: Vec<f64> = commands().iter().map(|c| c.min(limit)).collect();
            delivered_share(&|k| commands()[k], &delivered)
        };
        assert!(share(5.0) > 0.999 && share(1.0) < 1e-3, "{} {}", share(5.0), share(1.0));
    }
}
