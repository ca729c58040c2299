//! Settings of the planner.

use serde::Deserialize;

use crate::{ControlError, Cost};

/// Largest number of actions in all plans of an iteration, limited by memory.
const MAX_ACTIONS: usize = 20_000_000;
/// Smallest limit on the number of rollouts. Fewer do not improve a plan.
const MIN_ROLLOUTS: usize = 100;
/// Largest duration of an action, s.
const MAX_HOLD_S: f64 = 60.0;

/// Settings of a [`crate::Planner`]. All except the bounds have defaults.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Least wrench at the grasp, object axes, `[N, N, N·m]`.
    pub lower: [f64; 3],
    /// Greatest wrench at the grasp, object axes, `[N, N, N·m]`.
    pub upper: [f64; 3],
    /// Number of actions in a plan.
    #[serde(default = "horizon")]
    pub horizon: usize,
    /// Duration of each action, s.
    #[serde(default = "hold")]
    pub hold: f64,
    /// Number of sampled plans per iteration.
    #[serde(default = "samples")]
    pub samples: usize,
    /// Number of iterations per call.
    #[serde(default = "iterations")]
    pub iterations: usize,
    /// Largest number of rollouts per call, a rollout being one plan on one model; no limit by default. Above it, calls with
    /// several models run fewer iterations with fewer plans.
    #[serde(default)]
    pub rollouts: Option<usize>,
    /// Standard deviation of the sampled actions in the first iteration, as a fraction of half the range between the bounds.
    #[serde(default = "spread")]
    pub spread: f64,
    /// Correlation between successive sampled actions, in [0, 1). High values avoid vibrations.
    #[serde(default = "smoothness")]
    pub smoothness: f64,
    /// Temperature, as a fraction of the standard deviation of the costs. Low values favour the best samples.
    #[serde(default = "temperature")]
    pub temperature: f64,
    /// Bonus of a plan, in seconds, per metre of spread between the models' end poses (up to 0.3 m). It favours
    /// discriminating pushes.
    #[serde(default)]
    pub curiosity: f64,
    /// Weights of the cost function.
    #[serde(default)]
    pub cost: Cost,
}

fn horizon() -> usize {
    20
}
fn hold() -> f64 {
    0.1
}
fn samples() -> usize {
    256
}
fn iterations() -> usize {
    6
}
fn spread() -> f64 {
    0.6
}
fn smoothness() -> f64 {
    0.8
}
fn temperature() -> f64 {
    0.02
}

impl Settings {
    /// Default settings with bounds on the wrench, `[N, N, N·m]`.
    pub fn within(lower: [f64; 3], upper: [f64; 3]) -> Self {
        Self {
            lower,
            upper,
            horizon: horizon(),
            hold: hold(),
            samples: samples(),
            iterations: iterations(),
            rollouts: None,
            spread: spread(),
            smoothness: smoothness(),
            temperature: temperature(),
            curiosity: 0.0,
            cost: Cost::default(),
        }
    }

    /// Check the values.
    ///
    /// # Errors
    /// If bounds are reversed or a number is out of its range. The message names it.
    pub fn check(&self) -> Result<(), ControlError> {
        for k in 0..3 {
            let (low, high) = (self.lower[k], self.upper[k]);
            if !(low.is_finite() && high.is_finite() && low < high) {
                let remedy = "each lower bound must be finite and below its upper bound (N, N, N·m)";
                return Err(ControlError::value("lower, upper", (self.lower, self.upper), remedy));
            }
        }
        for (key, count) in
            [("horizon", self.horizon), ("samples", self.samples), ("iterations", self.iterations)]
        {
            if count == 0 {
                return Err(ControlError::value(key, count, "must be at least 1"));
            }
        }
        if self.rollouts.is_some_and(|rollouts| rollouts < MIN_ROLLOUTS) {
            return Err(ControlError::value("rollouts", self.rollouts, "must be at least 100"));
        }
        if self.horizon.checked_mul(self.samples).is_none_or(|actions| actions > MAX_ACTIONS) {
            let remedy = "their product must not exceed 20 million actions";
            return Err(ControlError::value("horizon, samples", (self.horizon, self.samples), remedy));
        }
        if self.hold > MAX_HOLD_S {
            return Err(ControlError::value("hold", self.hold, "must not exceed 60 s"));
        }
        for (key, value) in [("hold", self.hold), ("spread", self.spread), ("temperature", self.temperature)]
        {
            if !(value.is_finite() && value > 0.0) {
                return Err(ControlError::value(key, value, "must be positive and finite"));
            }
        }
        if !(self.curiosity.is_finite() && self.curiosity >= 0.0) {
            return Err(ControlError::value(
                "curiosity",
                self.curiosity,
                "must be finite and not negative (s)",
            ));
        }
        if !(0.0..1.0).contains(&self.smoothness) {
            let remedy = "must lie in [0, 1); 0 makes the actions independent";
            return Err(ControlError::value("smoothness", self.smoothness, remedy));
        }
        self.cost.check()
    }

    /// Half the range between the bounds.
    pub(crate) fn half_range(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| (self.upper[k] - self.lower[k]) / 2.0)
    }

    pub(crate) fn clamp(&self, action: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| action[k].clamp(self.lower[k], self.upper[k]))
    }
}
