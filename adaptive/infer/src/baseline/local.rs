//! Locally weighted regression, the paper's LWR: expressive, but it requires much data.
//!
//! ```text
//! ŷ(z) = a,   (a, b) = argmin Σ_i w_i (y_i − a − bᵀ(z_i − z))² + λ Σ_i w_i |b|²
//! w_i = exp(−½ Σ_k ((z_ik − z_k)/h_k)²)
//! ```
//! Atkeson, Moore, Schaal 1997 (the paper's \[21\]). The kernel widths `h`, one for each group of features,
//! and the ridge λ minimise the leave-one-out error on the training data, pooled over the channels.

use super::checks::check;
use super::error::BaselineError;
use super::features::Features;
use super::features::{MAX_FEATURES, Scale};
use super::predictor::{Predictor, StateVector};
use super::transitions::Transition;
use rayon::prelude::*;

/// Candidate kernel widths, in standard deviations of a feature; the last one makes the fit global.
const KERNEL_WIDTHS_SD: [f64; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, 1000.0];

/// Candidate ridges.
const RIDGES: [f64; 6] = [1e-9, 1e-4, 1e-2, 1e-1, 1.0, 10.0];

/// Maximum rounds of the coordinate search over the hyper-parameters.
const MAX_ROUNDS: usize = 4;

/// Locally weighted linear regression with a Gaussian kernel.
#[derive(Clone, Debug)]
pub struct Local {
    scale: Scale,
    data: Data,
    kernel: Kernel,
}

/// The kernel's hyper-parameters.
#[derive(Clone, Debug, PartialEq)]
struct Kernel {
    /// One over the squared width of each feature.
    precision: [f64; MAX_FEATURES],
    ridge: f64,
}

/// Training data: standardised features, and rates of change.
#[derive(Clone, Debug)]
struct Data {
    features: Features,
    inputs: Vec<[f64; MAX_FEATURES]>,
    rates: Vec<StateVector>,
}

impl Local {
    /// Fit to transitions, which should have one `dt`.
    ///
    /// # Errors
    /// When `training` is empty, or a number is not finite.
    pub fn fit(training: &[Transition], features: Features) -> Result<Self, BaselineError> {
        check(training)?;
        let rows: Vec<_> = training.iter().map(|t| features.of(&t.before, &t.wrench)).collect();
        let scale = Scale::of(&rows, features.count());
        let inputs = rows.iter().map(|row| padded(&scale.apply(row))).collect();
        let data = Data { features, inputs, rates: training.iter().map(|t| features.rate(t)).collect() };
        let kernel = data.select_kernel();
        Ok(Self { scale, data, kernel })
    }

    /// Kernel width of each feature, in its unit; very large for a global fit.
    pub fn widths(&self) -> Vec<f64> {
        let precision = &self.kernel.precision[..self.data.features.count()];
        precision.iter().zip(self.scale.sd()).map(|(p, sd)| sd / p.sqrt()).collect()
    }
}

impl Predictor for Local {
    fn predict(&self, x: &StateVector, u: &[f64; 3], dt: f64) -> StateVector {
        let features = self.data.features;
        let query = padded(&self.scale.apply(&features.of(x, u)));
        features.after(x, self.data.rate_at(&query, &self.kernel, None), dt)
    }
}

fn padded(row: &[f64]) -> [f64; MAX_FEATURES] {
    std::array::from_fn(|k| row.get(k).copied().unwrap_or(0.0))
}

/// Kernel for indices into the grids: a width for each group of features, then the ridge.
fn kernel(features: Features, choice: &[usize]) -> Kernel {
    let mut precision = [0.0; MAX_FEATURES];
    for (group, &index) in features.groups().iter().zip(choice) {
        precision[group.clone()].fill(KERNEL_WIDTHS_SD[index].powi(-2));
    }
    Kernel { precision, ridge: choice.last().map_or(RIDGES[0], |&index| RIDGES[index]) }
}

impl Data {
    /// Hyper-parameters with the lowest leave-one-out error, by coordinate search over the grids from a
    /// global kernel.
    fn select_kernel(&self) -> Kernel {
        let groups = self.features.groups().len();
        let mut choice = vec![KERNEL_WIDTHS_SD.len() - 1; groups];
        choice.push(RIDGES.len() - 1);
        let weights = self.weights();
        let error = |choice: &[usize]| self.leave_one_out_error(&kernel(self.features, choice), &weights);
        let mut best = error(&choice);
        for _ in 0..MAX_ROUNDS {
            let before = choice.clone();
            for position in (0..=groups).rev() {
                for value in 0..if position == groups { RIDGES.len() } else { KERNEL_WIDTHS_SD.len() } {
                    let mut other = choice.clone();
                    other[position] = value;
                    let found = if other == choice { best } else { error(&other) };
                    if found < best {
                        (best, choice) = (found, other);
                    }
                }
            }
            if choice == before {
                break;
            }
        }
        kernel(self.features, &choice)
    }

