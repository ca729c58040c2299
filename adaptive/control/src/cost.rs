//! Cost of a plan.
//!
//! ```text
//! ∫ |p − p*| + w_θ |θ − θ*| + w_u Σ (u/u_max)² + w_v (excess speed)² + w_c (margin deficit)² dt
//!     +  T (final error + w_s speed)  +  w_θ (θ − θ*)² / 2ω  +  T_a |a − a*| grip/u_max
//! ```
//!
//! The first two terms are the negative reward of the environment. Among obstacles, the detour to the goal is added to the
//! distance. The excess speed is relative to limits. The margin deficit is the missing clearance as a fraction of the margin.
//!
//! The last three terms represent what happens after the plan. An object with a locked wheel turns slowly on the spot, so a
//! remaining heading error is charged for the time that its correction takes at the pace ω. Small corrections do not move
//! the anchor a of dry friction, and often it cannot be turned about the object's centre. It must reach its goal position
//! first, and then the object turns about it.

use std::f64::consts::TAU;

use serde::Deserialize;
use trundle_model::State;

use crate::dynamics::Anchor;
use crate::{CommandedArm, ControlError, ObstacleMap};

/// Weights of the cost of a plan. The cost is in metre-seconds.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Cost {
    /// Cost of a heading error, m/rad.
    pub heading: f64,
    /// Cost of an action of half the range between its bounds along each axis, m.
    pub effort: f64,
    /// Speed above which an excess is charged, m/s. The default is 80 % of the speed that ends an episode.
    pub speed_limit: f64,
    /// Spin above which an excess is charged, rad/s. The default is 80 % of the spin that ends an episode.
    pub spin_limit: f64,
    /// Cost of exceeding a limit by 100 %, m.
    pub excess: f64,
    /// Time for which the final pose error is charged, s.
    pub arrival: f64,
    /// Assumed angular speed at which a final heading error is corrected, rad/s.
    pub pace: f64,
    /// Time for which the final position error of the anchor is charged, s, if moving the anchor takes the full force.
    pub anchor: f64,
    /// Assumed travel due to the final speed, m per m/s.
    pub momentum: f64,
    /// Desired clearance to obstacles, m.
    pub margin: f64,
    /// Cost of contact with an obstacle, m. It grows with the square of the margin deficit, up to four times this value at a
    /// penetration of one margin.
    pub collision: f64,
}

impl Default for Cost {
    fn default() -> Self {
        Self {
            heading: 0.3,
            effort: 0.005,
            speed_limit: 1.6,
            spin_limit: 3.2,
            excess: 10.0,
            arrival: 0.5,
            pace: 1.0,
            anchor: 8.0,
            momentum: 0.3,
            margin: 0.06,
            collision: 10.0,
        }
    }
}

/// Largest margin deficit: a penetration of one margin. Beyond it only the detour matters.
const MAX_MARGIN_DEFICIT: f64 = 2.0;

/// Initial state, goal, grasp and arm of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanningTask {
    /// State at the latest observation, world axes.
    pub state: State<f64>,
    /// Goal pose of the object frame in the world, m, m, rad.
    pub goal: [f64; 3],
    /// Position of the grasp, object frame, m.
    pub grasp: [f64; 2],
    /// The arm at the latest observation.
    pub arm: CommandedArm,
}

impl PlanningTask {
    /// Check the values.
    ///
    /// # Errors
    /// If a number is not finite. The message names it.
    pub fn check(&self) -> Result<(), ControlError> {
        let finite = |key, numbers: &[f64]| match numbers.iter().all(|n| n.is_finite()) {
            true => Ok(()),
            false => Err(ControlError::value(key, numbers, "must be finite (m, rad, s)")),
        };
        finite("pose", &self.state.pose)?;
        finite("twist", &self.state.twist)?;
        finite("goal", &self.goal)?;
        finite("grasp", &self.grasp)
    }
}

