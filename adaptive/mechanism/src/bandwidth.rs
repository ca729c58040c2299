//! The frequency up to which positions tell acceleration, from the noise of the positions.

use crate::kernel::Kernel;
use crate::resample::{Grid, interpolated, median_interval};

/// Standard deviation of a Gaussian filter with a cut-off (-3 dB) of 1 Hz, s: √(ln 2)/(2π).
const SD_OF_ONE_HERTZ: f64 = 0.1325;
/// Largest share of the accelerations' variance that may be noise.
const MAX_NOISE_SHARE: f64 = 0.01;
/// Shares of the variances of velocity and acceleration that the filter keeps, of those at the highest useful cut-off
/// frequency. The first keeps the amplitude of a swing, the second the reversals of a motion at constant speeds.
const MIN_SIGNAL_SHARES: [f64; 2] = [0.95, 0.7];
/// Ratio of neighbouring cut-off frequencies.
const STEP: f64 = 1.25;
/// Largest factor by which the first stage is shorter than one of two equal stages. What it does to terms that are not linear
/// falls with the fourth power of this factor, and the number of samples grows with it.
const MAX_REFINEMENT: f64 = 2.0;
/// Most filtered samples of a joint. More only cost time: a friction law does not need them.
const MAX_SAMPLES: f64 = 4000.0;
/// Fewest filtered samples of a joint, if the noise allows them.
const MIN_SAMPLES: f64 = 200.0;
/// Standard deviations of the filter between samples that are compared. Noise of neighbours is then correlated by 0.1.
const SPACING_SDS: f64 = 3.0;

/// Standard deviations of the two filter stages, s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StageSds {
    /// Of the filter of positions and efforts, before terms that are not linear.
    pub first: f64,
    /// Of the filter of residuals.
    pub second: f64,
}

impl StageSds {
    /// Stages that together have the first cut-off frequency; two equal ones would have the second one.
    pub fn new(cutoffs: Cutoffs) -> Self {
        let both = SD_OF_ONE_HERTZ / cutoffs.compared;
        let finest = (SD_OF_ONE_HERTZ / cutoffs.resolved).clamp(both / MAX_REFINEMENT, both);
        let first = finest / 2f64.sqrt();
        Self { first, second: (both * both - first * first).sqrt() }
    }

    /// Stages with the same first one and the shortest second one.
    pub fn finest(&self) -> Self {
        Self { second: self.first, ..*self }
    }

    /// Number of samples at intervals of `dt` from one compared sample to the next.
    pub fn spacing(&self, dt: f64) -> usize {
        ((SPACING_SDS * self.both() / dt) as usize).max(1)
    }

    /// Standard deviation of both stages.
    pub fn both(&self) -> f64 {
        self.first.hypot(self.second)
    }
}

/// Positions of one joint in one episode.
pub(crate) struct Positions<'a> {
    pub t: &'a [f64],
    pub q: &'a [f64],
}

/// Standard deviation of the noise of positions, from their third differences: those of a motion are small, those of
/// white noise have 20 times its variance. Quantised positions have at least the noise of a step, `step/√12`.
pub(crate) fn noise(episodes: &[Positions<'_>]) -> f64 {
    let mut thirds: Vec<f64> = vec![];
    let mut steps: Vec<f64> = vec![];
    for Positions { q, .. } in episodes {
        thirds.extend(q.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2)));
        steps.extend(q.windows(2).map(|w| (w[1] - w[0]).abs()));
    }
    if thirds.is_empty() {
        return 0.0;
    }
    let kept = (thirds.len() * 3).div_ceil(4);
    thirds.sort_by(f64::total_cmp);
    // The mean of the smallest three quarters of squared normal numbers is 0.37 of the mean of all.
    let mean =
        thirds[..kept].iter().sum::<f64>() / kept as f64 / if kept == thirds.len() { 1.0 } else { 0.37 };
    let repeated = steps.iter().filter(|step| **step == 0.0).count();
    let smallest = steps.iter().copied().filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    // In quantised positions many neighbours are equal, and every step is a multiple of the smallest.
    let is_quantised = repeated * 10 > steps.len() && smallest.is_finite();
    let quantisation = if is_quantised { smallest / 12f64.sqrt() } else { 0.0 };
    (mean / 20.0).sqrt().max(quantisation)
}

/// Cut-off frequencies, Hz.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cutoffs {
    /// Up to it a motion has most of its acceleration, and no more than [`MAX_NOISE_SHARE`] of the accelerations is noise.
    pub compared: f64,
    /// The largest one at which no more than this share is noise. Terms that are not linear are computed up to it.
    pub resolved: f64,
}

