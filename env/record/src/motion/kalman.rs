//! Kalman filter and smoother of one axis with the state (pose, velocity, acceleration).
//!
//! The smoother is the modified Bryson–Frazier form (Bierman 1973, "Fixed interval smoothing with discrete
//! measurements"). It is equivalent to the Rauch–Tung–Striebel smoother but inverts no covariance; the covariance of an
//! object at rest is singular.

use super::symmetric::Symmetric;

/// Lower bound of the pose noise, m or rad. It keeps noiseless simulations solvable.
const MIN_POSE_SD: f64 = 1e-8;

/// Mean and covariance of (pose, velocity, acceleration).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Estimate {
    pub mean: [f64; 3],
    pub cov: Symmetric,
}

/// The samples of one axis.
pub(crate) struct Axis<'a> {
    pub t: &'a [f64],
    pub z: &'a [f64],
    pub variance: f64,
    /// Variance of each sample in addition to `variance`; empty if there is none.
    extra: Vec<f64>,
    start: Estimate,
    /// Time before each sample in which the object may have moved.
    intervals: Vec<Interval>,
}

/// Measurement update of the filter with one sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Update {
    /// Estimate before the update.
    pub predicted: Estimate,
    /// Innovation: sample minus prediction.
    pub innovation: f64,
    /// Variance of the innovation.
    pub innovation_variance: f64,
    /// Variance of the measurement noise.
    noise: f64,
}

impl Update {
    #[inline]
    pub fn gain(&self) -> [f64; 3] {
        let inverse = self.innovation_variance.recip();
        self.predicted.cov.first_column().map(|c| c * inverse)
    }

    /// Estimate after the update.
    ///
    /// With the gain `k`, Joseph's form of the covariance reduces to `P − k (H P)`. Its first row is `r k` with the noise
    /// variance `r`, a product of positive numbers.
    #[inline]
    pub fn posterior(&self) -> Estimate {
        let Estimate { mean: [p, v, a], cov: Symmetric { pv, pa, vv, va, aa, .. } } = self.predicted;
        let [along_p, along_v, along_a] = self.gain();
        let (e, r) = (self.innovation, self.noise);
        Estimate {
            mean: [p + along_p * e, v + along_v * e, a + along_a * e],
            cov: Symmetric {
                pp: r * along_p,
                pv: r * along_v,
                pa: r * along_a,
                vv: (vv - along_v * pv).max(0.0),
                va: va - along_v * pa,
                aa: (aa - along_a * pa).max(0.0),
            },
        }
    }

    /// Square of the innovation, in variances of the innovation.
    #[inline]
    pub fn normalized_square(&self) -> f64 {
        self.innovation * self.innovation / self.innovation_variance
    }

    pub fn log_likelihood(&self) -> f64 {
        -0.5 * (self.normalized_square() + self.innovation_variance.ln())
    }
}

/// Sum of logarithms, mostly evaluated as the logarithm of a product.
pub(crate) struct LogSum {
    sum: f64,
    product: f64,
}

impl LogSum {
    pub fn new() -> Self {
        Self { sum: 0.0, product: 1.0 }
    }

    #[inline]
    pub fn add(&mut self, factor: f64) {
        let product = self.product * factor;
        // Bounds that are far from overflow and underflow.
        if (1e-140..1e140).contains(&product) {
            self.product = product;
        } else {
            self.sum += self.product.ln() + factor.ln();
            self.product = 1.0;
        }
    }

    pub fn value(&self) -> f64 {
        self.sum + self.product.ln()
    }
}

/// Interval of free motion, and the covariance that white jerk of unit intensity adds in it.
#[derive(Debug, Clone, Copy)]
struct Interval {
    dt: f64,
    noise: Symmetric,
}

impl Interval {
    fn new(dt: f64) -> Self {
        let (d2, d3) = (dt * dt, dt * dt * dt);
        let (d4, d5) = (d2 * d2, d2 * d3);
        let noise =
            Symmetric { pp: d5 / 20.0, pv: d4 / 8.0, pa: d3 / 6.0, vv: d3 / 3.0, va: d2 / 2.0, aa: dt };
        Self { dt, noise }
    }
}

impl<'a> Axis<'a> {
    /// Creates the axis from poses `z` at times `t`, s, with standard deviation `sd`. If given, the object is at rest until
    /// `rest_until`, s.
    pub fn new(t: &'a [f64], z: &'a [f64], sd: f64, rest_until: Option<f64>) -> Self {
        let variance = sd.max(MIN_POSE_SD).powi(2);
        let resting = rest_until.is_some_and(|until| t.first().is_some_and(|&first| until >= first));
        let mean = [z.first().copied().unwrap_or(0.0), 0.0, 0.0];
        let cov = if resting { Symmetric::default() } else { diffuse_prior(t, z, variance) };
        let start = Estimate { mean, cov: Symmetric { pp: 1e4 * variance, ..cov } };
        let rest_until = rest_until.unwrap_or(f64::NEG_INFINITY);
        let before = t.iter().zip(t.iter().skip(1));
        let between = before.map(|(&from, &to)| Interval::new((to - from.max(rest_until)).max(0.0)));
        let intervals = std::iter::once(Interval::new(0.0)).chain(between).collect();
        Self { t, z, variance, extra: vec![], start, intervals }
    }

