//! One axis: a Kalman filter over (pose, velocity, acceleration) and its smoother.
//!
//! The smoother is the modified Bryson–Frazier form (Bierman 1973, "Fixed interval smoothing with discrete
//! measurements"): equal to Rauch–Tung–Striebel, but it inverts no covariance, and that of an object known to
//! rest is singular.

use super::symmetric::Symmetric;

/// A pose is never better known than this, m or rad: it keeps noiseless simulations solvable.
const SMALLEST_SD: f64 = 1e-8;

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
    start: Estimate,
    /// The time in which the object may have moved before each sample.
    intervals: Vec<Interval>,
}

/// What one sample did to the filter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Update {
    /// Before the sample.
    pub predicted: Estimate,
    /// Sample less prediction.
    pub innovation: f64,
    /// Its variance.
    pub spread: f64,
    /// Variance of the sample itself.
    noise: f64,
}

impl Update {
    #[inline]
    pub fn gain(&self) -> [f64; 3] {
        let by = self.spread.recip();
        self.predicted.cov.first().map(|c| c * by)
    }

    /// After the sample.
    ///
    /// With a gain `k` that is the covariance's first column over the spread, Joseph's form is `P − k (H P)`, whose
    /// first row is `r k`: a product of positive numbers, whatever the noise `r`.
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

    /// Squared distance of the sample from its prediction, in standard deviations.
    #[inline]
    pub fn surprise(&self) -> f64 {
        self.innovation * self.innovation / self.spread
    }

    pub fn log_likelihood(&self) -> f64 {
        -0.5 * (self.surprise() + self.spread.ln())
    }
}

/// A sum of logarithms, of which most are one of a product.
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
        // Far from where a product of two would overflow or lose digits.
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

/// A time of free motion, and what unit white jerk adds to the covariance in it.
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
    /// `sd`: standard deviation of a sample. The object rests until `rest_until`, s, where given.
    pub fn new(t: &'a [f64], z: &'a [f64], sd: f64, rest_until: Option<f64>) -> Self {
        let variance = sd.max(SMALLEST_SD).powi(2);
        let resting = rest_until.is_some_and(|until| t.first().is_some_and(|&first| until >= first));
        let mean = [z.first().copied().unwrap_or(0.0), 0.0, 0.0];
        let cov = if resting { Symmetric::default() } else { vague(t, z, variance) };
        let start = Estimate { mean, cov: Symmetric { pp: 1e4 * variance, ..cov } };
        let rest_until = rest_until.unwrap_or(f64::NEG_INFINITY);
        let before = t.iter().zip(t.iter().skip(1));
        let between = before.map(|(&from, &to)| Interval::new((to - from.max(rest_until)).max(0.0)));
        let intervals = std::iter::once(Interval::new(0.0)).chain(between).collect();
        Self { t, z, variance, start, intervals }
    }

    /// The state at sample `i` after `before`, the state at sample `i - 1`, under white jerk of intensity
    /// `jerk` (unit² s⁻⁵).
    #[inline]
    pub fn predict(&self, i: usize, before: &Estimate, jerk: f64) -> Estimate {
        let Interval { dt, noise } = &self.intervals[i];
        let [p, v, a] = before.mean;
        let half = 0.5 * dt * dt;
        Estimate {
            mean: [p + dt * v + half * a, v + dt * a, a],
            cov: before.cov.carried(*dt).plus(noise, jerk),
        }
    }

    /// Sample `i` against its prediction.
    #[inline]
    pub fn update(&self, i: usize, predicted: Estimate) -> Update {
        let innovation = self.z[i] - predicted.mean[0];
        Update { predicted, innovation, spread: predicted.cov.pp + self.variance, noise: self.variance }
    }

    pub fn start(&self) -> Estimate {
        self.start
    }

    /// All updates in order of time.
    fn forward(&self, jerk: f64) -> impl Iterator<Item = Update> + '_ {
        let mut last: Option<Estimate> = None;
        (0..self.t.len()).map(move |i| {
            let predicted = last.map_or(self.start, |last| self.predict(i, &last, jerk));
            let update = self.update(i, predicted);
            last = Some(update.posterior());
            update
        })
    }

    /// Log likelihood of the samples, up to a constant.
    pub fn log_likelihood(&self, jerk: f64) -> f64 {
        let (mut surprise, mut spread) = (0.0, LogSum::new());
        for update in self.forward(jerk) {
            surprise += update.surprise();
            spread.add(update.spread);
        }
        -0.5 * (surprise + spread.value())
    }

    /// State at each sample given all samples.
    pub fn smooth(&self, jerk: f64) -> Vec<Estimate> {
        let updates: Vec<Update> = self.forward(jerk).collect();
        let (mut pull, mut weight) = ([0.0; 3], Symmetric::default());
        let mut smoothed = Vec::with_capacity(updates.len());
        for (update, interval) in updates.iter().zip(&self.intervals).rev() {
            let gain = update.gain();
            pull[0] -= dot(gain, pull) + update.innovation / update.spread;
            weight = weight.seen(gain, update.spread.recip());
            smoothed.push(corrected(&update.predicted, pull, weight));
            let [p, v, a] = pull;
            let dt = interval.dt;
            pull = [p, dt * p + v, 0.5 * dt * dt * p + dt * v + a];
            weight = weight.carried_back(dt);
        }
        smoothed.reverse();
        smoothed
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn corrected(predicted: &Estimate, pull: [f64; 3], weight: Symmetric) -> Estimate {
    let mut cov = predicted.cov.plus(&predicted.cov.around(weight), -1.0);
    for variance in [&mut cov.pp, &mut cov.vv, &mut cov.aa] {
        *variance = variance.max(0.0); // rounding, where the object rests
    }
    let shift = predicted.cov.times(pull);
    Estimate { mean: [0, 1, 2].map(|k| predicted.mean[k] - shift[k]), cov }
}

/// A start about which nothing is known: ten times the fastest motion that the first samples allow.
fn vague(t: &[f64], z: &[f64], variance: f64) -> Symmetric {
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
    fn logarithms_of_products_are_sums() {
        let factors = [1e-16, 3.0, 1e-120, 1e150, 7.0, 1e-300, 2.0];
        let mut sum = LogSum::new();
        factors.iter().for_each(|&f| sum.add(f));
        let plain: f64 = factors.iter().map(|f: &f64| f.ln()).sum();
        assert!((sum.value() - plain).abs() < 1e-12 * plain.abs());
    }
}
