//! Goal, reward and end of an episode.

use trundle_model::State;

use super::{Episode, StepSums};
use crate::gripper::wrap_angle;
use crate::task::constants::*;
use crate::task::options::Options;
use crate::task::outcome::Outcome;
use crate::task::scene_layout::PATH_LOOKAHEAD_M;

impl Episode {
    /// Current target pose.
    pub(super) fn target(&self) -> [f64; 3] {
        self.progress
            .as_ref()
            .map_or(self.layout.goal, |path| path.pose_at(path.arc_length + PATH_LOOKAHEAD_M))
    }

    pub(super) fn outcome(&mut self, sums: &StepSums, periods: u32) -> Outcome {
        let State { pose, twist: [vx, vy, spin], .. } = *self.stepper.state();
        let [x, y, theta] = pose;
        let away = |to: [f64; 3]| ((x - to[0]).hypot(y - to[1]), wrap_angle(theta - to[2]));
        let (goal_distance, facing) = away(self.layout.goal);
        let (mut distance, mut heading_error, mut path_gain, mut progress) =
            (goal_distance, facing, 0.0, 0.0);
        if let Some(path) = &mut self.progress {
            let before = path.arc_length;
            distance = path.advance_to(pose);
            heading_error = wrap_angle(theta - path.pose_at(path.arc_length)[2]);
            (path_gain, progress) = (path.arc_length - before, path.arc_length / path.length());
        }
        let Options { reach, facing: max_heading_error, ends, horizon, .. } = *self.options;
        let speed = vx.hypot(vy);
        let inside = x.abs().max(y.abs()) <= ARENA_HALF_SIDE_M
            && speed <= MAX_SPEED_M_PER_S
            && spin.abs() <= MAX_SPIN_RAD_PER_S;
        // NaN counts as outside.
        let lost = !inside;
        let success = !lost
            && goal_distance < reach
            && facing.abs() < max_heading_error
            && speed < MAX_GOAL_SPEED_M_PER_S;
        let terminated = lost || (success && ends);
        let truncated = horizon > 0 && self.state.steps >= horizon && !terminated;
        let duration = f64::from(periods) * self.options.control_period();
        let touched = sums.touching_ticks > 0;
        let touch_time = f64::from(sums.touching_ticks) * self.options.step;
        self.state.contact_time += touch_time;
        let costs = self.options.costs();
        let touch_share = match costs.charges_whole_steps {
            true => f64::from(u8::from(touched)),
            false => touch_time / duration,
        };
        let effort = sums.effort * self.options.step / duration;
        let cost = distance
            + HEADING_COST_M_PER_RAD * heading_error.abs()
            + costs.touch * touch_share
            + costs.effort * effort
            + costs.time;
        let reward = path_gain - duration * cost - if lost { FAILURE_COST } else { 0.0 };
        Outcome {
            reward,
            terminated,
            truncated,
            success,
            lost,
            touched,
            distance,
            heading_error,
            progress,
            success_without_touching: success && self.state.contact_time == 0.0,
            contact_time: self.state.contact_time,
            contact_impulse: self.state.contact_impulse,
            action_clipped: false,
            duration,
        }
    }
}
