//! What a plan comes to: rolled out on several models, it costs what it does on average, less what it tells.

use trundle_model::{Clock, LinearPropagator, State, transport};

use crate::dynamics::Anchor;
use crate::{Dynamics, Room, Settings, Task};

/// Longest step of a rollout, s.
const LONGEST_STEP: f64 = 0.05;

/// A model, with its step solved beforehand where that can be.
pub(crate) struct Motion<'a, D> {
    model: &'a D,
    propagator: Option<LinearPropagator>,
    anchor: Anchor,
}

impl<D: Dynamics> Motion<'_, D> {
    #[inline]
    fn step(&self, state: &mut State<f64>, applied: &[f64; 3], clock: Clock, dt: f64) {
        match &self.propagator {
            Some(propagator) => propagator.step_in_place(state, applied),
            None => self.model.step(state, applied, clock, dt),
        }
    }
}

/// How many steps an action takes, and their length, s.
fn steps(settings: &Settings) -> (usize, f64) {
    let count = (settings.hold / LONGEST_STEP).ceil();
    (count as usize, settings.hold / count)
}

/// Models as plans are rolled out on them.
pub(crate) fn motions<'a, D: Dynamics>(settings: &Settings, models: &'a [D]) -> Vec<Motion<'a, D>> {
    let (_, dt) = steps(settings);
    models
        .iter()
        .map(|model| Motion { model, propagator: model.linear_propagator(dt), anchor: model.anchor() })
        .collect()
}

/// What a plan costs on average, less what it tells; infinite where a motion is not finite.
pub(crate) fn rollouts<D: Dynamics>(
    settings: &Settings,
    motions: &[Motion<'_, D>],
    task: &Task,
    room: &Room,
    plan: &[[f64; 3]],
) -> f64 {
    let (mut sum, mut ends) = (0.0, Ends::default());
    for motion in motions {
        let (cost, end) = rollout(settings, motion, task, room, plan);
        sum += cost;
        ends.add(end);
    }
    let cost = sum / motions.len() as f64;
    if settings.curiosity == 0.0 {
        return cost;
    }
    cost - settings.curiosity * ends.spread(settings.cost.heading).min(MOST_TOLD)
}

/// Ends farther apart than this, m, are told apart anyway.
const MOST_TOLD: f64 = 0.3;

/// Where several models end, summed up.
#[derive(Default)]
struct Ends {
    count: f64,
    sum: [f64; 3],
    squares: [f64; 3],
}

impl Ends {
    fn add(&mut self, end: [f64; 3]) {
        self.count += 1.0;
        self.sum = [0, 1, 2].map(|k| self.sum[k] + end[k]);
        self.squares = [0, 1, 2].map(|k| self.squares[k] + end[k] * end[k]);
    }

    /// Standard deviation, m, with radians at `heading` metres each.
    fn spread(&self, heading: f64) -> f64 {
        let variance = |k: usize| (self.squares[k] - self.sum[k] * self.sum[k] / self.count) / self.count;
        let [x, y, theta] = [0, 1, 2].map(|k| variance(k).max(0.0));
        (x + y + heading * heading * theta).sqrt()
    }
}

/// What a plan costs on one model, and the pose at its end.
fn rollout<D: Dynamics>(
    settings: &Settings,
    motion: &Motion<'_, D>,
    task: &Task,
    room: &Room,
    plan: &[[f64; 3]],
) -> (f64, [f64; 3]) {
    let (steps, dt) = steps(settings);
    let [x, y] = task.grasp;
    let reach = settings.reach();
    let mut state: State<f64> = task.state;
    let mut clock = Clock::since_contact(0.0);
    let mut sum = 0.0;
    for action in plan {
        let applied = transport(*action, [x, y, 0.0]);
        let share = [0, 1, 2].map(|k| action[k] / reach[k]);
        for _ in 0..steps {
            motion.step(&mut state, &applied, clock, dt);
            clock.since_contact += dt;
            sum += dt * settings.cost.running(&state, &task.goal, room, share);
        }
    }
    let force = reach[0].min(reach[1]);
    let held = settings.cost.held(&state, &task.goal, &motion.anchor, force);
    let total = sum + settings.cost.terminal(&state, &task.goal, room) + held;
    (if total.is_finite() { total } else { f64::INFINITY }, state.pose)
}
