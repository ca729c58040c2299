//! Estimation of the lag of the readings, in the whole recording and in each episode.
//!
//! Here the fit of the wrench has no bounds: mass, damping and friction may have any sign. Otherwise a lag could compensate
//! for an active bound.

use std::ops::Range;

use nalgebra::{Cholesky, DVector, Dyn};

use super::dynamics::{Blocks, LoadTransform, NormalEquations, Readings, WINDOWS_PER_EPISODE};

/// Number of grid points of the lag on either side of zero.
const LAG_STEPS: usize = 50;
/// Relative ridge, for recordings without motion along some axis.
const RIDGE: f64 = 1e-9;
/// Number of alternations between the lags of the windows and the fit.
const ALTERNATIONS: usize = 6;
/// Number of grid points of the drift on either side of zero.
const DRIFT_STEPS: usize = 25;

/// Lags of a recording, s. A positive lag is a late reading.
#[derive(Debug, Clone)]
pub(crate) struct Lag {
    /// Common lag of all episodes, and its standard deviation.
    pub constant: (f64, f64),
    /// Unexplained share without a lag, with a constant lag, with a drift, and with a jump in each episode.
    pub unexplained: [f64; 4],
    /// Drift, s per window.
    pub drift: f64,
    /// Jump of each episode.
    pub jumps: Vec<Jump>,
    /// Lag of each window for the other checks: the constant lag, or that of drift or jumps if these explain much more.
    pub by_window: Vec<f64>,
    /// Step of the lag grid, s.
    pub step: f64,
}

/// Lags of an episode.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jump {
    /// Lag before the jump, s.
    pub before: f64,
    /// Lag after the jump, s.
    pub after: f64,
    /// First window after the jump; 0 if there is no jump.
    pub window: usize,
    /// Residual sum of squares with the common lag relative to that with the lags of the episode.
    pub gain: f64,
    /// Standard deviation of the jump, or of the lag of an episode without a jump, s, by a jackknife over windows. Errors of
    /// the motion and of the body's model can mimic a lag in one window, as at an impact, but not the same lag in several.
    /// Infinite if less than two windows show a lag.
    pub sd: f64,
}

/// Maximum misfit with drift or jumps, relative to that with a constant lag, for their use.
const MAX_VARYING_LAG_RATIO: f64 = 0.6;
/// Maximum misfit with a constant lag, relative to that without a lag, for its use.
pub(crate) const MAX_CONSTANT_LAG_RATIO: f64 = 0.85;

/// Right-hand sides and sums of squares of each window at each lag, with the common normal matrix.
struct Grid {
    lags: Vec<f64>,
    /// Right-hand sides by lag and window.
    right: Vec<Vec<DVector<f64>>>,
    /// Sums of squares by lag and window.
    total: Vec<Vec<f64>>,
    windows: Vec<NormalEquations>,
}

impl Grid {
    fn new(blocks: &Blocks, readings: &Readings, correction: &LoadTransform) -> Self {
        let step = blocks.range / LAG_STEPS as f64;
        let lags: Vec<f64> = (0..=2 * LAG_STEPS).map(|k| (k as f64 - LAG_STEPS as f64) * step).collect();
        let (mut right, mut total) = (vec![], vec![]);
        for lag in &lags {
            let (r, t) =
                blocks.right_hand_sides(readings, *lag).iter().map(|m| m.transformed(correction)).unzip();
            right.push(r);
            total.push(t);
        }
        Self { lags, right, total, windows: blocks.normal_equations(readings, 0.0) }
    }

    fn solver(&self, without: Option<usize>) -> Option<Solver> {
        let kept = self.windows.iter().enumerate().filter(|(w, _)| Some(w / WINDOWS_PER_EPISODE) != without);
        Solver::new(&NormalEquations::sum(kept.map(|(_, m)| m)))
    }

