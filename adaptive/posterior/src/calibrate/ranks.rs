//! Uniformity of ranks and coverage of intervals.

use crate::calibrate::{Calibration, RANKS, Replicate};
use serde::Serialize;
use statrs::distribution::{Beta, ChiSquared, ContinuousCDF};

/// Number of bins of the test of uniformity.
const BINS: usize = 10;

/// Calibration of one parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterCalibration {
    /// The parameter.
    pub name: String,
    /// Number of rounds.
    pub rounds: usize,
    /// Coverage of the central 50 % interval, with a 95 % confidence interval of the coverage.
    pub cover_50: [f64; 3],
    /// The same for the central 90 % interval.
    pub cover_90: [f64; 3],
    /// p-value of a χ² test of uniform ranks with ten bins.
    pub uniform_p: f64,
    /// Number of rounds in each tenth of the ranks.
    pub histogram: Vec<usize>,
    /// Mean rank as a share; ½ without bias.
    pub mean_rank: f64,
}

/// Calibration of all parameters of a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CalibrationTable {
    /// Name of the sampling method.
    pub method: &'static str,
    /// Name of the study.
    pub name: String,
    /// One row for each parameter.
    pub parameters: Vec<ParameterCalibration>,
}

impl Calibration {
    /// The table of some rounds of this study.
    pub fn table(&self, rounds: &[Replicate]) -> CalibrationTable {
        CalibrationTable {
            method: self.method().name(),
            name: self.name.clone(),
            parameters: calibrations(&self.parameters, rounds),
        }
    }
}

/// Calibration of each parameter.
pub fn calibrations(parameters: &[String], rounds: &[Replicate]) -> Vec<ParameterCalibration> {
    parameters
        .iter()
        .enumerate()
        .map(|(k, name)| calibration(name, rounds.iter().map(|r| r.rank[k])))
        .collect()
}

fn calibration(name: &str, ranks: impl Iterator<Item = usize> + Clone) -> ParameterCalibration {
    let n = ranks.clone().count();
    let mut histogram = vec![0; BINS];
    for rank in ranks.clone() {
        histogram[(rank * BINS / (RANKS + 1)).min(BINS - 1)] += 1;
    }
    let covered = |share: f64| {
        let tail = ((RANKS + 1) as f64 * (1.0 - share) / 2.0).round() as usize;
        interval(ranks.clone().filter(|r| (tail..=RANKS - tail).contains(r)).count(), n)
    };
    let mean_rank = ranks.clone().map(|r| r as f64).sum::<f64>() / (n as f64 * RANKS as f64);
    ParameterCalibration {
        name: name.to_owned(),
        rounds: n,
        cover_50: covered(0.5),
        cover_90: covered(0.9),
        uniform_p: uniform(&histogram),
        histogram,
        mean_rank,
    }
}

/// Share `k` of `n` with its 95 % interval (Clopper & Pearson 1934).
fn interval(k: usize, n: usize) -> [f64; 3] {
    let quantile =
        |a: f64, b: f64, p: f64| Beta::new(a, b).map(|beta| beta.inverse_cdf(p)).unwrap_or(f64::NAN);
    let (hits, misses) = (k as f64, (n - k) as f64);
    let low = if k == 0 { 0.0 } else { quantile(hits, misses + 1.0, 0.025) };
    let high = if k == n { 1.0 } else { quantile(hits + 1.0, misses, 0.975) };
    [hits / n as f64, low, high]
}

/// p-value of a χ² test that the bins are equally likely.
fn uniform(histogram: &[usize]) -> f64 {
    let expected = histogram.iter().sum::<usize>() as f64 / histogram.len() as f64;
    let statistic: f64 = histogram.iter().map(|&h| (h as f64 - expected).powi(2) / expected).sum();
    ChiSquared::new((histogram.len() - 1) as f64).map_or(f64::NAN, |chi| 1.0 - chi.cdf(statistic))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_ranks_cover_and_crowded_ones_do_not() {
        let even = calibration("even", 0..400);
        assert!((even.cover_90[0] - 0.9).abs() < 1e-12 && (even.cover_50[0] - 0.5).abs() < 1e-12);
        assert!(even.uniform_p > 0.999 && (even.mean_rank - 0.5).abs() < 1e-12);
        let crowded = calibration("crowded", (0..100).map(|k| if k % 2 == 0 { 2 } else { 396 }));
        assert!(crowded.cover_90[2] < 0.1 && crowded.uniform_p < 1e-6);
    }

    #[test]
    fn the_interval_of_a_share_is_that_of_the_tables() {
        // Clopper & Pearson for 8 of 10: 0.4439 to 0.9748.
        let [share, low, high] = interval(8, 10);
        assert!((share - 0.8).abs() < 1e-12 && (low - 0.4439).abs() < 1e-4 && (high - 0.9748).abs() < 1e-4);
    }
}
