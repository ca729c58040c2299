//! The intensity of the white jerk that drives an axis: maximum likelihood, by a grid and a golden section.

use super::kalman::Axis;

/// Decimal exponents searched, (m or rad)² s⁻⁵: from a drift of millimetres in minutes to impacts.
pub(crate) const EXPONENTS: [f64; 2] = [-12.0, 10.0];
/// Step of the grid in decades; the likelihood has one broad peak, a few decades wide.
pub(crate) const GRID_STEP: f64 = 2.0;
const GOLDEN: f64 = 0.618_033_988_749_894_8;
/// Width in decades at which the search ends: 5 % of the intensity moves no estimate noticeably.
const TOLERANCE: f64 = 0.02;

/// The likeliest intensity of `axis`.
pub(crate) fn likeliest(axis: &Axis) -> f64 {
    likeliest_by(|jerk| axis.log_likelihood(jerk))
}

/// The intensity that `log_likelihood` rates highest.
pub(crate) fn likeliest_by(log_likelihood: impl Fn(f64) -> f64) -> f64 {
    let value = |exponent: f64| log_likelihood(10f64.powf(exponent));
    let best = grid()
        .map(|e| (e, value(e)))
        .fold((EXPONENTS[0], f64::NEG_INFINITY), |best, next| if next.1 > best.1 { next } else { best });
    10f64.powf(golden_maximum(best.0 - GRID_STEP, best.0 + GRID_STEP, value))
}

/// The exponents of the grid.
pub(crate) fn grid() -> impl Iterator<Item = f64> {
    let steps = ((EXPONENTS[1] - EXPONENTS[0]) / GRID_STEP).round() as usize;
    (0..=steps).map(|i| EXPONENTS[0] + GRID_STEP * i as f64)
}

fn golden_maximum(mut low: f64, mut high: f64, value: impl Fn(f64) -> f64) -> f64 {
    let (mut a, mut b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut at_a, mut at_b) = (value(a), value(b));
    while high - low > TOLERANCE {
        if at_a > at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - GOLDEN * (high - low);
            at_a = value(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + GOLDEN * (high - low);
            at_b = value(b);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::golden_maximum;

    #[test]
    fn golden_section_finds_the_top_of_a_parabola() {
        let top = golden_maximum(-2.0, 3.0, |x| -(x - 0.7) * (x - 0.7));
        assert!((top - 0.7).abs() < 0.02);
    }
}
