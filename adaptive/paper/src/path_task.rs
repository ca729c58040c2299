//! A path around an obstacle: planning with a model, and execution in the simulated world.

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use trundle_infer::{StateVector, hold};
use trundle_model::{Clock, Model, Plant, to_body};
use trundle_sim::World;

use crate::PaperError;

/// Simulation step of the world in which plans are executed, s.
const WORLD_STEP_S: f64 = 2e-3;
/// Simulation step of the planner, s; the same as for pushes that score a model.
const PLANNING_STEP_S: f64 = 5e-3;
/// Number of times that a plan that touches the obstacle is replaced by one with a larger offset.
const MAX_DETOURS: usize = 4;
/// Increase of the offset, m.
const DETOUR_M: f64 = 0.15;
/// Number of pushes within which a plan corrects a deviation from the path.
const CORRECTION_PUSHES: f64 = 2.0;
/// Newton iterations for each push.
const NEWTON_ITERATIONS: usize = 4;
/// Step of the finite differences with respect to the wrench, N and N·m.
const WRENCH_DIFFERENCE: f64 = 1e-2;

/// A path from rest at the origin to `length` on the x axis, around an obstacle.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathTask {
    /// End of the path on the x axis, m.
    pub length: f64,
    /// Lateral offset of the path halfway, m; negative to the right.
    pub offset: f64,
    /// Corners of the obstacle, world, m.
    pub obstacle: Vec<[f64; 2]>,
    /// Number of pushes.
    pub steps: usize,
    /// Duration of a push, s.
    pub hold: f64,
    /// Largest force along an axis, N, and largest torque, N·m.
    pub max_wrench: [f64; 2],
    /// Axes in which a push is constant.
    pub axes: WrenchAxes,
}

/// Axes in which a wrench is constant while the object turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WrenchAxes {
    /// Object axes, as for the pushes that score a model.
    Object,
    /// World axes.
    World,
}

impl WrenchAxes {
    /// The wrench in object axes at a heading.
    fn in_object_axes(self, wrench: [f64; 3], heading: f64) -> [f64; 3] {
        match self {
            Self::Object => wrench,
            Self::World => to_body(wrench, heading),
        }
    }
}

/// A plan, and the poses that its model predicts, starting with the initial pose.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Wrench of each push, N, N, N·m.
    pub wrenches: Vec<[f64; 3]>,
    /// Poses before the first and after each push, m, m, rad.
    pub poses: Vec<[f64; 3]>,
}

impl PathTask {
    /// Plans pushes along the path. If the plan touches the obstacle according to the model, the path gets a
    /// larger offset.
    ///
    /// # Errors
    /// If a value of the model is free.
    pub fn plan(&self, model: &Model) -> Result<Plan, PaperError> {
        let mut task = self.clone();
        let mut plan = task.follow_path(model)?;
        for _ in 0..MAX_DETOURS {
            if !self.execute(model, &plan.wrenches)?.1 {
                break;
            }
            task.offset += DETOUR_M * self.offset.signum();
            plan = task.follow_path(model)?;
        }
        Ok(plan)
    }

    /// Chooses each push such that the model reaches the next pose of the path with the path's velocity.
    fn follow_path(&self, model: &Model) -> Result<Plan, PaperError> {
        let plant = model.resolved()?;
        let mut x: StateVector = [0.0; 6];
        let (mut plan, mut wrench) = (Plan { wrenches: vec![], poses: vec![[0.0; 3]] }, [0.0; 3]);
        for k in 1..=self.steps {
            let (pose, twist) = (self.pose(k as f64), self.twist(k as f64));
            let target = [0, 1, 2].map(|i| {
                let expected = x[i] + self.hold * (x[3 + i] + twist[i]) / 2.0;
                twist[i] + (pose[i] - expected) / (CORRECTION_PUSHES * self.hold)
            });
            wrench = self.wrench_for_twist(&plant, &x, target, wrench);
            x = self.state_after(&plant, &x, &wrench);
            plan.wrenches.push(wrench);
            plan.poses.push([x[0], x[1], x[2]]);
        }
        Ok(plan)
    }

    /// The state after a push.
    fn state_after(&self, plant: &Plant<f64>, x: &StateVector, wrench: &[f64; 3]) -> StateVector {
        let steps = (self.hold / PLANNING_STEP_S).round().max(1.0);
        let step =
            |x: StateVector, _| hold(plant, &x, &self.axes.in_object_axes(*wrench, x[2]), self.hold / steps);
        (0..steps as usize).fold(*x, step)
    }

