//! Cost of a plan: its mean over rollouts on several models, minus a bonus for the difference between their end poses.

use rayon::prelude::*;
use trundle_model::{Clock, State, transport};

use crate::arm::{ArmStep, AxisStates};
use crate::dynamics::{Anchor, FastStep};
use crate::{ControlError, Cost, Dynamics, ObstacleMap, PlanningTask, Settings};

/// Largest step of a rollout, s.
const MAX_STEP_S: f64 = 0.05;

/// A model with its precomputed step, if there is one, and the start of all rollouts.
pub(crate) struct RolloutModel<'a, D> {
    model: &'a D,
    fast_step: Option<FastStep>,
    anchor: Anchor,
    /// State when the first action of a plan takes effect.
    start: State<f64>,
    /// Cost with the limits of speed for the delay of the arm.
    cost: Cost,
    /// Step of the arm and its state at the start; `None` if the wrench is the command.
    arm: Option<(ArmStep, AxisStates)>,
}

impl<D: Dynamics> RolloutModel<'_, D> {
    #[inline]
    fn step(&self, state: &mut State<f64>, applied: &[f64; 3], clock: Clock, dt: f64) {
        match &self.fast_step {
            Some(fast_step) => fast_step.step_in_place(state, applied),
            None => self.model.step(state, applied, clock, dt),
        }
    }
}

/// Number of steps of an action and their length, s.
fn substeps(settings: &Settings) -> (usize, f64) {
    let count = (settings.hold / MAX_STEP_S).ceil();
    (count as usize, settings.hold / count)
}

impl Settings {
    /// Number of steps of an action in rollouts.
    pub fn substeps(&self) -> usize {
        substeps(self).0
    }
}

/// Models prepared for the rollouts of a task.
pub(crate) fn rollout_models<'a, D: Dynamics>(
    settings: &Settings,
    models: &'a [D],
    task: &PlanningTask,
) -> Vec<RolloutModel<'a, D>> {
    let (_, dt) = substeps(settings);
    let response = task.arm.response();
    let prepared = |model: &'a D| {
        let mut start = task.state;
        let states = task.arm.predict(model, task.grasp, &mut start);
        let arm = response.has_dynamics().then(|| (response.discretised(dt), states));
        let cost = settings.cost.with_delay(response.delay);
        RolloutModel { model, fast_step: model.fast_step(dt), anchor: model.anchor(), start, cost, arm }
    };
    models.iter().map(prepared).collect()
}