/// The cut-off frequencies of one joint.
///
/// `slowest` is the largest median interval of the streams that are compared, s. The filter resolves it.
pub(crate) fn cutoffs(episodes: &[Positions<'_>], noise: f64, slowest: f64) -> Cutoffs {
    let duration: f64 = episodes.iter().filter_map(|e| Some(e.t.last()? - e.t.first()?)).sum();
    // Each of the two filter stages has a standard deviation of at least one interval.
    let highest = SD_OF_ONE_HERTZ / (slowest * 2f64.sqrt());
    let highest = highest.min(MAX_SAMPLES * SPACING_SDS * SD_OF_ONE_HERTZ / duration.max(f64::MIN_POSITIVE));
    let shortest =
        episodes.iter().filter_map(|e| Some(e.t.last()? - e.t.first()?)).fold(f64::INFINITY, f64::min);
    let lowest = (4.0 * SD_OF_ONE_HERTZ * 8.0 / shortest).min(highest);
    let mut frequency = highest;
    let mut power = powers(episodes, noise, frequency, 2);
    while frequency > lowest * STEP && power[1] > MAX_NOISE_SHARE * power[0] {
        frequency /= STEP;
        power = powers(episodes, noise, frequency, 2);
    }
    let resolved = frequency.max(lowest);
    // Frequencies beyond the motion only add noise.
    let signal = |power: [f64; 2]| (power[0] - power[1]).max(0.0);
    let kept = |frequency: f64, order: usize| signal(powers(episodes, noise, frequency, order));
    let wanted = [1, 2].map(|order| MIN_SIGNAL_SHARES[order - 1] * kept(frequency, order));
    let suffices =
        |frequency: f64| [1, 2].into_iter().all(|order| kept(frequency, order) >= wanted[order - 1]);
    let enough = MIN_SAMPLES * SPACING_SDS * SD_OF_ONE_HERTZ / duration.max(f64::MIN_POSITIVE);
    while frequency > lowest.max(enough) * STEP && suffices(frequency / STEP) {
        frequency /= STEP;
    }
    Cutoffs { compared: frequency.max(lowest), resolved }
}

/// Mean square of a derivative of the filtered positions, and the part of it that is noise.
fn powers(episodes: &[Positions<'_>], noise: f64, frequency: f64, order: usize) -> [f64; 2] {
    let sd = SD_OF_ONE_HERTZ / frequency;
    let (mut total, mut by_noise, mut count) = (0.0, 0.0, 0.0);
    for Positions { t, q } in episodes {
        let Some(native) = median_interval(t) else { continue };
        let dt = native.max(sd / 8.0);
        let kernel = Kernel::new(sd, dt);
        let (Some(first), Some(last)) = (t.first(), t.last()) else { continue };
        let grid = Grid { start: *first, dt, len: 1 + ((last - first) / dt) as usize };
        let samples = interpolated(t, q, &grid);
        let spread = noise * (native / dt).min(1.0).sqrt() * kernel.noise()[order];
        let spacing = ((sd / dt) as usize).max(1);
        for at in (kernel.half..grid.len.saturating_sub(kernel.half)).step_by(spacing) {
            total += kernel.derivatives(&samples, at)[order].powi(2);
            by_noise += spread * spread;
            count += 1.0;
        }
    }
    if count == 0.0 { [0.0, 0.0] } else { [total / count, by_noise / count] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(amplitude_noise: f64) -> (Vec<f64>, Vec<f64>) {
        let t: Vec<f64> = (0..2000).map(|k| k as f64 * 0.005).collect();
        let noise = |k: usize| amplitude_noise * 12f64.sqrt() * ((k as f64 * 0.754_877_666).fract() - 0.5);
        let q = t.iter().enumerate().map(|(k, t)| (3.0 * t).sin() + noise(k * k)).collect();
        (t, q)
    }

    #[test]
    fn the_noise_is_estimated() {
        let (t, q) = samples(1e-4);
        let found = noise(&[Positions { t: &t, q: &q }]);
        assert!((found / 1e-4 - 1.0).abs() < 0.3, "{found}");
    }

    #[test]
    fn noise_lowers_the_cutoff() {
        let of = |sd: f64| {
            let (t, q) = samples(sd);
            cutoffs(&[Positions { t: &t, q: &q }], sd, 0.005).compared
        };
        assert!(of(1e-5) > 1.2 * of(3e-2), "{} {}", of(1e-5), of(3e-2));
    }
}
