//! What a plan is judged by.
//!
//! ```text
//! ∫ |p − p*| + w_θ |θ − θ*| + w_u Σ (u/u_max)² + w_v (excess speed)² + w_c (lack of obstacle_map)² dt
//!     +  T (final error + w_s speed)  +  w_θ (θ − θ*)² / 2ω  +  T_a |a − a*| grip/u_max
//! ```
//! The lack of obstacle_map is what a margin lacks, as a normalised_action of it; among obstacles, by how much the way to the goal is
//! longer than it looks, turns with it, is added to the distance. The first two terms are minus the reward of the environment; the excess is over speeds at which
//! the object would be lost; the last three terms stand for what happens after the plan. An object with a locked wheel turns
//! slowly on the spot: a turn that is left is charged for as long as it takes at the pace ω. What dry friction holds, a, is
//! not moved by small corrections, and often cannot be turned about the object's middle at all: it has to come to its place
//! first, and the object is then turned about it.

use std::f64::consts::TAU;

use serde::Deserialize;
use trundle_model::State;

use crate::dynamics::Anchor;
use crate::{ControlError, ObstacleMap};

/// Weights of the cost of a plan, in metre-seconds.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Cost {
    /// What a radian of heading error costs, m.
    pub heading: f64,
    /// What an action of half the range between its bounds costs along each axis, m.
    pub effort: f64,
    /// Speed from which on the object gets out of hand, m/s.
    pub speed_limit: f64,
    /// Spin from which on it does, rad/s.
    pub spin_limit: f64,
    /// What exceeding a limit by all of it costs, m.
    pub excess: f64,
    /// For how long the pose error at the end of the plan is charged, s.
    pub arrival: f64,
    /// How fast a heading error that is left at the end of the plan is taken to be undone, rad/s.
    pub pace: f64,
    /// For how long it is charged that what dry friction holds is not where it should be at the end of the plan, s, where
    /// it takes all the force to move it.
    pub anchor: f64,
    /// How far a speed at the end of the plan is taken to carry, s: metres of error for each m/s.
    pub momentum: f64,
    /// ObstacleMap that should be left to obstacles, m.
    pub margin: f64,
    /// What touching an obstacle costs, m; nearer than the margin it rises with the square, and a margin deep in it is four times that.
    pub collision: f64,
}

impl Default for Cost {
    fn default() -> Self {
        Self {
            heading: 0.3,
            effort: 0.005,
            speed_limit: 1.2,
            spin_limit: 2.5,
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

/// Deeper in an obstacle than the margin it costs no more: the way out is what counts.
const MAX_MARGIN_DEFICIT: f64 = 2.0;

/// Where the object is, and where it is to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanningTask {
    /// Motion at the start of the plan, world axes.
    pub state: State<f64>,
    /// Goal pose of the object frame in the world, m, m, rad.
    pub goal: [f64; 3],
    /// Where the object is held, object frame, m.
    pub grasp: [f64; 2],
}

impl PlanningTask {
    /// Refuse numbers that are none.
    ///
    /// # Errors
    /// When a number is not finite; the message says which.
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

impl Cost {
    /// Refuse negative weights and limits of nothing.
    ///
    /// # Errors
    /// When a weight is negative or a limit not positive; the message says which.
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

    /// Cost of one second in a state under an action; `normalised_action` is the action over half the range between its bounds.
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

    /// Cost of a second too near to an obstacle.
    #[inline]
    fn obstacle_cost(&self, state: &State<f64>, obstacle_map: &ObstacleMap) -> f64 {
        if obstacle_map.is_empty() {
            return 0.0;
        }
        let deficit = (1.0 - obstacle_map.clearance(state.pose, self.margin) / self.margin)
            .clamp(0.0, MAX_MARGIN_DEFICIT);
        self.collision * deficit * deficit
    }

    /// Cost of being left in a state.
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

    /// Cost of leaving what dry friction holds where it should not be; `force` is all that there is to move it.
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

/// Unlike `hypot` it is one instruction; lengths here are far from over- and underflow.
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
    fn at_the_goal_and_still_nothing_is_due() {
        let there = State::at_rest(GOAL);
        let cost = Cost::default();
        assert_eq!(cost.running_cost(&there, &GOAL, &ObstacleMap::empty(), [0.0; 3]), 0.0);
        assert_eq!(cost.terminal_cost(&there, &GOAL, &ObstacleMap::empty()), 0.0);
    }

    #[test]
    fn headings_are_compared_the_short_way_round() {
        let there = State::at_rest([1.0, 0.0, -3.0]);
        let expected = 0.3 * (TAU - 6.0);
        assert!(
            (Cost::default().running_cost(&there, &GOAL, &ObstacleMap::empty(), [0.0; 3]) - expected).abs()
                < 1e-12
        );
    }

    #[test]
    fn a_turn_that_is_left_costs_what_it_takes_to_undo() {
        let left = |turn: f64| State::at_rest([GOAL[0], GOAL[1], GOAL[2] - turn]);
        let cost = Cost { arrival: 0.0, pace: 0.5, ..Cost::default() };
        // From 2 rad at 0.5 rad/s: 4 s, of 1 rad on average.
        assert!((cost.terminal_cost(&left(2.0), &GOAL, &ObstacleMap::empty()) - 0.3 * 4.0).abs() < 1e-12);
        assert!((cost.terminal_cost(&left(TAU - 1.0), &GOAL, &ObstacleMap::empty()) - 0.3).abs() < 1e-12);
        let error = Cost { pace: 0.0, ..Cost::default() }.check().unwrap_err();
        assert!(error.to_string().contains("cost.pace"), "{error}");
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
