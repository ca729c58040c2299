//! Rollouts of an object among known obstacles, and distances to obstacles.

use crate::{HybridStepper, SimError};
use trundle_model::{Body, Fixture, Model, ModelInstance, State, StepError, StepInput, Stepper};

/// Distance to an obstacle below which the engine takes over, m.
pub(crate) const ENGINE_MARGIN_M: f64 = 0.02;

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

/// Whether an object may touch an obstacle at one of the poses, by its bounding circle and a margin.
pub fn can_touch(
    body: &Body,
    obstacles: &[Vec<[f64; 2]>],
    mut poses: impl Iterator<Item = [f64; 3]>,
) -> bool {
    let radius = outline_radius(body);
    !obstacles.is_empty() && poses.any(|pose| obstacle_distance(obstacles, pose) < radius + ENGINE_MARGIN_M)
}

/// Distance from the object origin to the nearest obstacle, m; zero inside an obstacle.
pub(crate) fn obstacle_distance(obstacles: &[Vec<[f64; 2]>], [x, y, _]: [f64; 3]) -> f64 {
    obstacles.iter().map(|polygon| polygon_distance(polygon, [x, y])).fold(f64::INFINITY, f64::min)
}

/// Largest distance of the outline from the object origin, m.
pub(crate) fn outline_radius(body: &Body) -> f64 {
    let of = |fixture: &Fixture| match fixture {
        Fixture::Polygon { vertices, .. } => vertices.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max),
        Fixture::Disc { center: [x, y], radius, .. } => x.hypot(*y) + radius,
    };
    body.fixtures.iter().map(of).fold(0.0, f64::max)
}

fn polygon_distance(polygon: &[[f64; 2]], point: [f64; 2]) -> f64 {
    let edges = || polygon.iter().zip(polygon.iter().cycle().skip(1));
    let crosses = |(a, b): (&[f64; 2], &[f64; 2])| {
        (a[1] > point[1]) != (b[1] > point[1])
            && point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    if edges().filter(|&edge| crosses(edge)).count() % 2 == 1 {
        return 0.0;
    }
    edges().map(|(a, b)| edge_distance(*a, *b, point)).fold(f64::INFINITY, f64::min)
}

fn edge_distance(a: [f64; 2], b: [f64; 2], point: [f64; 2]) -> f64 {
    let (along, from) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let square = along[0] * along[0] + along[1] * along[1];
    let share = if square > 0.0 { (along[0] * from[0] + along[1] * from[1]) / square } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    (from[0] - share * along[0]).hypot(from[1] - share * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;
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
    fn distances_are_to_the_outline_and_zero_inside() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(polygon_distance(&square, [0.5, 0.5]), 0.0);
        assert!((polygon_distance(&square, [1.5, 0.5]) - 0.5).abs() < 1e-12);
        assert!((polygon_distance(&square, [2.0, 2.0]) - 2f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_self_intersecting_obstacle_is_an_error() {
        let bow = vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert!(ObstacleStepper::new(&table(), vec![bow]).unwrap_err().to_string().contains("obstacle 1"));
    }
}
