//! Motion of one joint in one episode on a uniform grid, and other streams on the same grid.

use super::gaussian::{acceleration_noise, derivatives, smooth};
use crate::episode::Episode;
use crate::prepare::median_step;

/// Filter widths that are tried, in samples.
const WIDTHS: [f64; 6] = [1.5, 3.0, 6.0, 12.0, 24.0, 48.0];
/// Largest noise of the acceleration relative to its own rms. One percent of the variance is noise at this value.
const MAX_ACCELERATION_NOISE: f64 = 0.1;
/// Largest number of points of a grid; longer episodes have a coarser one.
const MAX_POINTS: usize = 40_000;
/// Longest interval between samples that interpolation bridges, in steps of the grid.
const MAX_BRIDGED_STEPS: f64 = 10.0;

/// Motion of a joint in an episode.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    /// Times of the grid, s.
    pub t: Vec<f64>,
    /// Step of the grid, s.
    pub step: f64,
    /// Width of the filter, in steps.
    pub width: f64,
    /// Filtered position, velocity and acceleration.
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    /// Whether the motion at a point is supported by samples around it.
    pub valid: Vec<bool>,
    /// Standard deviation of the noise of a position.
    pub noise: f64,
    /// Standard deviation of the noise of the velocity.
    pub v_noise: f64,
}

/// Which filter a track uses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    /// Start, step, and number of points.
    pub start: f64,
    pub step: f64,
    pub points: usize,
}

impl Grid {
    /// The grid of the positions of all `joints` in `episode`: from the first to the last common sample, with the finest
    /// median step. `None` with fewer than ten points.
    pub fn of(episode: &Episode, joints: &[String]) -> Option<Self> {
        let times: Vec<Vec<f64>> =
            joints.iter().map(|joint| Some(episode.joint_stream("q", joint)?.0)).collect::<Option<_>>()?;
        let start = times.iter().filter_map(|t| t.first().copied()).fold(f64::NEG_INFINITY, f64::max);
        let end = times.iter().filter_map(|t| t.last().copied()).fold(f64::INFINITY, f64::min);
        let finest = times.iter().filter_map(|t| median_step(t)).fold(f64::INFINITY, f64::min);
        let step = finest.max((end - start) / MAX_POINTS as f64);
        let points = ((end - start) / step).floor() as usize + 1;
        (step > 0.0 && end > start && points >= 10).then_some(Self { start, step, points })
    }

    /// Times of the points, s.
    pub fn times(&self) -> Vec<f64> {
        (0..self.points).map(|k| self.start + k as f64 * self.step).collect()
    }
}

impl Track {
    /// The motion of `joint` in `episode` on `grid`. Without a `width` the narrowest filter whose acceleration is not mostly
    /// noise.
    pub fn new(episode: &Episode, joint: &str, grid: Grid, width: Option<f64>) -> Option<Self> {
        let (t, q) = episode.joint_stream("q", joint)?;
        let times = grid.times();
        let sampled = resampled(&t, &q, &times, false);
        let noise = white_noise(&q);
        let width = width.unwrap_or_else(|| narrowest(&sampled, noise));
        let [position, velocity, acceleration] = derivatives(&sampled, width);
        let valid = supported(&t, &times, grid.step, width);
        // The weights of a first derivative of a Gaussian.
        let v_noise = noise * (1.0 / (4.0 * std::f64::consts::PI.sqrt() * width.powi(3))).sqrt() / grid.step;
        Some(Self {
            t: times,
            step: grid.step,
            width,
            q: position,
            v: velocity.iter().map(|v| v / grid.step).collect(),
            a: acceleration.iter().map(|a| a / grid.step.powi(2)).collect(),
            valid,
            noise,
            v_noise,
        })
    }

    /// A stream on the grid, filtered like the motion; `None` if it has no sample.
    pub fn stream(&self, episode: &Episode, prefix: &str, joint: &str, held: bool) -> Option<Vec<f64>> {
        let (t, values) = episode.joint_stream(prefix, joint)?;
        Some(smooth(&resampled(&t, &values, &self.t, held), self.width))
    }
}

/// Width of the narrowest filter whose acceleration is not mostly noise.
fn narrowest(values: &[f64], noise: f64) -> f64 {
    let is_clear = |width: &&f64| {
        let [_, _, acceleration] = derivatives(values, **width);
        noise * acceleration_noise(**width) < MAX_ACCELERATION_NOISE * rms(&acceleration)
    };
    let widest = WIDTHS[WIDTHS.len() - 1];
    WIDTHS
        .iter()
        .filter(|width| 10.0 * **width < values.len() as f64)
        .find(is_clear)
        .copied()
        .unwrap_or(widest.min(values.len() as f64 / 10.0).max(WIDTHS[0]))
}

/// Standard deviation of white noise, from third differences: motion hardly contributes to them.
pub(crate) fn white_noise(values: &[f64]) -> f64 {
    let third: Vec<f64> = values.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).collect();
    // The variance of a third difference is 1 + 9 + 9 + 1 times that of a value.
    rms(&third) / 20.0_f64.sqrt()
}

pub(crate) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// `values` at `times`: held until the next sample, or interpolated. The first and last value extend to the ends.
pub(crate) fn resampled(t: &[f64], values: &[f64], times: &[f64], held: bool) -> Vec<f64> {
    let mut next = 0;
    let at = |time: &f64| {
        while next < t.len() && t[next] <= *time {
            next += 1;
        }
        if next == 0 {
            return values[0];
        }
        let (before, last) = (values[next - 1], t.len() - 1);
        if held || next > last {
            return before;
        }
        before + (values[next] - before) * (time - t[next - 1]) / (t[next] - t[next - 1])
    };
    times.iter().map(at).collect()
}

/// Whether there is no long gap within the filter around each time, nor an end of the episode.
fn supported(t: &[f64], times: &[f64], step: f64, width: f64) -> Vec<bool> {
    let mut valid = vec![true; times.len()];
    let reach = (2.0 * width).ceil() as usize;
    let first = times.first().copied().unwrap_or(0.0);
    for pair in t.windows(2).filter(|pair| pair[1] - pair[0] > MAX_BRIDGED_STEPS * step) {
        let [from, to] = [pair[0], pair[1]].map(|time| ((time - first) / step).max(0.0) as usize);
        let (from, to) = (from.saturating_sub(reach), (to + reach + 1).min(valid.len()));
        if from < to {
            valid[from..to].fill(false);
        }
    }
    let n = valid.len();
    valid[..reach.min(n)].fill(false);
    valid[n.saturating_sub(reach)..].fill(false);
    valid
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resampled_holds_or_interpolates() {
        let (t, values, times) = ([1.0, 2.0, 4.0], [0.0, 10.0, 20.0], [0.0, 1.5, 2.0, 3.0, 5.0]);
        assert_eq!(resampled(&t, &values, &times, true), [0.0, 0.0, 10.0, 10.0, 20.0]);
        assert_eq!(resampled(&t, &values, &times, false), [0.0, 5.0, 10.0, 15.0, 20.0]);
    }

    #[test]
    fn gaps_and_ends_are_not_valid() {
        let t: Vec<f64> = (0..40).chain(80..120).map(f64::from).collect();
        let times: Vec<f64> = (0..120).map(f64::from).collect();
        let valid = supported(&t, &times, 1.0, 1.5);
        let invalid: Vec<usize> = (0..120).filter(|&k| !valid[k]).collect();
        assert_eq!(invalid, (0..3).chain(36..84).chain(117..120).collect::<Vec<_>>());
    }
}
