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

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_model::{Body, Effect, Kind, Model, Plant, State};

    /// A table whose wheel at a corner is locked.
    fn table(x: f64, y: f64) -> Plant<f64> {
        let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
        let wheel = [x, y, 0.4, 200.0, 200.0].map(Some).to_vec();
        let body = Body::from_footprint(&corners, 22.0).unwrap();
        let mut model = Model::nominal(body, Some(22.0), [true; 3]);
        model.effects = vec![Effect { kind: Kind::ViscousWheel, values: wheel }];
        model.resolved().unwrap()
    }

    fn task() -> Task {
        Task { state: State::at_rest([0.0; 3]), goal: [0.6, -0.5, 0.7], grasp: [-0.6, 0.0] }
    }

    fn planner(curiosity: f64) -> Planner {
        let mut settings = Settings::within([-100.0, -100.0, -40.0], [100.0, 100.0, 40.0]);
        settings.curiosity = curiosity;
        Planner::new(settings, 0).unwrap()
    }

    #[test]
    fn the_truth_is_worth_something_where_models_differ_and_nothing_where_they_do_not() {
        let planner = planner(0.0);
        let regret = |models: &[Plant<f64>]| planner.regret(models, &task(), &Room::open()).unwrap();
        let (left, right) = (table(0.5, 0.3), table(0.5, -0.3));
        assert!(regret(&[left.clone(), right]) > 0.02);
        assert!(regret(&[left.clone(), left]) < 1e-3);
    }

    #[test]
    fn asking_for_the_worth_changes_no_plan_and_knows_no_curiosity() {
        let models = [table(0.5, 0.3), table(0.5, -0.3)];
        let [mut asked, mut not] = [planner(3.0), planner(3.0)];
        let worth = asked.regret(&models, &task(), &Room::open()).unwrap();
        assert_eq!(worth, planner(0.0).regret(&models, &task(), &Room::open()).unwrap());
        let plan = |p: &mut Planner| p.plan(&models, &task(), &Room::open()).unwrap().to_vec();
        assert_eq!(plan(&mut asked), plan(&mut not));
    }

    /// How far apart two models end under the plan for both, m.
    fn told(curiosity: f64) -> f64 {
        let models = [table(0.5, 0.3), table(0.4, 0.2)];
        let mut planner = planner(curiosity);
        let plan = planner.plan(&models, &task(), &Room::open()).unwrap().to_vec();
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
    fn a_curious_plan_tells_models_apart() {
        assert!(told(5.0) > 1.3 * told(0.0), "{} {}", told(5.0), told(0.0));
    }

    #[test]
    fn curiosity_cannot_be_negative() {
        let error = planner(0.0).be_curious(-1.0).unwrap_err();
        assert!(error.to_string().contains("curiosity"), "{error}");
    }
}
