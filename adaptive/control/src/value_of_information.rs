//! Value of information: the expected gain from knowing which of several models is true.

use crate::effort::shared_settings;
use crate::{ControlError, Dynamics, ObstacleMap, Planner, PlanningTask, Settings};

/// Iterations of each plan. The warm start makes more iterations unnecessary.
const PLAN_ITERATIONS: usize = 3;

impl Planner {
    /// Expected value of perfect information, metre-seconds: the mean over the models of the cost of the best common plan
    /// minus the cost of the model's own best plan. All plans start from the current plan, which does not change.
    ///
    /// # Errors
    /// As [`Planner::plan`].
    pub fn regret<D: Dynamics>(
        &self,
        models: &[D],
        task: &PlanningTask,
        obstacle_map: &ObstacleMap,
    ) -> Result<f64, ControlError> {
        let mut exploiting = self.clone();
        // The common plan and each model's own one have the same samples, within half the limit each.
        let settings = shared_settings(self.settings(), PLAN_ITERATIONS, 2 * models.len());
        exploiting.set_settings(Settings { curiosity: 0.0, ..settings });
        let mut common = exploiting.clone();
        common.plan(models, task, obstacle_map)?;
        let mut saved = 0.0;
        for model in models {
            let one = std::slice::from_ref(model);
            let mut own = exploiting.clone();
            own.plan(one, task, obstacle_map)?;
            // A search may end with a higher cost than the common plan.
            saved += (common.cost(one, task, obstacle_map) - own.cost(one, task, obstacle_map)).max(0.0);
        }
        Ok(saved / models.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_model::{Body, Effect, Kind, Model, Plant, State};

    /// A table with a locked wheel.
    fn table(x: f64, y: f64) -> Plant<f64> {
        let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
        let wheel = [x, y, 0.4, 200.0, 200.0].map(Some).to_vec();
        let body = Body::from_footprint(&corners, 22.0).unwrap();
        let mut model = Model::nominal(body, Some(22.0), [true; 3]);
        model.effects = vec![Effect { kind: Kind::ViscousWheel, values: wheel }];
        model.resolved().unwrap()
    }

    fn task() -> PlanningTask {
        PlanningTask {
            state: State::at_rest([0.0; 3]),
            goal: [0.6, -0.5, 0.7],
            grasp: [-0.6, 0.0],
            arm: Default::default(),
        }
    }

    fn planner(curiosity: f64) -> Planner {
        let mut settings = Settings::within([-100.0, -100.0, -40.0], [100.0, 100.0, 40.0]);
        settings.curiosity = curiosity;
        Planner::new(settings, 0).unwrap()
    }

    #[test]
    fn regret_is_positive_for_different_models_and_zero_for_equal_ones() {
        let planner = planner(0.0);
        let regret = |models: &[Plant<f64>]| planner.regret(models, &task(), &ObstacleMap::empty()).unwrap();
        let (left, right) = (table(0.5, 0.3), table(0.5, -0.3));
        assert!(regret(&[left.clone(), right]) > 0.02);
        assert!(regret(&[left.clone(), left]) < 1e-3);
    }

    #[test]
    fn a_limit_on_rollouts_keeps_the_regret_of_different_models() {
        let settings = Settings { rollouts: Some(600), ..planner(0.0).settings().clone() };
        let limited = Planner::new(settings, 0).unwrap();
        let regret = |models: &[Plant<f64>]| limited.regret(models, &task(), &ObstacleMap::empty()).unwrap();
        let (left, right) = (table(0.5, 0.3), table(0.5, -0.3));
        assert!(regret(&[left.clone(), right]) > 0.02);
        assert!(regret(&[left.clone(), left]) < 1e-3);
    }

    #[test]
    fn regret_ignores_curiosity_and_does_not_change_the_plan() {
        let models = [table(0.5, 0.3), table(0.5, -0.3)];
        let [mut evaluated, mut other] = [planner(3.0), planner(3.0)];
        let regret = evaluated.regret(&models, &task(), &ObstacleMap::empty()).unwrap();
        assert_eq!(regret, planner(0.0).regret(&models, &task(), &ObstacleMap::empty()).unwrap());
        let plan = |p: &mut Planner| p.plan(&models, &task(), &ObstacleMap::empty()).unwrap().to_vec();
        assert_eq!(plan(&mut evaluated), plan(&mut other));
    }

    /// Distance between the end positions of two models under their common plan, m.
    fn end_distance(curiosity: f64) -> f64 {
        let models = [table(0.5, 0.3), table(0.4, 0.2)];
        let mut planner = planner(curiosity);
        let plan = planner.plan(&models, &task(), &ObstacleMap::empty()).unwrap().to_vec();
        let ends = models.map(|model| {
            let mut state = task().state;
            for action in &plan {
                let applied = trundle_model::transport(*action, [-0.6, 0.0, 0.0]);
                let clock = trundle_model::Clock::since_contact(0.0);
                state = model.step(&state, applied, clock, planner.settings().hold);
            }
            state.pose
        });
        (ends[0][0] - ends[1][0]).hypot(ends[0][1] - ends[1][1])
    }

    #[test]
    fn curiosity_increases_the_difference_between_models() {
        assert!(end_distance(5.0) > 1.3 * end_distance(0.0), "{} {}", end_distance(5.0), end_distance(0.0));
    }

    #[test]
    fn curiosity_cannot_be_negative() {
        let error = planner(0.0).set_curiosity(-1.0).unwrap_err();
        assert!(error.to_string().contains("curiosity"), "{error}");
    }
}
