//! Model predictive path integral control (MPPI): Williams et al., "Information theoretic MPC for model-based
//! reinforcement learning", ICRA 2017.
//!
//! The planner samples plans around the previous plan, rolls them out on the model, and averages them with the weights
//! `exp(−cost/λ)`. Differences from the publication:
//!
//! - λ is proportional to the spread of the costs, so one setting works far from the goal and near it.
//! - Deviations are correlated in time.
//! - Each call runs several iterations with decreasing spread.
//! - Each plan is rolled out on several models, for example posterior samples. Its cost is the mean over them, minus a
//!   bonus for discriminating between them.

use rayon::prelude::*;

use crate::effort::Effort;
use crate::rollout::{RolloutModel, batch_costs, plan_cost, rollout_models};
use crate::sampling::{draw_plan, weighted_average};
use crate::{BatchError, ControlError, Dynamics, ObstacleMap, PlanningTask, Settings};

/// MPPI planner. Each plan starts from the previous one.
#[derive(Clone, Debug)]
pub struct Planner {
    settings: Settings,
    seed: u64,
    round: u32,
    /// Current plan: wrenches at the grasp.
    mean: Vec<[f64; 3]>,
    /// Sampled plans, concatenated, and their costs.
    plans: Vec<[f64; 3]>,
    costs: Vec<f64>,
}

impl Planner {
    /// Create a planner. The same seed and calls give the same plans on any number of threads.
    ///
    /// # Errors
    /// If a setting is out of range.
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

    /// Improve the plan for a task, on one or several equally probable models. Returns the actions, each of duration
    /// [`Settings::hold`]: wrenches at the grasp, object axes, `[N, N, N·m]`.
    ///
    /// # Errors
    /// If there is no model, a number of the task is not finite, or all sampled plans diverge.
    pub fn plan<D: Dynamics>(
        &mut self,
        models: &[D],
        task: &PlanningTask,
        obstacle_map: &ObstacleMap,
    ) -> Result<&[[f64; 3]], ControlError> {
        task.check()?;
        if models.is_empty() {
            return Err(ControlError::value("models", 0, "give at least one"));
        }
        let prepared = rollout_models(&self.settings, models, task);
        let mut scale = 1.0;
        let Effort { iterations, plans, decay } = Effort::of(&self.settings, models.len());
        for _ in 0..iterations {
            self.sample(plans, &prepared, task, obstacle_map, scale);
            self.average(plans)?;
            scale *= decay;
        }
        Ok(&self.mean)
    }

    /// Improve the plan for a task with rollouts of a simulator that takes all plans of an iteration at once, such as a
    /// neural network. Samples, costs and averages are those of [`Planner::plan`] on one model without an arm.
    ///
    /// `simulate` receives the plans, one after the other, and returns one or several motions per plan: all motions of the
    /// first prediction, then those of the next one. A motion contains the state (pose and twist, world axes) at the end of
    /// each of [`Settings::substeps`] steps of each action. The cost of a plan is its mean over the predictions.
    ///
    /// # Errors
    /// If a number of the task is not finite, the number of states does not fit the plans, all motions diverge, or
    /// `simulate` fails.
    pub fn plan_in_batches<E>(
        &mut self,
        task: &PlanningTask,
        obstacle_map: &ObstacleMap,
        mut simulate: impl FnMut(&[[f64; 3]]) -> Result<Vec<[f64; 6]>, E>,
    ) -> Result<&[[f64; 3]], BatchError<E>> {
        task.check()?;
        let mut scale = 1.0;
        let Effort { iterations, plans, decay } = Effort::of(&self.settings, 1);
        for _ in 0..iterations {
            self.draw(plans, scale);
            let drawn = &self.plans[..plans * self.settings.horizon];
            let states = simulate(drawn).map_err(BatchError::Simulator)?;
            batch_costs(&self.settings, task, obstacle_map, drawn, &states, &mut self.costs[..plans])?;
            self.average(plans)?;
            scale *= decay;
        }
        Ok(&self.mean)
    }

    /// Shift the plan by `seconds`. Its last action is repeated at the end.
    ///
    /// # Errors
    /// If the time is negative or not finite.
    pub fn advance(&mut self, seconds: f64) -> Result<(), ControlError> {
        if !(seconds.is_finite() && seconds >= 0.0) {
            return Err(ControlError::value("seconds", seconds, "must be finite and not negative"));
        }
        let whole_actions = (seconds / self.settings.hold).floor();
        let fraction = seconds / self.settings.hold - whole_actions;
        let last = self.mean.len() - 1;
        let at = |k: usize| (k.saturating_add(whole_actions as usize)).min(last);
        for k in 0..=last {
            let (now, next) = (self.mean[at(k)], self.mean[at(k + 1)]);
            self.mean[k] = [0, 1, 2].map(|i| (1.0 - fraction) * now[i] + fraction * next[i]);
        }
        Ok(())
    }

    /// Reset the plan and the random numbers.
    pub fn restart(&mut self) {
        self.mean.fill(self.settings.clamp([0.0; 3]));
        self.round = 0;
    }

    /// Cost of the current plan.
    pub fn cost<D: Dynamics>(&self, models: &[D], task: &PlanningTask, obstacle_map: &ObstacleMap) -> f64 {
        plan_cost(
            &self.settings,
            &rollout_models(&self.settings, models, task),
            task,
            obstacle_map,
            &self.mean,
        )
    }

    /// Replace the settings. Horizon and number of samples must stay the same.
    pub(crate) fn set_settings(&mut self, settings: Settings) {
        self.settings = settings;
    }

    /// Set [`Settings::curiosity`].
    ///
    /// # Errors
    /// If it is negative or not finite.
    pub fn set_curiosity(&mut self, curiosity: f64) -> Result<(), ControlError> {
        let settings = Settings { curiosity, ..self.settings.clone() };
        settings.check()?;
        self.set_settings(settings);
        Ok(())
    }

    /// Seed of the random numbers.
    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }

    /// Replace the mean by the weighted average of the first `count` plans.
    fn average(&mut self, count: usize) -> Result<(), ControlError> {
        let costs = &self.costs[..count];
        if !costs.iter().any(|cost| cost.is_finite()) {
            return Err(ControlError::Diverged { samples: count });
        }
        weighted_average(&self.plans, costs, self.settings.temperature, &mut self.mean);
        self.round = self.round.wrapping_add(1);
        Ok(())
    }

    /// Sample the first `count` plans. The first plan is the mean itself.
    fn draw(&mut self, count: usize, scale: f64) {
        let Self { settings, seed, round, mean, plans, .. } = self;
        plans.par_chunks_exact_mut(settings.horizon).take(count).enumerate().for_each(|(number, plan)| {
            match number {
                0 => plan.copy_from_slice(mean),
                _ => draw_plan(settings, scale, mean, *seed, (*round, number as u32), plan),
            }
        });
    }

    /// Sample the first `count` plans and compute their costs.
    fn sample<D: Dynamics>(
        &mut self,
        count: usize,
        prepared: &[RolloutModel<'_, D>],
        task: &PlanningTask,
        obstacle_map: &ObstacleMap,
        scale: f64,
    ) {
        self.draw(count, scale);
        let Self { settings, plans, costs, .. } = self;
        plans.par_chunks_exact(settings.horizon).zip(&mut costs[..count]).for_each(|(plan, cost)| {
            *cost = plan_cost(settings, prepared, task, obstacle_map, plan);
        });
    }
}

#[cfg(test)]
mod tests;
