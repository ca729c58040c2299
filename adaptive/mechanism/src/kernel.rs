//! Gaussian low-pass filters of uniform samples, with their derivatives.

use trundle_model::Real;

/// Half width of a kernel, standard deviations. The omitted weight is below 10⁻⁴.
const HALF_WIDTH: f64 = 4.0;

/// Weights of a Gaussian filter: of the value and of the first two derivatives.
#[derive(Clone, Debug)]
pub(crate) struct Kernel {
    /// Weights of the value by offset from `-half` to `half`.
    pub value: Vec<f64>,
    slope: Vec<f64>,
    curvature: Vec<f64>,
    /// Largest offset, samples.
    pub half: usize,
}

impl Kernel {
    /// Kernel with a standard deviation of `sd` seconds for samples every `dt` seconds. Polynomials of second degree
    /// keep their derivatives exactly.
    pub fn new(sd: f64, dt: f64) -> Self {
        let half = ((HALF_WIDTH * sd / dt).ceil() as usize).max(2);
        let offsets: Vec<f64> = (0..=2 * half).map(|k| (k as f64 - half as f64) * dt).collect();
        let bell: Vec<f64> = offsets.iter().map(|x| (-0.5 * (x / sd).powi(2)).exp()).collect();
        let total: f64 = bell.iter().sum();
        let value: Vec<f64> = bell.iter().map(|w| w / total).collect();
        let second: f64 = value.iter().zip(&offsets).map(|(w, x)| w * x * x).sum();
        let slope = value.iter().zip(&offsets).map(|(w, x)| w * x / second).collect();
        let centred: Vec<f64> = value.iter().zip(&offsets).map(|(w, x)| w * (x * x - second)).collect();
        let scale: f64 = centred.iter().zip(&offsets).map(|(w, x)| w * x * x / 2.0).sum();
        let curvature = centred.iter().map(|w| w / scale).collect();
        Self { value, slope, curvature, half }
    }

    /// The filter that changes nothing.
    pub fn identity() -> Self {
        Self { value: vec![1.0], slope: vec![0.0], curvature: vec![0.0], half: 0 }
    }

    /// The same filter applied twice to what it removes (twicing; Tukey 1977): slow signals keep their amplitude to
    /// fourth order in frequency, which laws that are not linear need.
    pub fn flat(sd: f64, dt: f64) -> Self {
        let once = Self::new(sd, dt);
        let twiced = |weights: &[f64]| -> Vec<f64> {
            let half = once.half;
            let mut found = vec![0.0; 4 * half + 1];
            for (i, a) in weights.iter().enumerate() {
                found[i + half] += 2.0 * a;
                for (k, b) in once.value.iter().enumerate() {
                    found[i + k] -= a * b;
                }
            }
            found
        };
        let (value, slope, curvature) = (twiced(&once.value), twiced(&once.slope), twiced(&once.curvature));
        Self { value, slope, curvature, half: 2 * once.half }
    }

    /// Weighted mean around sample `at`, which is at least `half` samples from either end.
    pub fn at<T: Real>(&self, samples: &[T], at: usize) -> T {
        dot(&self.value, &samples[at - self.half..=at + self.half])
    }

    /// Value, first and second derivative around sample `at`.
    pub fn derivatives(&self, samples: &[f64], at: usize) -> [f64; 3] {
        let window = &samples[at - self.half..=at + self.half];
        [&self.value, &self.slope, &self.curvature].map(|weights| dot(weights, window))
    }

    /// Standard deviations of the three results for white noise of unit standard deviation.
    pub fn noise(&self) -> [f64; 3] {
        [&self.value, &self.slope, &self.curvature]
            .map(|weights| weights.iter().map(|w| w * w).sum::<f64>().sqrt())
    }

    /// All samples, filtered. Beyond the ends the first and the last sample continue.
    pub fn filtered<T: Real>(&self, samples: &[T]) -> Vec<T> {
        let last = samples.len().saturating_sub(1);
        (0..samples.len())
            .map(|i| {
                if i >= self.half && i + self.half <= last {
                    return self.at(samples, i);
                }
                let mut sum = T::zero();
                for (k, weight) in self.value.iter().enumerate() {
                    sum += samples[(i + k).saturating_sub(self.half).min(last)] * *weight;
                }
                sum
            })
            .collect()
    }
}

fn dot<T: Real>(weights: &[f64], values: &[T]) -> T {
    let mut sum = T::zero();
    for (weight, value) in weights.iter().zip(values) {
        sum += *value * *weight;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::Kernel;

    #[test]
    fn parabolas_keep_their_derivatives() {
        let kernel = Kernel::new(0.02, 0.005);
        let samples: Vec<f64> = (0..81).map(|k| 3.0 + 2.0 * t(k) - 5.0 * t(k) * t(k)).collect();
        let [_, slope, curvature] = kernel.derivatives(&samples, 40);
        assert!((slope - (2.0 - 10.0 * t(40))).abs() < 1e-9, "{slope}");
        assert!((curvature + 10.0).abs() < 1e-7, "{curvature}");
    }

    #[test]
    fn the_flat_kernel_keeps_slow_sines() {
        let samples: Vec<f64> = (0..201).map(|k| (12.0 * t(k)).sin()).collect();
        let error = |kernel: &Kernel| (kernel.derivatives(&samples, 100)[0] - samples[100]).abs();
        let (plain, flat) = (Kernel::new(0.02, 0.005), Kernel::flat(0.02, 0.005));
        assert!(error(&flat) < 0.05 * error(&plain));
        let slope = flat.derivatives(&samples, 100)[1];
        assert!((slope / (12.0 * (12.0 * t(100)).cos()) - 1.0).abs() < 2e-3, "{slope}");
    }

    fn t(k: usize) -> f64 {
        k as f64 * 0.005
    }

    #[test]
    fn a_constant_is_kept_up_to_the_ends() {
        let kernel = Kernel::new(0.02, 0.005);
        assert!(kernel.filtered(&[1.5; 50]).iter().all(|x| (x - 1.5).abs() < 1e-12));
    }
}
