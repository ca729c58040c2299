//! Gaussian filters on uniform grids.

/// Half-length of the kernels in standard deviations.
const KERNEL_SDS: f64 = 4.0;

/// Value, first and second derivative (per sample) of `values`, all filtered with a Gaussian of standard deviation `width`
/// samples. At the ends, where the kernel is cut, the local quadratic fit with Gaussian weights replaces it.
pub(crate) fn derivatives(values: &[f64], width: f64) -> [Vec<f64>; 3] {
    let reach = (KERNEL_SDS * width).ceil() as usize;
    let mut found = [const { Vec::new() }; 3];
    let inner = Kernel::new(width, reach, reach);
    for i in 0..values.len() {
        let (before, after) = (reach.min(i), reach.min(values.len() - 1 - i));
        let window = &values[i - before..=i + after];
        let local = match before == reach && after == reach {
            true => inner.apply(window),
            false => Kernel::new(width, before, after).apply(window),
        };
        for (all, value) in found.iter_mut().zip(local) {
            all.push(value);
        }
    }
    found
}

/// `values` filtered with a Gaussian of standard deviation `width` samples.
pub(crate) fn smooth(values: &[f64], width: f64) -> Vec<f64> {
    let [smooth, ..] = derivatives(values, width);
    smooth
}

/// Standard deviation of the second derivative (per sample squared) for white noise of standard deviation 1.
pub(crate) fn acceleration_noise(width: f64) -> f64 {
    let reach = (KERNEL_SDS * width).ceil() as usize;
    let kernel = Kernel::new(width, reach, reach);
    kernel.weights.iter().map(|weights| weights[2] * weights[2]).sum::<f64>().sqrt()
}

/// Weights of the value and of both derivatives in a window.
struct Kernel {
    weights: Vec<[f64; 3]>,
}

impl Kernel {
    fn new(width: f64, before: usize, after: usize) -> Self {
        let offsets: Vec<f64> = (0..=before + after).map(|k| k as f64 - before as f64).collect();
        let gauss = |x: f64| (-0.5 * (x / width).powi(2)).exp();
        let mut moments = [0.0; 5];
        for &x in &offsets {
            for (power, moment) in moments.iter_mut().enumerate() {
                *moment += gauss(x) * (x / width).powi(power as i32);
            }
        }
        let [m0, m1, m2, m3, m4] = moments;
        let matrix = nalgebra::Matrix3::new(m0, m1, m2, m1, m2, m3, m2, m3, m4);
        // Fewer than three samples determine no second derivative.
        let inverse = match offsets.len() < 3 {
            true => nalgebra::Matrix3::new(1.0 / m0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            false => matrix.try_inverse().unwrap_or_else(nalgebra::Matrix3::zeros),
        };
        let weight = |&x: &f64| {
            let s = x / width;
            let fit = inverse * nalgebra::Vector3::new(1.0, s, s * s) * gauss(x);
            // The value of the fit has a sharper filter than its derivatives; a second derivative more equals them.
            [fit[0] + fit[2], fit[1] / width, 2.0 * fit[2] / (width * width)]
        };
        Self { weights: offsets.iter().map(weight).collect() }
    }

    fn apply(&self, window: &[f64]) -> [f64; 3] {
        self.weights
            .iter()
            .zip(window)
            .fold([0.0; 3], |sum, (weights, value)| [0, 1, 2].map(|k| sum[k] + weights[k] * value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_a_parabola_are_exact_up_to_the_ends() {
        // A Gaussian adds its variance, times half the second derivative.
        let blur = 0.5 * 3.0 * 3.0;
        let values: Vec<f64> =
            (0..40).map(|k| 2.0 + 3.0 * f64::from(k) + 0.5 * f64::from(k).powi(2)).collect();
        let [value, first, second] = derivatives(&values, 3.0);
        for k in 0..40 {
            let x = k as f64;
            assert!((value[k] - values[k] - blur).abs() < 1e-8, "{k}");
            assert!((first[k] - (3.0 + x)).abs() < 1e-8, "{k}");
            assert!((second[k] - 1.0).abs() < 1e-8, "{k}");
        }
        assert_eq!(smooth(&[1.0, 1.0], 3.0).len(), 2);
    }
}
