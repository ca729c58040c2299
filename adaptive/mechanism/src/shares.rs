//! Shares by which residuals are divided, so that no parameter makes them small without explaining anything.

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

/// Share of a drive's efforts that is delivered: the slope of a regression. Residuals are divided by it, or a low limit or
/// a wide play would make all efforts small.
pub(crate) fn delivered_share<T: Real>(wanted: &dyn Fn(usize) -> f64, delivered: &[T]) -> T {
    let (mut product, mut square) = (T::zero(), f64::MIN_POSITIVE);
    for (k, effort) in delivered.iter().enumerate() {
        product += *effort * wanted(k);
        square += wanted(k) * wanted(k);
    }
    let share = product / square;
    if (MIN_DELIVERED..1.0).contains(&share.re()) {
        share
    } else {
        T::lift(share.re().clamp(MIN_DELIVERED, 1.0))
    }
}

pub(crate) fn at_least_small<T: Real>(response: T) -> T {
    if response.re() <= MIN_RESPONSE { T::lift(MIN_RESPONSE) } else { response }
}