    /// Pose on the path after `k` pushes: a minimum-jerk motion along `y = b sin²(πx/L)`, heading along the path.
    fn pose(&self, k: f64) -> [f64; 3] {
        let t = (k / self.steps as f64).clamp(0.0, 1.0);
        let x = self.length * t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
        let phase = std::f64::consts::PI * x / self.length;
        let slope = self.offset * (2.0 * phase).sin() * std::f64::consts::PI / self.length;
        [x, self.offset * phase.sin().powi(2), slope.atan()]
    }

    /// Time derivative of [`PathTask::pose`] by central differences.
    fn twist(&self, k: f64) -> [f64; 3] {
        const STEP: f64 = 1e-4;
        let (before, after) = (self.pose(k - STEP), self.pose(k + STEP));
        let span = self.hold * (f64::min(k + STEP, self.steps as f64) - (k - STEP));
        [0, 1, 2].map(|i| (after[i] - before[i]) / span)
    }

    /// The wrench within the limits after which the model has a given twist, by Newton's method from `start`.
    fn wrench_for_twist(
        &self,
        plant: &Plant<f64>,
        x: &StateVector,
        target: [f64; 3],
        start: [f64; 3],
    ) -> [f64; 3] {
        let [force, torque] = self.max_wrench;
        let limits = [force, force, torque];
        let mut wrench = start;
        for _ in 0..NEWTON_ITERATIONS {
            let at = self.state_after(plant, x, &wrench);
            let error = Vector3::from_fn(|i, _| target[i] - at[3 + i]);
            let columns = [0, 1, 2].map(|k| {
                let mut changed = wrench;
                changed[k] += WRENCH_DIFFERENCE;
                let moved = self.state_after(plant, x, &changed);
                Vector3::from_fn(|i, _| (moved[3 + i] - at[3 + i]) / WRENCH_DIFFERENCE)
            });
            let Some(change) = Matrix3::from_columns(&columns).lu().solve(&error) else { break };
            wrench = [0, 1, 2].map(|i| (wrench[i] + change[i]).clamp(-limits[i], limits[i]));
        }
        wrench
    }

    /// Executes pushes of an object next to the obstacle. Returns the poses, and whether it touched the obstacle.
    ///
    /// # Errors
    /// If a value of the object is free, or the obstacle is not a simple polygon.
    pub fn execute(
        &self,
        object: &Model,
        wrenches: &[[f64; 3]],
    ) -> Result<(Vec<[f64; 3]>, bool), PaperError> {
        let mut world = World::new(object, std::slice::from_ref(&self.obstacle), WORLD_STEP_S)?;
        world.place([0.0; 3]);
        let (mut poses, mut touched, mut t) = (vec![[0.0; 3]], false, 0.0);
        for &wrench in wrenches {
            for _ in 0..(self.hold / WORLD_STEP_S).round() as usize {
                let wrench = self.axes.in_object_axes(wrench, world.state().pose[2]);
                world.step(wrench, Clock::since_contact(t));
                t += WORLD_STEP_S;
                touched |= world.is_touching();
            }
            poses.push(world.state().pose);
        }
        Ok((poses, touched))
    }

    /// Distance of the last pose from the end of the path, m.
    pub fn final_error(&self, poses: &[[f64; 3]]) -> f64 {
        poses.last().map_or(f64::NAN, |p| (p[0] - self.length).hypot(p[1]))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use trundle_model::{Body, Effect, Kind};

    #[test]
    fn a_plan_with_the_true_model_reaches_the_goal_without_touching() {
        let square = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]];
        let drag = Effect::free(Kind::SupportDrag).with("mu", Some(8.0)).with("spread", Some(0.2));
        let body = Body::from_footprint(&square, 10.0).unwrap();
        let object = Model { effects: vec![drag], ..Model::nominal(body, Some(10.0), [true; 3]) };
        let obstacle = vec![[1.3, -0.1], [1.7, -0.1], [1.7, 0.1], [1.3, 0.1]];
        let task = PathTask {
            length: 3.0,
            offset: 0.4,
            obstacle,
            steps: 40,
            hold: 0.2,
            max_wrench: [60.0, 20.0],
            axes: WrenchAxes::Object,
        };
        let plan = task.plan(&object).unwrap();
        let (poses, touched) = task.execute(&object, &plan.wrenches).unwrap();
        assert!(!touched);
        assert!(task.final_error(&poses) < 0.05, "{}", task.final_error(&poses));
    }
}
