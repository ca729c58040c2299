//! Where to hold the object: what the best plan from each place costs.

use crate::{ControlError, Dynamics, ObstacleMap, Planner, PlanningTask};

/// Iterations with which the plans from different grasps are compared.
const COMPARISON_ITERATIONS: usize = 4;

impl Planner {
    /// What the best plan found from each grasp costs, from rest or motion as in `task`, whose own grasp does not
    /// count; infinite where none keeps the motion finite. Every grasp is given the same draws.
    ///
    /// # Errors
    /// As [`Planner::plan`], but for plans that run away.
    pub fn compare<D: Dynamics>(
        &self,
        models: &[D],
        task: &PlanningTask,
        obstacle_map: &ObstacleMap,
        grasps: &[[f64; 2]],
    ) -> Result<Vec<f64>, ControlError> {
        let settings = crate::Settings { iterations: COMPARISON_ITERATIONS, ..self.settings().clone() };
        let mut costs = Vec::with_capacity(grasps.len());
        for &grasp in grasps {
            let mut planner = Self::new(settings.clone(), self.seed())?;
            let task = PlanningTask { grasp, ..*task };
            match planner.plan(models, &task, obstacle_map) {
                Ok(_) => costs.push(planner.cost(models, &task, obstacle_map)),
                Err(ControlError::Diverged { .. }) => costs.push(f64::INFINITY),
                Err(error) => return Err(error),
            }
        }
        Ok(costs)
    }
}