    /// The same axis with an additional variance of each sample.
    pub fn with_extra(self, extra: Vec<f64>) -> Self {
        Self { extra, ..self }
    }

    /// Predicts the state at sample `i` from `before`, the state at sample `i - 1`, under white jerk of intensity `jerk`
    /// (unit² s⁻⁵).
    #[inline]
    pub fn predict(&self, i: usize, before: &Estimate, jerk: f64) -> Estimate {
        let Interval { dt, noise } = &self.intervals[i];
        let [p, v, a] = before.mean;
        let half = 0.5 * dt * dt;
        Estimate {
            mean: [p + dt * v + half * a, v + dt * a, a],
            cov: before.cov.propagated(*dt).add_scaled(noise, jerk),
        }
    }

    /// Measurement update with sample `i`.
    #[inline]
    pub fn update(&self, i: usize, predicted: Estimate) -> Update {
        let innovation = self.z[i] - predicted.mean[0];
        let noise = self.variance + self.extra.get(i).copied().unwrap_or(0.0);
        Update { predicted, innovation, innovation_variance: predicted.cov.pp + noise, noise }
    }

    pub fn start(&self) -> Estimate {
        self.start
    }

    /// All updates in chronological order.
    fn forward(&self, jerk: f64) -> impl Iterator<Item = Update> + '_ {
        let mut last: Option<Estimate> = None;
        (0..self.t.len()).map(move |i| {
            let predicted = last.map_or(self.start, |last| self.predict(i, &last, jerk));
            let update = self.update(i, predicted);
            last = Some(update.posterior());
            update
        })
    }

    /// Log-likelihood of the samples, up to a constant.
    pub fn log_likelihood(&self, jerk: f64) -> f64 {
        let (mut squares, mut log_variances) = (0.0, LogSum::new());
        for update in self.forward(jerk) {
            squares += update.normalized_square();
            log_variances.add(update.innovation_variance);
        }
        -0.5 * (squares + log_variances.value())
    }

    /// Smoothed state at each sample, given all samples.
    pub fn smooth(&self, jerk: f64) -> Vec<Estimate> {
        let updates: Vec<Update> = self.forward(jerk).collect();
        let (mut adjoint, mut information) = ([0.0; 3], Symmetric::default());
        let mut smoothed = Vec::with_capacity(updates.len());
        for (update, interval) in updates.iter().zip(&self.intervals).rev() {
            let gain = update.gain();
            adjoint[0] -= dot(gain, adjoint) + update.innovation / update.innovation_variance;
            information = information.measured(gain, update.innovation_variance.recip());
            smoothed.push(corrected(&update.predicted, adjoint, information));
            let [p, v, a] = adjoint;
            let dt = interval.dt;
            adjoint = [p, dt * p + v, 0.5 * dt * dt * p + dt * v + a];
            information = information.propagated_back(dt);
        }
        smoothed.reverse();
        smoothed
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The smoothed estimate from a prediction and the adjoint variables of the later samples.
fn corrected(predicted: &Estimate, adjoint: [f64; 3], information: Symmetric) -> Estimate {
    let mut cov = predicted.cov.add_scaled(&predicted.cov.sandwich(information), -1.0);
    for variance in [&mut cov.pp, &mut cov.vv, &mut cov.aa] {
        *variance = variance.max(0.0); // rounding errors while the object rests
    }
    let shift = predicted.cov.times(adjoint);
    Estimate { mean: [0, 1, 2].map(|k| predicted.mean[k] - shift[k]), cov }
}

/// Diffuse prior covariance of velocity and acceleration: ten times the fastest motion that the first samples allow.
fn diffuse_prior(t: &[f64], z: &[f64], variance: f64) -> Symmetric {
    let early = t.iter().zip(z).skip(1).take(10);
    let (mut speed, mut first) = (0.0_f64, f64::INFINITY);
    for (&ti, &zi) in early {
        let elapsed = ti - t[0];
        first = first.min(elapsed);
        speed = speed.max(((zi - z[0]).abs() + variance.sqrt()) / elapsed);
    }
    if !first.is_finite() {
        return Symmetric::default();
    }
    let (speed, accel) = (10.0 * speed, 10.0 * speed / first);
    Symmetric { vv: speed * speed, aa: accel * accel, ..Symmetric::default() }
}

#[cfg(test)]
mod tests {
    use super::LogSum;

    #[test]
    fn log_sum_equals_the_sum_of_logarithms() {
        let factors = [1e-16, 3.0, 1e-120, 1e150, 7.0, 1e-300, 2.0];
        let mut sum = LogSum::new();
        factors.iter().for_each(|&f| sum.add(f));
        let plain: f64 = factors.iter().map(|f: &f64| f.ln()).sum();
        assert!((sum.value() - plain).abs() < 1e-12 * plain.abs());
    }
}