    /// Right-hand side and sum of squares over all windows, except those of the episode `without`. `lag` gives the index of
    /// the lag of each window.
    fn sides(&self, lag: impl Fn(usize) -> usize, without: Option<usize>) -> (DVector<f64>, f64) {
        let mut right = DVector::zeros(self.right[0][0].len());
        let mut total = 0.0;
        for w in (0..self.windows.len()).filter(|w| Some(w / WINDOWS_PER_EPISODE) != without) {
            right += &self.right[lag(w)][w];
            total += self.total[lag(w)][w];
        }
        (right, total)
    }

    /// Unexplained share for each common lag.
    fn shares(&self, without: Option<usize>) -> Option<Vec<f64>> {
        let solver = self.solver(without)?;
        Some((0..self.lags.len()).map(|k| solver.share(&self.sides(|_| k, without))).collect())
    }

    /// Residual sum of squares of window `w` at lag `k` for `coefficients`, where `quadratic` is their quadratic form.
    fn square(&self, coefficients: &DVector<f64>, quadratic: f64, k: usize, w: usize) -> f64 {
        self.total[k][w] - 2.0 * self.right[k][w].dot(coefficients) + quadratic
    }

    fn step(&self) -> f64 {
        self.lags[1] - self.lags[0]
    }
}

/// Factorised normal equations.
struct Solver {
    cholesky: Cholesky<f64, Dyn>,
    scale: DVector<f64>,
}

impl Solver {
    fn new(equations: &NormalEquations) -> Option<Self> {
        let mut normal = equations.normal.clone();
        let floor = 1e-12 * normal.diagonal().amax();
        let scale = normal.diagonal().map(|d| d.max(floor).max(f64::MIN_POSITIVE).sqrt());
        for i in 0..scale.len() {
            (0..scale.len()).for_each(|j| normal[(i, j)] /= scale[i] * scale[j]);
            normal[(i, i)] += RIDGE;
        }
        Some(Self { cholesky: normal.cholesky()?, scale })
    }

    fn coefficients(&self, right: &DVector<f64>) -> DVector<f64> {
        self.cholesky.solve(&right.component_div(&self.scale)).component_div(&self.scale)
    }

    /// Unexplained share of the load.
    fn share(&self, (right, total): &(DVector<f64>, f64)) -> f64 {
        if *total > 0.0 { (1.0 - self.coefficients(right).dot(right) / total).max(0.0) } else { 1.0 }
    }
}

/// Index of the smallest value.
fn argmin(values: &[f64]) -> usize {
    (0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0)
}

/// Vertex of the parabola through the smallest value and its neighbours: position in steps, and value.
fn vertex(values: &[f64]) -> (f64, f64) {
    let k = argmin(values);
    if k == 0 || k + 1 == values.len() {
        return (k as f64, values[k]);
    }
    let (a, b, c) = (values[k - 1], values[k], values[k + 1]);
    let curvature = a - 2.0 * b + c;
    if curvature <= 0.0 {
        return (k as f64, b);
    }
    let shift = 0.5 * (a - c) / curvature;
    (k as f64 + shift, b - 0.5 * curvature * shift * shift)
}

/// Common lag with the smallest misfit, s.
pub(crate) fn constant(blocks: &Blocks, readings: &Readings, correction: &LoadTransform) -> f64 {
    let grid = Grid::new(blocks, readings, correction);
    let Some(shares) = grid.shares(None) else { return 0.0 };
    (vertex(&shares).0 - LAG_STEPS as f64) * grid.step()
}

/// Estimates the constant lag, the drift and the jumps.
pub(crate) fn lag(blocks: &Blocks, readings: &Readings, correction: &LoadTransform) -> Lag {
    let grid = Grid::new(blocks, readings, correction);
    let windows = grid.windows.len();
    let none = Lag {
        constant: (0.0, f64::INFINITY),
        unexplained: [1.0; 4],
        drift: 0.0,
        jumps: vec![],
        by_window: vec![0.0; windows],
        step: grid.step(),
    };
    let (Some(shares), Some(solver)) = (grid.shares(None), grid.solver(None)) else { return none };
    let at = argmin(&shares);
    let to_time = |k: f64| (k - LAG_STEPS as f64) * grid.step();
    let (drift, with_drift) = drift(&grid, &solver, at);
    let (jumps, with_jumps) = jumps(&grid, &solver, at);
    let share = |lag: &[usize]| solver.share(&grid.sides(|w| lag[w], None));
    let (lag, lag_share) = vertex(&shares);
    let unexplained = [shares[LAG_STEPS], lag_share, share(&with_drift), share(&with_jumps)];
    let constant = (to_time(lag), sd(&grid));
    let by_window = if unexplained[2].min(unexplained[3]) > MAX_VARYING_LAG_RATIO * shares[at] {
        vec![if lag_share < MAX_CONSTANT_LAG_RATIO * shares[LAG_STEPS] { lag } else { 0.0 }; windows]
    } else {
        let used = if unexplained[2] < unexplained[3] { with_drift } else { with_jumps };
        used.iter().map(|&k| grid.lags[k]).collect()
    };
    Lag { constant, unexplained, drift, jumps, by_window, step: grid.step() }
}

