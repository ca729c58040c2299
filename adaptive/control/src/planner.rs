//! Model predictive path integral control (MPPI): Williams et al., "Information theoretic MPC for
//! model-based reinforcement learning", ICRA 2017.
//!
//! Plans are drawn around the last one, rolled out on the model, and averaged with weights
//! `exp(−cost/λ)`. Beyond the publication: λ follows the spread of the costs, so that one setting serves
//! far from the goal and near it; deviations are correlated in time; each call iterates with shrinking
//! spread.

use rayon::prelude::*;
use trundle_model::{Clock, Plant, State, transport};

use crate::sampling::{average, draw};
use crate::{ControlError, Settings, Task};

/// Longest step of a rollout, s.
const LONGEST_STEP: f64 = 0.05;
/// By how much the spread shrinks from one iteration to the next.
const SHRINK: f64 = 0.5;

/// Plans pushes, each plan warm-started from the one before.
#[derive(Clone, Debug)]
pub struct Planner {
    settings: Settings,
    seed: u64,
    round: u32,
    /// The plan so far, wrenches at the grasp.
    mean: Vec<[f64; 3]>,
    /// Sampled plans, one after the other, and what they cost.
    plans: Vec<[f64; 3]>,
    costs: Vec<f64>,
}

impl Planner {
    /// A planner without a plan yet. The same seed and calls give the same plans, on any number of threads.
    ///
    /// # Errors
    /// When a setting makes no sense.
    pub fn new(settings: Settings, seed: u64) -> Result<Self, ControlError> {
        settings.check()?;
        let (horizon, samples) = (settings.horizon, settings.samples);
        let rest = settings.clamp([0.0; 3]);
        Ok(Self {
            seed,
            round: 0,
            mean: vec![rest; horizon],
            plans: vec![rest; horizon * samples],
            costs: vec![0.0; samples],
            settings,
        })
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Improve the plan for a task. Returns the actions, each to be held for [`Settings::hold`]: wrenches
    /// at the grasp, object axes, `[N, N, N·m]`.
    ///
    /// # Errors
    /// When a number of the task is not finite, or no sampled plan keeps the motion finite.
    pub fn plan(&mut self, plant: &Plant<f64>, task: &Task) -> Result<&[[f64; 3]], ControlError> {
        task.check()?;
        let mut scale = 1.0;
        for _ in 0..self.settings.iterations {
            self.sample(plant, task, scale);
            if !self.costs.iter().any(|cost| cost.is_finite()) {
                return Err(ControlError::Diverged { samples: self.settings.samples });
            }
            average(&self.plans, &self.costs, self.settings.temperature, &mut self.mean);
            self.round = self.round.wrapping_add(1);
            scale *= SHRINK;
        }
        Ok(&self.mean)
    }

    /// Move the plan on by `seconds`; its last action is held beyond its end.
    ///
    /// # Errors
    /// When the time is negative or not finite.
    pub fn advance(&mut self, seconds: f64) -> Result<(), ControlError> {
        if !(seconds.is_finite() && seconds >= 0.0) {
            return Err(ControlError::value("seconds", seconds, "must be finite and not negative"));
        }
        let whole = (seconds / self.settings.hold).floor();
        let part = seconds / self.settings.hold - whole;
        let last = self.mean.len() - 1;
        let at = |k: usize| (k.saturating_add(whole as usize)).min(last);
        for k in 0..=last {
            let (now, next) = (self.mean[at(k)], self.mean[at(k + 1)]);
            self.mean[k] = [0, 1, 2].map(|i| (1.0 - part) * now[i] + part * next[i]);
        }
        Ok(())
    }

    /// Forget the plan, and start the draws again.
    pub fn restart(&mut self) {
        self.mean.fill(self.settings.clamp([0.0; 3]));
        self.round = 0;
    }

    /// Draw plans and roll them out; the first is the mean itself.
    fn sample(&mut self, plant: &Plant<f64>, task: &Task, scale: f64) {
        let Self { settings, seed, round, mean, plans, costs } = self;
        plans.par_chunks_exact_mut(settings.horizon).zip(costs).enumerate().for_each(
            |(number, (plan, cost))| {
                match number {
                    0 => plan.copy_from_slice(mean),
                    _ => draw(settings, scale, mean, *seed, (*round, number as u32), plan),
                }
                *cost = rollout(settings, plant, task, plan);
            },
        );
    }
}

/// What a plan costs; infinite where the motion is not finite.
fn rollout(settings: &Settings, plant: &Plant<f64>, task: &Task, plan: &[[f64; 3]]) -> f64 {
    let steps = (settings.hold / LONGEST_STEP).ceil();
    let dt = settings.hold / steps;
    let [x, y] = task.grasp;
    let reach = settings.reach();
    let mut state: State<f64> = task.state;
    let mut clock = Clock::since_contact(0.0);
    let mut sum = 0.0;
    for action in plan {
        let applied = transport(*action, [x, y, 0.0]);
        let share = [0, 1, 2].map(|k| action[k] / reach[k]);
        for _ in 0..steps as usize {
            state = plant.step(&state, applied, clock, dt);
            clock.since_contact += dt;
            sum += dt * settings.cost.running(&state, &task.goal, share);
        }
    }
    let total = sum + settings.cost.terminal(&state, &task.goal);
    if total.is_finite() { total } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_model::{Body, Effect, Kind, Model};

    fn table(mu: f64) -> Plant<f64> {
        let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
        let wheel = [0.5, 0.3, 0.4, mu, mu].map(Some).to_vec();
        let effects = vec![Effect { kind: Kind::ViscousWheel, values: wheel }];
        let body = Body::from_footprint(&corners, 22.0).unwrap();
        Model { body, mass: Some(22.0), dof: [true; 3], effects, priors: Default::default(), unnamed: None }
            .resolved()
            .unwrap()
    }

    fn settings() -> Settings {
        Settings::within([-100.0, -100.0, -40.0], [100.0, 100.0, 40.0])
    }

    fn task() -> Task {
        Task { state: State::at_rest([0.0; 3]), goal: [0.6, -0.5, 0.7], grasp: [-0.6, 0.0] }
    }

    /// Drive the plant for `seconds` with a plan made anew every 50 ms.
    fn driven(seconds: f64) -> State<f64> {
        let plant = table(150.0);
        let mut planner = Planner::new(settings(), 0).unwrap();
        let mut task = task();
        for _ in 0..(seconds / 0.05) as usize {
            let action = planner.plan(&plant, &task).unwrap()[0];
            let applied = transport(action, [task.grasp[0], task.grasp[1], 0.0]);
            task.state = plant.step(&task.state, applied, Clock::since_contact(0.0), 0.05);
            planner.advance(0.05).unwrap();
        }
        task.state
    }

    #[test]
    fn replanned_pushes_bring_a_table_to_its_goal_and_stop_there() {
        let State { pose, twist, .. } = driven(5.0);
        let [x, y, theta] = task().goal;
        assert!((pose[0] - x).hypot(pose[1] - y) < 0.02, "{pose:?}");
        assert!((pose[2] - theta).abs() < 0.04, "{pose:?}");
        assert!(twist[0].hypot(twist[1]) < 0.05, "{twist:?}");
    }

    #[test]
    fn plans_do_not_depend_on_the_number_of_threads() {
        let plans = [1, 4].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut planner = Planner::new(settings(), 7).unwrap();
            pool.install(|| planner.plan(&table(100.0), &task()).unwrap().to_vec())
        });
        assert_eq!(plans[0], plans[1]);
    }

    #[test]
    fn a_warm_start_costs_less_than_a_cold_one() {
        let (plant, task) = (table(100.0), task());
        let mut planner = Planner::new(settings(), 0).unwrap();
        let first = planner.plan(&plant, &task).unwrap().to_vec();
        let second = planner.plan(&plant, &task).unwrap().to_vec();
        let cost = |plan: &[[f64; 3]]| rollout(&settings(), &plant, &task, plan);
        assert!(cost(&second) < cost(&first), "{} {}", cost(&second), cost(&first));
        planner.restart();
        assert_eq!(planner.plan(&plant, &task).unwrap(), first);
    }

    #[test]
    fn advancing_by_half_an_action_blends_neighbours() {
        let mut planner = Planner::new(Settings { horizon: 3, ..settings() }, 0).unwrap();
        planner.mean = vec![[0.0; 3], [2.0; 3], [6.0; 3]];
        planner.advance(0.05).unwrap();
        assert_eq!(planner.mean, [[1.0; 3], [4.0; 3], [6.0; 3]]);
        planner.advance(1e300).unwrap();
        assert_eq!(planner.mean, [[6.0; 3]; 3]);
        assert!(planner.advance(f64::NAN).unwrap_err().to_string().starts_with("seconds = NaN"));
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let refused = |settings| Planner::new(settings, 0).unwrap_err().to_string();
        assert!(
            refused(Settings { horizon: 0, ..settings() }).starts_with("horizon = 0: must be at least 1")
        );
        assert!(refused(Settings { lower: [200.0; 3], ..settings() }).contains("below its upper bound"));
        assert!(refused(Settings { hold: f64::NAN, ..settings() }).starts_with("hold = NaN"));
        assert!(refused(Settings { smoothness: 1.0, ..settings() }).starts_with("smoothness"));
        let cost = crate::Cost { heading: -1.0, ..Default::default() };
        assert!(refused(Settings { cost, ..settings() }).starts_with("cost.heading = -1.0"));
        let lost = Task { goal: [f64::NAN, 0.0, 0.0], ..task() };
        let mut planner = Planner::new(settings(), 0).unwrap();
        assert!(planner.plan(&table(1.0), &lost).unwrap_err().to_string().starts_with("goal = [NaN"));
    }

    #[test]
    fn a_motion_that_runs_away_is_an_error() {
        let far = Task { state: State::moving([0.0; 3], [1e308; 3]), ..task() };
        let mut planner = Planner::new(settings(), 0).unwrap();
        assert_eq!(planner.plan(&table(1.0), &far), Err(ControlError::Diverged { samples: 256 }));
    }
}
