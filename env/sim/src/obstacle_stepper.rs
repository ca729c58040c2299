//! Rollouts of an object among known obstacles.

use crate::{HybridStepper, SimError};
use trundle_model::{Model, ModelInstance, State, StepError, StepInput, Stepper};

/// A [`Stepper`] that simulates an object among fixed obstacles with [`HybridStepper`].
#[derive(Clone, Debug)]
pub struct ObstacleStepper {
    obstacles: Vec<Vec<[f64; 2]>>,
}

impl ObstacleStepper {
    /// A stepper among simple polygons, m, world frame.
    ///
    /// # Errors
    /// If an obstacle or a fixture of the object is not a simple polygon.
    pub fn new(model: &Model, obstacles: Vec<Vec<[f64; 2]>>) -> Result<Self, SimError> {
        for (index, polygon) in obstacles.iter().enumerate() {
            crate::colliders::obstacle_colliders(polygon, index)?;
        }
        crate::colliders::object_colliders(&model.body)?;
        Ok(Self { obstacles })
    }
}

impl Stepper for ObstacleStepper {
    fn rollout(
        &self,
        at: &ModelInstance<'_>,
        start: &State<f64>,
        inputs: &[StepInput],
    ) -> Result<Vec<State<f64>>, StepError> {
        let failed = |step: usize| move |e: SimError| StepError { step, reason: e.to_string() };
        let model = at.model.with_values(at.values).map_err(|e| failed(0)(e.into()))?;
        let mut stepper = HybridStepper::new(model, self.obstacles.clone()).map_err(failed(0))?;
        stepper.set_state(*start);
        let mut states = Vec::with_capacity(inputs.len());
        for (index, drive) in inputs.iter().enumerate() {
            stepper.step(drive.applied, drive.clock, drive.dt).map_err(failed(index))?;
            states.push(*stepper.state());
        }
        Ok(states)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_model::Body;
    use trundle_model::{Clock, Effect, Kind};

    fn table() -> Model {
        let body = Body::from_footprint(&[[-0.4, -0.3], [0.4, -0.3], [0.4, 0.3], [-0.4, 0.3]], 15.0).unwrap();
        let mut model = Model::nominal(body, Some(15.0), [true; 3]);
        model.effects =
            vec![Effect { kind: Kind::ViscousWheel, values: [0.02, 0.01, 0.3, 12.0, 20.0].map(Some).into() }];
        model
    }

    /// A heading of one full turn.
    const TURN: f64 = std::f64::consts::TAU;

    fn push(force: [f64; 3], seconds: f64) -> Vec<StepInput> {
        let count = (seconds / 0.008) as usize;
        let clock = |k: usize| Clock::since_contact(0.008 * k as f64);
        (0..count).map(|k| StepInput { applied: force, clock: clock(k), dt: 0.008 }).collect()
    }

    fn wall(x: f64) -> Vec<[f64; 2]> {
        vec![[x, -3.0], [x + 0.2, -3.0], [x + 0.2, 3.0], [x, 3.0]]
    }

    fn last(obstacle: Vec<[f64; 2]>, inputs: &[StepInput]) -> State<f64> {
        let model = table();
        let stepper = ObstacleStepper::new(&model, vec![obstacle]).unwrap();
        let values: Vec<f64> = model.slots().into_iter().map(|s| s.value.unwrap()).collect();
        let plant = model.plant(&values).unwrap();
        let at = ModelInstance { model: &model, values: &values, plant: &plant };
        let start = State::moving([0.0, 0.0, TURN], [0.1, 0.0, 0.2]);
        stepper.rollout(&at, &start, inputs).unwrap().pop().unwrap()
    }

    fn off(a: &State<f64>, b: &State<f64>) -> f64 {
        let pairs = a.pose.iter().chain(&a.twist).zip(b.pose.iter().chain(&b.twist));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn without_contact_engine_and_laws_agree() {
        // A wall along the path, in reach: the engine integrates every step.
        let inputs = push([6.0, 0.0, 0.1], 1.0);
        let side_wall = vec![[-3.0, 0.47], [3.0, 0.47], [3.0, 0.6], [-3.0, 0.6]];
        let (laws, engine) = (last(wall(100.0), &inputs), last(side_wall, &inputs));
        assert!(laws.pose[0] > 0.1 && off(&laws, &engine) < 2e-4, "{laws:?} {engine:?}");
        assert!(off(&laws, &engine) > 0.0, "the engine was not used");
    }

    #[test]
    fn a_wall_stops_the_object() {
        let inputs = push([40.0, 0.0, 0.0], 3.0);
        let (free, stopped) = (last(wall(100.0), &inputs), last(wall(0.9), &inputs));
        assert!(free.pose[0].hypot(free.pose[1]) > 1.0, "{free:?}");
        assert!(stopped.pose[0] < 0.62 && stopped.twist[0].abs() < 0.05, "{stopped:?}");
        assert!((stopped.pose[2] - TURN).abs() < 1.0, "the heading is not wrapped: {stopped:?}");
    }

    #[test]
    fn a_self_intersecting_obstacle_is_an_error() {
        let bow = vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert!(ObstacleStepper::new(&table(), vec![bow]).unwrap_err().to_string().contains("obstacle 1"));
    }
}
