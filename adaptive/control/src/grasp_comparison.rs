//! Comparison of grasps by the cost of their best plans.

use crate::effort::shared_settings;
use crate::{ControlError, Dynamics, ObstacleMap, Planner, PlanningTask};

/// Iterations of each plan in a comparison.
const COMPARISON_ITERATIONS: usize = 4;

impl Planner {
    /// Cost of the best plan for each grasp, for the state and goal of `task`; the grasp of `task` is ignored. A cost is
    /// infinite if all plans diverge. All grasps use the same random numbers.
    ///
    /// # Errors
    /// As [`Planner::plan`], except for divergence.
    pub fn compare<D: Dynamics>(
        &self,
        models: &[D],
        task: &PlanningTask,
        obstacle_map: &ObstacleMap,
        grasps: &[[f64; 2]],
    ) -> Result<Vec<f64>, ControlError> {
        let rollouts = grasps.len() * models.len();
        let settings = shared_settings(self.settings(), COMPARISON_ITERATIONS, rollouts);
        let mut costs = Vec::with_capacity(grasps.len());
        for &grasp in grasps {
            let mut planner = Self::new(settings.clone(), self.seed())?;
            let task = PlanningTask { grasp, ..task.clone() };
            match planner.plan(models, &task, obstacle_map) {
                Ok(_) => costs.push(planner.cost(models, &task, obstacle_map)),
                Err(ControlError::Diverged { .. }) => costs.push(f64::INFINITY),
                Err(error) => return Err(error),
            }
        }
        Ok(costs)
    }
}