/// Mean cost of a plan, minus the curiosity bonus. Infinite if a motion is not finite.
pub(crate) fn plan_cost<D: Dynamics>(
    settings: &Settings,
    rollout_models: &[RolloutModel<'_, D>],
    task: &PlanningTask,
    obstacle_map: &ObstacleMap,
    plan: &[[f64; 3]],
) -> f64 {
    let (mut sum, mut ends) = (0.0, EndPoses::default());
    for model in rollout_models {
        let (cost, end) = rollout(settings, model, task, obstacle_map, plan);
        sum += cost;
        ends.add(end);
    }
    let cost = sum / rollout_models.len() as f64;
    if settings.curiosity == 0.0 {
        return cost;
    }
    cost - settings.curiosity * ends.spread(settings.cost.heading).min(MAX_END_SPREAD_M)
}

/// Largest spread of end poses that earns a bonus, m. A larger spread is always distinguishable.
const MAX_END_SPREAD_M: f64 = 0.3;

/// Sums over the end poses of several models.
#[derive(Default)]
struct EndPoses {
    count: f64,
    sum: [f64; 3],
    squares: [f64; 3],
}

impl EndPoses {
    fn add(&mut self, end: [f64; 3]) {
        self.count += 1.0;
        self.sum = [0, 1, 2].map(|k| self.sum[k] + end[k]);
        self.squares = [0, 1, 2].map(|k| self.squares[k] + end[k] * end[k]);
    }

    /// Standard deviation, m. One radian counts as `heading` metres.
    fn spread(&self, heading: f64) -> f64 {
        let variance = |k: usize| (self.squares[k] - self.sum[k] * self.sum[k] / self.count) / self.count;
        let [x, y, theta] = [0, 1, 2].map(|k| variance(k).max(0.0));
        (x + y + heading * heading * theta).sqrt()
    }
}

/// Cost and end pose of a plan on one model.
fn rollout<D: Dynamics>(
    settings: &Settings,
    model: &RolloutModel<'_, D>,
    task: &PlanningTask,
    obstacle_map: &ObstacleMap,
    plan: &[[f64; 3]],
) -> (f64, [f64; 3]) {
    let (steps, dt) = substeps(settings);
    let [x, y] = task.grasp;
    let half_range = settings.half_range();
    let mut state: State<f64> = model.start;
    let mut arm = model.arm;
    let mut clock = Clock::since_contact(0.0);
    let mut sum = 0.0;
    for action in plan {
        let mut applied = transport(*action, [x, y, 0.0]);
        let share = [0, 1, 2].map(|k| action[k] / half_range[k]);
        for _ in 0..steps {
            if let Some((step, states)) = &mut arm {
                applied = transport(step.advance(states, *action), [x, y, 0.0]);
            }
            model.step(&mut state, &applied, clock, dt);
            clock.since_contact += dt;
            sum += dt * model.cost.running_cost(&state, &task.goal, obstacle_map, share);
        }
    }
    let force = half_range[0].min(half_range[1]);
    let anchor_cost = model.cost.anchor_cost(&state, &task.goal, &model.anchor, force);
    let total = sum + model.cost.terminal_cost(&state, &task.goal, obstacle_map) + anchor_cost;
    (if total.is_finite() { total } else { f64::INFINITY }, state.pose)
}

/// Costs of plans whose motions were predicted elsewhere: the mean over one or several predictions. `states` holds all motions
/// of the first prediction, then those of the next one.
///
/// # Errors
/// If the number of states does not fit the plans.
pub(crate) fn batch_costs(
    settings: &Settings,
    task: &PlanningTask,
    obstacle_map: &ObstacleMap,
    plans: &[[f64; 3]],
    states: &[[f64; 6]],
    costs: &mut [f64],
) -> Result<(), ControlError> {
    let steps = settings.horizon * settings.substeps();
    let expected = steps * costs.len();
    if states.is_empty() || !states.len().is_multiple_of(expected) {
        return Err(ControlError::States { given: states.len(), expected });
    }
    let predictions = (states.len() / expected) as f64;
    costs.par_iter_mut().zip(plans.par_chunks_exact(settings.horizon)).enumerate().for_each(
        |(number, (cost, plan))| {
            let motions = states.chunks_exact(expected).map(|all| &all[number * steps..(number + 1) * steps]);
            let sum: f64 =
                motions.map(|motion| motion_cost(settings, task, obstacle_map, plan, motion)).sum();
            *cost = if sum.is_finite() { sum / predictions } else { f64::INFINITY };
        },
    );
    Ok(())
}

/// Cost of a plan and its motion, as [`rollout`] computes it for a model without dry friction.
fn motion_cost(
    settings: &Settings,
    task: &PlanningTask,
    obstacle_map: &ObstacleMap,
    plan: &[[f64; 3]],
    motion: &[[f64; 6]],
) -> f64 {
    let (steps, dt) = substeps(settings);
    let half_range = settings.half_range();
    let mut state = task.state;
    let mut sum = 0.0;
    for (action, states) in plan.iter().zip(motion.chunks_exact(steps)) {
        let share = [0, 1, 2].map(|k| action[k] / half_range[k]);
        for &[x, y, theta, vx, vy, spin] in states {
            (state.pose, state.twist) = ([x, y, theta], [vx, vy, spin]);
            sum += dt * settings.cost.running_cost(&state, &task.goal, obstacle_map, share);
        }
    }
    sum + settings.cost.terminal_cost(&state, &task.goal, obstacle_map)
}
