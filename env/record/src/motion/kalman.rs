//! One axis: a Kalman filter over (pose, velocity, acceleration) and its smoother.
//!
//! The smoother is the modified Bryson–Frazier form (Bierman 1973, "Fixed interval smoothing with discrete
//! measurements"): equal to Rauch–Tung–Striebel, but it inverts no covariance, and that of an object known to
//! rest is singular.

use nalgebra::{Matrix3, Vector3};

/// A pose is never better known than this, m or rad: it keeps noiseless simulations solvable.
const SMALLEST_SD: f64 = 1e-8;

/// Mean and covariance of (pose, velocity, acceleration).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Estimate {
    pub mean: Vector3<f64>,
    pub cov: Matrix3<f64>,
}

/// The samples of one axis.
pub(crate) struct Axis<'a> {
    pub t: &'a [f64],
    pub z: &'a [f64],
    pub variance: f64,
    rest_until: f64,
    start: Estimate,
}

/// What one sample did to the filter.
#[derive(Debug, Clone)]
pub(crate) struct Update {
    /// Before the sample.
    pub predicted: Estimate,
    /// Sample less prediction.
    pub innovation: f64,
    /// Its variance.
    pub spread: f64,
}

impl Update {
    pub fn gain(&self) -> Vector3<f64> {
        self.predicted.cov.column(0) / self.spread
    }

    /// After the sample.
    pub fn posterior(&self) -> Estimate {
        let Estimate { mean, cov } = &self.predicted;
        let gain = self.gain();
        // Joseph's form keeps the covariance positive when the noise is tiny.
        let keep = Matrix3::identity() - gain * Vector3::x().transpose();
        let noise = self.spread - cov[(0, 0)];
        let joseph = keep * cov * keep.transpose() + gain * noise * gain.transpose();
        Estimate { mean: mean + gain * self.innovation, cov: joseph }
    }

    pub fn log_likelihood(&self) -> f64 {
        -0.5 * (self.innovation * self.innovation / self.spread + self.spread.ln())
    }
}

impl<'a> Axis<'a> {
    /// `sd`: standard deviation of a sample. The object rests until `rest_until`, s, where given.
    pub fn new(t: &'a [f64], z: &'a [f64], sd: f64, rest_until: Option<f64>) -> Self {
        let variance = sd.max(SMALLEST_SD).powi(2);
        let resting = rest_until.is_some_and(|until| t.first().is_some_and(|&first| until >= first));
        let cov = if resting { Matrix3::zeros() } else { vague(t, z, variance) };
        let mean = Vector3::new(z.first().copied().unwrap_or(0.0), 0.0, 0.0);
        let mut start = Estimate { mean, cov };
        start.cov[(0, 0)] = 1e4 * variance;
        Self { t, z, variance, rest_until: rest_until.unwrap_or(f64::NEG_INFINITY), start }
    }

    /// The state at sample `i` after `before`, the state at sample `i - 1`, under white jerk of intensity
    /// `jerk` (unit² s⁻⁵).
    pub fn predict(&self, i: usize, before: &Estimate, jerk: f64) -> Estimate {
        let dt = (self.t[i] - self.t[i - 1].max(self.rest_until)).max(0.0);
        let step = transition(dt);
        Estimate {
            mean: step * before.mean,
            cov: step * before.cov * step.transpose() + process_noise(dt) * jerk,
        }
    }

    /// Sample `i` against its prediction.
    pub fn update(&self, i: usize, predicted: Estimate) -> Update {
        let innovation = self.z[i] - predicted.mean[0];
        let spread = predicted.cov[(0, 0)] + self.variance;
        Update { predicted, innovation, spread }
    }

    pub fn start(&self) -> Estimate {
        self.start.clone()
    }

    /// All updates in order of time.
    pub fn forward(&self, jerk: f64) -> Vec<Update> {
        let mut updates: Vec<Update> = Vec::with_capacity(self.t.len());
        for i in 0..self.t.len() {
            let predicted = match updates.last() {
                Some(last) => self.predict(i, &last.posterior(), jerk),
                None => self.start(),
            };
            updates.push(self.update(i, predicted));
        }
        updates
    }

    /// Log likelihood of the samples, up to a constant.
    pub fn log_likelihood(&self, jerk: f64) -> f64 {
        self.forward(jerk).iter().map(Update::log_likelihood).sum()
    }

    /// State at each sample given all samples.
    pub fn smooth(&self, jerk: f64) -> Vec<Estimate> {
        let updates = self.forward(jerk);
        let mut pull = Vector3::zeros();
        let mut weight = Matrix3::zeros();
        let mut smoothed = Vec::with_capacity(updates.len());
        for (i, update) in updates.iter().enumerate().rev() {
            let keep = Matrix3::identity() - update.gain() * Vector3::x().transpose();
            let mut pull_before = keep.transpose() * pull;
            let mut weight_before = keep.transpose() * weight * keep;
            pull_before[0] -= update.innovation / update.spread;
            weight_before[(0, 0)] += 1.0 / update.spread;
            smoothed.push(corrected(&update.predicted, &pull_before, &weight_before));
            if i > 0 {
                let dt = (self.t[i] - self.t[i - 1].max(self.rest_until)).max(0.0);
                let step = transition(dt);
                pull = step.transpose() * pull_before;
                weight = step.transpose() * weight_before * step;
            }
        }
        smoothed.reverse();
        smoothed
    }
}

fn corrected(predicted: &Estimate, pull: &Vector3<f64>, weight: &Matrix3<f64>) -> Estimate {
    let cov = predicted.cov - predicted.cov * weight * predicted.cov;
    let mut cov = (cov + cov.transpose()) * 0.5;
    for k in 0..3 {
        cov[(k, k)] = cov[(k, k)].max(0.0); // rounding, where the object rests
    }
    Estimate { mean: predicted.mean - predicted.cov * pull, cov }
}

fn transition(dt: f64) -> Matrix3<f64> {
    Matrix3::new(1.0, dt, dt * dt / 2.0, 0.0, 1.0, dt, 0.0, 0.0, 1.0)
}

/// Covariance that unit white jerk adds in `dt`.
fn process_noise(dt: f64) -> Matrix3<f64> {
    let (d2, d3) = (dt * dt, dt * dt * dt);
    let (d4, d5) = (d2 * d2, d2 * d3);
    Matrix3::new(d5 / 20.0, d4 / 8.0, d3 / 6.0, d4 / 8.0, d3 / 3.0, d2 / 2.0, d3 / 6.0, d2 / 2.0, dt)
}

/// A start about which nothing is known: ten times the fastest motion that the first samples allow.
fn vague(t: &[f64], z: &[f64], variance: f64) -> Matrix3<f64> {
    let early = t.iter().zip(z).skip(1).take(10);
    let (mut speed, mut first) = (0.0_f64, f64::INFINITY);
    for (&ti, &zi) in early {
        let elapsed = ti - t[0];
        first = first.min(elapsed);
        speed = speed.max(((zi - z[0]).abs() + variance.sqrt()) / elapsed);
    }
    if !first.is_finite() {
        return Matrix3::zeros();
    }
    let (speed, accel) = (10.0 * speed, 10.0 * speed / first);
    Matrix3::from_diagonal(&Vector3::new(0.0, speed * speed, accel * accel))
}
