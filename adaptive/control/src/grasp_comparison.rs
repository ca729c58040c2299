//! Comparison of grasps by the cost of their best plans.

use crate::{ControlError, Dynamics, ObstacleMap, Planner, PlanningTask};

/// Iterations of each plan in a comparison.
const COMPARISON_ITERATIONS: usize = 4;
/// Smallest number of plans per iteration.
const MIN_SAMPLES: usize = 16;

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
        let plans = COMPARISON_ITERATIONS * grasps.len().max(1) * models.len().max(1);
        let full = self.settings().samples;
        let samples =
            self.settings().rollouts.map_or(full, |limit| (limit / plans).max(MIN_SAMPLES).min(full));
        let settings = crate::Settings {
            iterations: COMPARISON_ITERATIONS,
            samples,
            rollouts: None,
            ..self.settings().clone()
        };
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