/// Standard deviation of the common lag, by a jackknife over episodes, in s.
fn sd(grid: &Grid) -> f64 {
    let episodes = grid.windows.len() / WINDOWS_PER_EPISODE;
    if episodes < 2 {
        return grid.step();
    }
    let lags: Vec<f64> =
        (0..episodes).filter_map(|e| Some(vertex(&grid.shares(Some(e))?).0 * grid.step())).collect();
    let n = lags.len() as f64;
    let mean = lags.iter().sum::<f64>() / n;
    ((n - 1.0) / n * lags.iter().map(|l| (l - mean) * (l - mean)).sum::<f64>()).sqrt()
}

/// Coefficients for the lags of the windows, and their quadratic form in each window.
fn solve(grid: &Grid, solver: &Solver, lag: &[usize]) -> (DVector<f64>, Vec<f64>) {
    let coefficients = solver.coefficients(&grid.sides(|w| lag[w], None).0);
    let quadratic = grid.windows.iter().map(|m| coefficients.dot(&(&m.normal * &coefficients))).collect();
    (coefficients, quadratic)
}

/// The drift with the smallest misfit, s per window, and the index of the lag of each window.
fn drift(grid: &Grid, solver: &Solver, at: usize) -> (f64, Vec<usize>) {
    let n = grid.windows.len();
    let top = grid.lags.len() - 1;
    let index = |start: usize, slope: f64, w: usize| {
        let k = start as f64
            + slope * ((w % WINDOWS_PER_EPISODE) as f64 - (WINDOWS_PER_EPISODE as f64 - 1.0) / 2.0);
        (k.round().max(0.0) as usize).min(top)
    };
    let slopes: Vec<f64> = (0..=2 * DRIFT_STEPS).map(|k| (k as f64 - DRIFT_STEPS as f64) / 2.0).collect();
    let mut found = (0.0, vec![at; n]);
    for _ in 0..ALTERNATIONS {
        let (coefficients, quadratic) = solve(grid, solver, &found.1);
        let square = |start: usize, slope: f64| {
            (0..n).map(|w| grid.square(&coefficients, quadratic[w], index(start, slope, w), w)).sum::<f64>()
        };
        let all = slopes.iter().flat_map(|&slope| (0..=top).map(move |start| (start, slope)));
        let best = all.min_by(|a, b| square(a.0, a.1).total_cmp(&square(b.0, b.1)));
        let Some((start, slope)) = best else { break };
        found = (slope * grid.step(), (0..n).map(|w| index(start, slope, w)).collect());
    }
    found
}