/// Decrease of the limits of speed and spin per delay, as a share of the limits, 1/s. The default limits are 80 % of those that
/// end an episode: 20 % is left for the two steps of 0.05 s in which a brake acts. Each 0.1 s of delay needs as much again.
const LIMIT_DECREASE_PER_S: f64 = 2.5;
/// Smallest share of the limits that is left.
const MIN_LIMIT_SHARE: f64 = 0.4;

impl Cost {
    /// The same cost for commands that act `delay` seconds later: with lower limits of speed and spin.
    pub(crate) fn with_delay(&self, delay: f64) -> Self {
        let share = (1.0 - LIMIT_DECREASE_PER_S * delay).max(MIN_LIMIT_SHARE);
        Self { speed_limit: share * self.speed_limit, spin_limit: share * self.spin_limit, ..self.clone() }
    }

    /// Check the values.
    ///
    /// # Errors
    /// If a weight is negative or a limit is not positive. The message names it.
    pub fn check(&self) -> Result<(), ControlError> {
        for (key, weight) in [
            ("cost.heading", self.heading),
            ("cost.effort", self.effort),
            ("cost.excess", self.excess),
            ("cost.arrival", self.arrival),
            ("cost.anchor", self.anchor),
            ("cost.momentum", self.momentum),
            ("cost.collision", self.collision),
        ] {
            if !(weight.is_finite() && weight >= 0.0) {
                return Err(ControlError::value(key, weight, "must be finite and not negative"));
            }
        }
        for (key, limit) in [
            ("cost.speed_limit", self.speed_limit),
            ("cost.spin_limit", self.spin_limit),
            ("cost.margin", self.margin),
            ("cost.pace", self.pace),
        ] {
            if !(limit.is_finite() && limit > 0.0) {
                return Err(ControlError::value(key, limit, "must be positive and finite (m/s, rad/s, m)"));
            }
        }
        Ok(())
    }

    /// Cost rate of a state under an action. `normalised_action` is the action divided by half the range between its bounds.
    #[inline]
    pub(crate) fn running_cost(
        &self,
        state: &State<f64>,
        goal: &[f64; 3],
        obstacle_map: &ObstacleMap,
        normalised_action: [f64; 3],
    ) -> f64 {
        let effort: f64 = normalised_action.iter().map(|u| u * u).sum();
        let [vx, vy, spin] = state.twist;
        let over = |value: f64, limit: f64| (value / limit - 1.0).max(0.0).powi(2);
        let excess = over(norm(vx, vy), self.speed_limit) + over(spin.abs(), self.spin_limit);
        let error = self.pose_error(state, goal, obstacle_map);
        error + self.effort * effort + self.excess * excess + self.obstacle_cost(state, obstacle_map)
    }

    /// Cost rate of insufficient clearance.
    #[inline]
    fn obstacle_cost(&self, state: &State<f64>, obstacle_map: &ObstacleMap) -> f64 {
        if obstacle_map.is_empty() {
            return 0.0;
        }
        let deficit = (1.0 - obstacle_map.clearance(state.pose, self.margin) / self.margin)
            .clamp(0.0, MAX_MARGIN_DEFICIT);
        self.collision * deficit * deficit
    }

    /// Cost of a final state.
    #[inline]
    pub(crate) fn terminal_cost(
        &self,
        state: &State<f64>,
        goal: &[f64; 3],
        obstacle_map: &ObstacleMap,
    ) -> f64 {
        let [vx, vy, spin] = state.twist;
        let carried = norm(vx, vy) + self.heading * spin.abs();
        let turn = wrap_angle(state.pose[2] - goal[2]);
        let undone = self.heading * turn * turn / (2.0 * self.pace);
        self.arrival * (self.pose_error(state, goal, obstacle_map) + self.momentum * carried) + undone
    }

    /// Cost of the final position error of the anchor. `force` is the largest available force, N.
    #[inline]
    pub(crate) fn anchor_cost(
        &self,
        state: &State<f64>,
        goal: &[f64; 3],
        anchor: &Anchor,
        force: f64,
    ) -> f64 {
        if anchor.grip == 0.0 {
            return 0.0;
        }
        let [x, y] = anchor.at;
        let place = |[px, py, theta]: [f64; 3]| {
            let (sin, cos) = theta.sin_cos();
            [px + cos * x - sin * y, py + sin * x + cos * y]
        };
        let (is, should) = (place(state.pose), place(*goal));
        let off = norm(is[0] - should[0], is[1] - should[1]);
        self.anchor * off * (anchor.grip / force).min(1.0)
    }

