//! Intensity of the white jerk that drives an axis, estimated by maximum likelihood with a grid and a golden-section
//! search.

use super::kalman::Axis;

/// Search range of the decimal logarithm of the intensity, (m or rad)² s⁻⁵. It spans drifts of millimetres in minutes to
/// impacts.
const LOG10_INTENSITY_RANGE: [f64; 2] = [-12.0, 10.0];
/// Step of the grid, decades. The likelihood has one broad peak, a few decades wide.
const GRID_STEP_DECADES: f64 = 2.0;
/// Inverse of the golden ratio.
const INVERSE_GOLDEN_RATIO: f64 = 0.618_033_988_749_894_8;
/// Width of the bracket at which the search ends, decades. A change of the intensity by 5 % hardly changes an estimate.
const TOLERANCE_DECADES: f64 = 0.02;

/// Maximum-likelihood intensity of `axis`.
pub(crate) fn maximum_likelihood(axis: &Axis) -> f64 {
    maximize(|jerk| axis.log_likelihood(jerk))
}

/// Intensity that maximises `log_likelihood`.
pub(crate) fn maximize(log_likelihood: impl Fn(f64) -> f64) -> f64 {
    let value = |exponent: f64| log_likelihood(10f64.powf(exponent));
    let best =
        grid().map(|e| (e, value(e))).fold((LOG10_INTENSITY_RANGE[0], f64::NEG_INFINITY), |best, next| {
            if next.1 > best.1 { next } else { best }
        });
    10f64.powf(golden_maximum(best.0 - GRID_STEP_DECADES, best.0 + GRID_STEP_DECADES, value))
}

/// Decimal logarithms of the intensities on the grid.
pub(crate) fn grid() -> impl Iterator<Item = f64> {
    let steps = ((LOG10_INTENSITY_RANGE[1] - LOG10_INTENSITY_RANGE[0]) / GRID_STEP_DECADES).round() as usize;
    (0..=steps).map(|i| LOG10_INTENSITY_RANGE[0] + GRID_STEP_DECADES * i as f64)
}

fn golden_maximum(mut low: f64, mut high: f64, value: impl Fn(f64) -> f64) -> f64 {
    let (mut a, mut b) =
        (high - INVERSE_GOLDEN_RATIO * (high - low), low + INVERSE_GOLDEN_RATIO * (high - low));
    let (mut at_a, mut at_b) = (value(a), value(b));
    while high - low > TOLERANCE_DECADES {
        if at_a > at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - INVERSE_GOLDEN_RATIO * (high - low);
            at_a = value(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + INVERSE_GOLDEN_RATIO * (high - low);
            at_b = value(b);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::golden_maximum;

    #[test]
    fn golden_section_finds_the_maximum_of_a_parabola() {
        let top = golden_maximum(-2.0, 3.0, |x| -(x - 0.7) * (x - 0.7));
        assert!((top - 0.7).abs() < 0.02);
    }
}