    /// Inverse variance of the rate of each channel; 0 for a constant channel.
    fn weights(&self) -> StateVector {
        let n = self.rates.len() as f64;
        std::array::from_fn(|k| {
            let mean = self.rates.iter().map(|r| r[k]).sum::<f64>() / n;
            let variance = self.rates.iter().map(|r| (r[k] - mean).powi(2)).sum::<f64>() / n;
            if variance > 0.0 { 1.0 / variance } else { 0.0 }
        })
    }

    /// Sum of squared leave-one-out errors; zero for a single observation.
    fn leave_one_out_error(&self, kernel: &Kernel, weights: &StateVector) -> f64 {
        if self.inputs.len() < 2 {
            return 0.0;
        }
        let error = |i: usize| {
            let found = self.rate_at(&self.inputs[i], kernel, Some(i));
            let squares = (0..6).map(|k| weights[k] * (found[k] - self.rates[i][k]).powi(2));
            let error = squares.sum::<f64>();
            if error.is_finite() { error } else { f64::MAX }
        };
        // The sum has a fixed order, so the result does not depend on the number of threads.
        let errors: Vec<f64> = (0..self.inputs.len()).into_par_iter().with_min_len(16).map(error).collect();
        errors.iter().sum()
    }

    /// Weighted linear fit at `query`, without the observation of index `without`.
    fn rate_at(&self, query: &[f64; MAX_FEATURES], kernel: &Kernel, without: Option<usize>) -> StateVector {
        let count = self.features.count();
        let distances: Vec<f64> =
            self.inputs.iter().map(|z| distance(query, z, &kernel.precision, count)).collect();
        let used = |i: &usize| Some(*i) != without;
        // Only ratios of weights matter. Relative to the nearest observation they do not underflow.
        let nearest = (0..self.inputs.len()).filter(used).map(|i| distances[i]).fold(f64::INFINITY, f64::min);
        let mut sums = Sums::default();
        for i in (0..self.inputs.len()).filter(used) {
            let weight = (-0.5 * (distances[i] - nearest)).exp();
            if weight > 1e-14 {
                sums.add(weight, query, &self.inputs[i], &self.rates[i], count);
            }
        }
        sums.intercept(kernel.ridge, count)
    }
}

fn distance(
    a: &[f64; MAX_FEATURES],
    b: &[f64; MAX_FEATURES],
    precision: &[f64; MAX_FEATURES],
    count: usize,
) -> f64 {
    (0..count).map(|k| precision[k] * (a[k] - b[k]).powi(2)).sum()
}

const SIZE: usize = MAX_FEATURES + 1;

/// Normal equations of a weighted fit: the lower triangle, and a right-hand side for each channel.
#[derive(Default)]
struct Sums {
    matrix: [[f64; SIZE]; SIZE],
    right: [StateVector; SIZE],
}

impl Sums {
    fn add(
        &mut self,
        weight: f64,
        query: &[f64; MAX_FEATURES],
        input: &[f64; MAX_FEATURES],
        rate: &StateVector,
        count: usize,
    ) {
        let mut row = [1.0; SIZE];
        for k in 0..count {
            row[k + 1] = input[k] - query[k];
        }
        for i in 0..=count {
            let scaled = weight * row[i];
            for (sum, rate) in self.right[i].iter_mut().zip(rate) {
                *sum += scaled * rate;
            }
            for (sum, feature) in self.matrix[i].iter_mut().zip(row).take(i + 1) {
                *sum += scaled * feature;
            }
        }
    }

    /// First component of the solution for each channel. Eliminates the unknowns from the last to the first;
    /// directions without data stay zero.
    fn intercept(mut self, ridge: f64, count: usize) -> StateVector {
        let ridge = ridge * self.matrix[0][0];
        for last in (1..=count).rev() {
            let (row, right) = (self.matrix[last], self.right[last]);
            let pivot = row[last] + ridge;
            if pivot <= 0.0 {
                continue;
            }
            for i in 0..last {
                let factor = row[i] / pivot;
                for (value, right) in self.right[i].iter_mut().zip(right) {
                    *value -= factor * right;
                }
                for (value, other) in self.matrix[i].iter_mut().zip(row).take(i + 1) {
                    *value -= factor * other;
                }
            }
        }
        self.right[0].map(|sum| sum / self.matrix[0][0])
    }
}
