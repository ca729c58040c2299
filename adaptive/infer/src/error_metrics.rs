//! Error metrics of one or more episodes, accumulated as sums. They do not depend on the simulator that made
//! the predictions.

use serde::Serialize;
use std::f64::consts::{PI, TAU};
use trundle_record::Prepared;

/// Prediction errors of a model on some episodes; `None` where a metric is undefined.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Score {
    /// Open loop over whole episodes, m.
    pub position_rmse: Option<f64>,
    /// Open loop, rad.
    pub heading_rmse: Option<f64>,
    /// Open loop, mean over episodes of the error of the last pose, m.
    pub final_position_error: Option<f64>,
    /// Open loop, mean over episodes, rad.
    pub final_heading_error: Option<f64>,
    /// Open loop, explained share of the variance of (x, y, ρθ).
    pub r2: Option<f64>,
    /// One second ahead, m.
    pub window_position_rmse: Option<f64>,
    /// One second ahead, rad.
    pub window_heading_rmse: Option<f64>,
    /// Required minus recorded wrench, both below `force_bandwidth`, N.
    pub force_rmse: Option<f64>,
    /// The same, N·m, about the object origin.
    pub torque_rmse: Option<f64>,
    /// Frequency up to which the poses determine the acceleration, Hz; `None` for quasi-static comparisons.
    pub force_bandwidth: Option<f64>,
    /// Mean log density of a pose sample, one window ahead.
    pub log_predictive_density: Option<f64>,
}

/// Running mean.
#[derive(Clone, Copy, Debug)]
struct RunningMean<const N: usize> {
    sum: [f64; N],
    count: f64,
}

impl<const N: usize> Default for RunningMean<N> {
    fn default() -> Self {
        Self { sum: [0.0; N], count: 0.0 }
    }
}

impl<const N: usize> RunningMean<N> {
    fn add(&mut self, values: [f64; N], count: f64) {
        self.sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        self.count += count;
    }

    fn value(&self, k: usize) -> Option<f64> {
        (self.count > 0.0).then(|| self.sum[k] / self.count).filter(|v| v.is_finite())
    }

    fn root(&self, k: usize) -> Option<f64> {
        self.value(k).map(f64::sqrt)
    }
}

/// Sums of squared errors of simulated motion and of wrenches.
#[derive(Clone, Debug, Default)]
pub struct ErrorMetrics {
    open_loop: RunningMean<2>,
    final_pose: RunningMean<2>,
    /// Residual sum of squares, with the total sum of squares in place of the count.
    unexplained: RunningMean<1>,
    window: RunningMean<2>,
    density: RunningMean<1>,
    wrench: RunningMean<2>,
}

impl ErrorMetrics {
    /// Adds an episode simulated in open loop, with one simulated pose for each recorded pose. Rotations are
    /// scaled by `rho`, m. The first `unscored` seconds after contact are left out.
    pub fn add_open_loop(&mut self, simulated: &[[f64; 3]], episode: &Prepared, rho: f64, unscored: f64) {
        let is_scored = |t: f64| t < episode.contact || t >= episode.contact + unscored;
        let pairs = || episode.pose.iter().zip(simulated).filter(|(seen, _)| is_scored(seen.t));
        let n = pairs().count() as f64;
        let center = [0, 1, 2].map(|k| pairs().map(|(seen, _)| seen.pose[k]).sum::<f64>() / n);
        for (seen, simulated) in pairs() {
            let [position, heading] = square_error(seen.pose, *simulated);
            self.open_loop.add([position, heading], 1.0);
            let d = [0, 1, 2].map(|k| seen.pose[k] - center[k]);
            let variance = d[0] * d[0] + d[1] * d[1] + (rho * d[2]).powi(2);
            self.unexplained.add([position + rho * rho * heading], variance);
        }
        if let (Some(seen), Some(simulated)) = (episode.pose.last(), simulated.last()) {
            self.final_pose.add(square_error(seen.pose, *simulated).map(f64::sqrt), 1.0);
        }
    }

    /// Adds the error of a pose predicted within a window: measured minus predicted.
    pub fn add_window(&mut self, [x, y, theta]: [f64; 3]) {
        self.window.add([x * x + y * y, wrap(theta).powi(2)], 1.0);
    }

    /// Adds the log density of such a pose.
    pub fn add_log_density(&mut self, log_density: f64) {
        self.density.add([log_density], 1.0);
    }

    /// Adds the error of a wrench: required minus recorded.
    pub fn add_wrench(&mut self, [x, y, torque]: [f64; 3]) {
        self.wrench.add([x * x + y * y, torque * torque], 1.0);
    }

    /// Sum of two accumulators.
    pub fn merged(mut self, other: &Self) -> Self {
        self.open_loop.add(other.open_loop.sum, other.open_loop.count);
        self.final_pose.add(other.final_pose.sum, other.final_pose.count);
        self.unexplained.add(other.unexplained.sum, other.unexplained.count);
        self.window.add(other.window.sum, other.window.count);
        self.density.add(other.density.sum, other.density.count);
        self.wrench.add(other.wrench.sum, other.wrench.count);
        self
    }

    /// The metrics. Heading and torque errors are `None` unless `turns` is set.
    pub fn score(&self, turns: bool) -> Score {
        let heading = |value: Option<f64>| value.filter(|_| turns);
        Score {
            position_rmse: self.open_loop.root(0),
            heading_rmse: heading(self.open_loop.root(1)),
            final_position_error: self.final_pose.value(0),
            final_heading_error: heading(self.final_pose.value(1)),
            r2: self.unexplained.value(0).map(|unexplained| 1.0 - unexplained),
            window_position_rmse: self.window.root(0),
            window_heading_rmse: heading(self.window.root(1)),
            force_rmse: self.wrench.root(0),
            torque_rmse: heading(self.wrench.root(1)),
            force_bandwidth: None,
            log_predictive_density: self.density.value(0),
        }
    }
}

/// An angle wrapped to (−π, π].
pub(crate) fn wrap(angle: f64) -> f64 {
    let turned = (angle + PI).rem_euclid(TAU) - PI;
    if turned == -PI { PI } else { turned }
}

fn square_error(a: [f64; 3], b: [f64; 3]) -> [f64; 2] {
    [(a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2), wrap(a[2] - b[2]).powi(2)]
}