/// The jump of each episode with the smallest misfit, and the index of the lag of each window.
fn jumps(grid: &Grid, solver: &Solver, at: usize) -> (Vec<Jump>, Vec<usize>) {
    let n = grid.windows.len();
    let mut lag = vec![at; n];
    let mut jumps = vec![];
    for _ in 0..ALTERNATIONS {
        let (coefficients, quadratic) = solve(grid, solver, &lag);
        jumps.clear();
        for first in (0..n).step_by(WINDOWS_PER_EPISODE) {
            let over = |from: usize, to: usize| {
                let square = |k: usize| {
                    (first + from..first + to)
                        .map(|w| grid.square(&coefficients, quadratic[w], k, w))
                        .sum::<f64>()
                };
                let squares: Vec<f64> = (0..grid.lags.len()).map(square).collect();
                let k = argmin(&squares);
                (k, squares[k])
            };
            let whole = over(0, WINDOWS_PER_EPISODE);
            let splits = (1..WINDOWS_PER_EPISODE).map(|k| (k, over(0, k), over(k, WINDOWS_PER_EPISODE)));
            let best = splits.min_by(|a, b| (a.1.1 + a.2.1).total_cmp(&(b.1.1 + b.2.1)));
            let Some((window, before, after)) = best else { continue };
            let (window, before, after) = if before.1 + after.1 < MAX_VARYING_LAG_RATIO * whole.1 {
                (window, before.0, after.0)
            } else {
                (0, whole.0, whole.0)
            };
            for w in 0..WINDOWS_PER_EPISODE {
                lag[first + w] = if w < window { before } else { after };
            }
            let square = |w: usize| {
                let k = if w < window { before } else { after };
                (
                    grid.square(&coefficients, quadratic[first + w], at, first + w),
                    grid.square(&coefficients, quadratic[first + w], k, first + w),
                )
            };
            let (common, own) = (0..WINDOWS_PER_EPISODE)
                .map(square)
                .fold((0.0, 0.0), |sum, square| (sum.0 + square.0, sum.1 + square.1));
            let gain = common.max(0.0) / own.max(f64::MIN_POSITIVE);
            let profile = |w: usize| -> Vec<f64> {
                let of = |k: usize| grid.square(&coefficients, quadratic[first + w], k, first + w);
                (0..grid.lags.len()).map(of).collect()
            };
            let shows_lag = |w: &usize| grid.total[at][first + w] > 0.0;
            let sd_of = |windows: Range<usize>| {
                grid.step() * jackknife_sd(&windows.filter(shows_lag).collect::<Vec<_>>(), profile)
            };
            // The window before `window` may contain the jump itself, so that neither lag holds there.
            let sd = if window == 0 {
                sd_of(0..WINDOWS_PER_EPISODE)
            } else {
                sd_of(0..window - 1).hypot(sd_of(window..WINDOWS_PER_EPISODE))
            };
            jumps.push(Jump { before: grid.lags[before], after: grid.lags[after], window, gain, sd });
        }
    }
    (jumps, lag)
}

/// Standard deviation of the vertex of `profile`, in steps, by a jackknife over `windows`. Infinite for fewer than two.
fn jackknife_sd(windows: &[usize], profile: impl Fn(usize) -> Vec<f64>) -> f64 {
    let n = windows.len() as f64;
    if windows.len() < 2 {
        return f64::INFINITY;
    }
    let profiles: Vec<Vec<f64>> = windows.iter().map(|&w| profile(w)).collect();
    let without = |left_out: usize| {
        let kept = profiles.iter().enumerate().filter(|(i, _)| *i != left_out).map(|(_, profile)| profile);
        let sum = kept.fold(vec![0.0; profiles[0].len()], |sum, profile| {
            sum.iter().zip(profile).map(|(a, b)| a + b).collect()
        });
        vertex(&sum).0
    };
    let lags: Vec<f64> = (0..windows.len()).map(without).collect();
    let mean = lags.iter().sum::<f64>() / n;
    ((n - 1.0) / n * lags.iter().map(|lag| (lag - mean).powi(2)).sum::<f64>()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_that_one_window_shows_is_undetermined() {
        let parabola = |at: f64, weight: f64| -> Vec<f64> {
            (0..=100).map(|k| weight * (f64::from(k) - at).powi(2)).collect()
        };
        let agreeing = |w: usize| parabola(70.0 + 0.1 * w as f64, 1.0);
        assert!(jackknife_sd(&[3, 4, 5], agreeing) < 0.2);
        // The start of a push with an impact, and a window that depends little on the lag.
        let impact = |w: usize| if w == 0 { parabola(85.0, 50.0) } else { parabola(51.0, 0.01) };
        assert!(jackknife_sd(&[0, 1], impact) > 10.0);
        assert!(jackknife_sd(&[0], impact).is_infinite());
    }
}