    #[inline]
    fn pose_error(&self, state: &State<f64>, goal: &[f64; 3], obstacle_map: &ObstacleMap) -> f64 {
        let [x, y, theta] = state.pose;
        norm(x - goal[0], y - goal[1])
            + self.heading * wrap_angle(theta - goal[2]).abs()
            + obstacle_map.detour(state.pose)
    }
}

/// Euclidean norm. It is faster than `hypot`, and the values are far from over- and underflow.
#[inline]
fn norm(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// The same angle in [−π, π].
#[inline]
fn wrap_angle(angle: f64) -> f64 {
    angle - TAU * (angle * (1.0 / TAU)).round_ties_even()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOAL: [f64; 3] = [1.0, 0.0, 3.0];

    #[test]
    fn rest_at_the_goal_has_zero_cost() {
        let there = State::at_rest(GOAL);
        let cost = Cost::default();
        assert_eq!(cost.running_cost(&there, &GOAL, &ObstacleMap::empty(), [0.0; 3]), 0.0);
        assert_eq!(cost.terminal_cost(&there, &GOAL, &ObstacleMap::empty()), 0.0);
    }

    #[test]
    fn heading_errors_are_wrapped() {
        let there = State::at_rest([1.0, 0.0, -3.0]);
        let expected = 0.3 * (TAU - 6.0);
        assert!(
            (Cost::default().running_cost(&there, &GOAL, &ObstacleMap::empty(), [0.0; 3]) - expected).abs()
                < 1e-12
        );
    }

    #[test]
    fn a_final_heading_error_costs_the_time_of_its_correction() {
        let left = |turn: f64| State::at_rest([GOAL[0], GOAL[1], GOAL[2] - turn]);
        let cost = Cost { arrival: 0.0, pace: 0.5, ..Cost::default() };
        // From 2 rad at 0.5 rad/s: 4 s, of 1 rad on average.
        assert!((cost.terminal_cost(&left(2.0), &GOAL, &ObstacleMap::empty()) - 0.3 * 4.0).abs() < 1e-12);
        assert!((cost.terminal_cost(&left(TAU - 1.0), &GOAL, &ObstacleMap::empty()) - 0.3).abs() < 1e-12);
        let error = Cost { pace: 0.0, ..Cost::default() }.check().unwrap_err();
        assert!(error.to_string().contains("cost.pace"), "{error}");
    }

    #[test]
    fn a_delay_lowers_the_limits_of_speed() {
        let cost = Cost::default();
        assert_eq!(cost.with_delay(0.0), cost);
        let late = cost.with_delay(0.1);
        assert!((late.speed_limit - 1.2).abs() < 1e-12 && (late.spin_limit - 2.4).abs() < 1e-12, "{late:?}");
        assert!((cost.with_delay(5.0).speed_limit - 0.64).abs() < 1e-12);
    }

    #[test]
    fn effort_and_speed_beyond_the_limit_cost_more() {
        let cost = Cost::default();
        let fast = State::moving(GOAL, [0.0, 2.0 * cost.speed_limit, 0.0]);
        let slow = State::moving(GOAL, [0.0, cost.speed_limit, 0.0]);
        assert!(
            (cost.running_cost(&fast, &GOAL, &ObstacleMap::empty(), [0.0; 3]) - cost.excess).abs() < 1e-12
        );
        assert_eq!(cost.running_cost(&slow, &GOAL, &ObstacleMap::empty(), [0.0; 3]), 0.0);
        assert!(
            (cost.running_cost(&slow, &GOAL, &ObstacleMap::empty(), [1.0, 0.0, -1.0]) - 2.0 * cost.effort)
                .abs()
                < 1e-12
        );
        assert!(cost.terminal_cost(&slow, &GOAL, &ObstacleMap::empty()) > 0.0);
    }
}
