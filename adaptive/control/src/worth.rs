//! What it would be worth to know which of several models is true.

use crate::{ControlError, Dynamics, Planner, Room, Settings, Task};

/// Iterations of each plan: from a plan that is there already, more change little.
const ITERATIONS: usize = 3;

impl Planner {
    /// What the best plan for all models costs on average more than each one's own, metre-seconds: the most that
    /// finding out can save. Each is planned from the plan as it is, which stays as it is.
    ///
    /// # Errors
    /// As [`Planner::plan`].
    pub fn regret<D: Dynamics>(&self, models: &[D], task: &Task, room: &Room) -> Result<f64, ControlError> {
        let mut indifferent = self.clone();
        indifferent.set(Settings { curiosity: 0.0, iterations: ITERATIONS, ..self.settings().clone() });
        let mut common = indifferent.clone();
        common.plan(models, task, room)?;
        let mut saved = 0.0;
        for model in models {
            let one = std::slice::from_ref(model);
            let mut own = indifferent.clone();
            own.plan(one, task, room)?;
            // A search that did worse than the common plan has found nothing to save.
            saved += (common.cost(one, task, room) - own.cost(one, task, room)).max(0.0);
        }
        Ok(saved / models.len() as f64)
    }
}
