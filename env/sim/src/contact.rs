//! Rollouts of an object that may touch known obstacles: the engine behind the laws' own stepper.

use crate::{Mover, SimError};
use trundle_model::{Body, Fixture, Model, ModelInstance, State, StepError, StepInput, Stepper};

/// The engine takes over when the object could come this near to an obstacle in a step, m.
pub(crate) const MARGIN: f64 = 0.02;

/// Simulates an object among fixed obstacles, as [`Mover`] does.
#[derive(Clone, Debug)]
pub struct Obstructed {
    obstacles: Vec<Vec<[f64; 2]>>,
}

impl Obstructed {
    /// Among simple polygons, m, world frame.
    ///
    /// # Errors
    /// When one is no simple polygon, or the object has no shape to touch with.
    pub fn new(model: &Model, obstacles: Vec<Vec<[f64; 2]>>) -> Result<Self, SimError> {
        for (index, polygon) in obstacles.iter().enumerate() {
            crate::object::obstacle(polygon, index)?;
        }
        crate::object::hull(&model.body)?;
        Ok(Self { obstacles })
    }
}

impl Stepper for Obstructed {
    fn rollout(
        &self,
        at: &ModelInstance<'_>,
        start: &State<f64>,
        inputs: &[StepInput],
    ) -> Result<Vec<State<f64>>, StepError> {
        let failed = |step: usize| move |e: SimError| StepError { step, reason: e.to_string() };
        let model = at.model.with_values(at.values).map_err(|e| failed(0)(e.into()))?;
        let mut mover = Mover::new(model, self.obstacles.clone()).map_err(failed(0))?;
        mover.put(*start);
        let mut states = Vec::with_capacity(inputs.len());
        for (index, drive) in inputs.iter().enumerate() {
            mover.step(drive.applied, drive.clock, drive.dt).map_err(failed(index))?;
            states.push(*mover.state());
        }
        Ok(states)
    }
}

/// Whether an object comes so near to an obstacle, at one of its poses, that it may touch it.
pub fn can_touch(
    body: &Body,
    obstacles: &[Vec<[f64; 2]>],
    mut poses: impl Iterator<Item = [f64; 3]>,
) -> bool {
    let radius = reach(body);
    !obstacles.is_empty() && poses.any(|pose| nearest(obstacles, pose) < radius + MARGIN)
}

/// Distance from an object's origin to the nearest obstacle, 0 within one, m.
pub(crate) fn nearest(obstacles: &[Vec<[f64; 2]>], [x, y, _]: [f64; 3]) -> f64 {
    obstacles.iter().map(|polygon| distance(polygon, [x, y])).fold(f64::INFINITY, f64::min)
}

/// Distance of the outline's farthest point from the object's origin, m.
pub(crate) fn reach(body: &Body) -> f64 {
    let of = |fixture: &Fixture| match fixture {
        Fixture::Polygon { vertices, .. } => vertices.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max),
        Fixture::Disc { center: [x, y], radius, .. } => x.hypot(*y) + radius,
    };
    body.fixtures.iter().map(of).fold(0.0, f64::max)
}

fn distance(polygon: &[[f64; 2]], point: [f64; 2]) -> f64 {
    let edges = || polygon.iter().zip(polygon.iter().cycle().skip(1));
    let crosses = |(a, b): (&[f64; 2], &[f64; 2])| {
        (a[1] > point[1]) != (b[1] > point[1])
            && point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    if edges().filter(|&edge| crosses(edge)).count() % 2 == 1 {
        return 0.0;
    }
    edges().map(|(a, b)| to_edge(*a, *b, point)).fold(f64::INFINITY, f64::min)
}

fn to_edge(a: [f64; 2], b: [f64; 2], point: [f64; 2]) -> f64 {
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

    /// Wound up once.
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
        let stepper = Obstructed::new(&model, vec![obstacle]).unwrap();
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
    fn the_engine_that_touches_nothing_moves_it_as_the_laws_do() {
        // A wall beside its way, within reach: the engine carries the object all the time.
        let inputs = push([6.0, 0.0, 0.1], 1.0);
        let beside = vec![[-3.0, 0.47], [3.0, 0.47], [3.0, 0.6], [-3.0, 0.6]];
        let (laws, engine) = (last(wall(100.0), &inputs), last(beside, &inputs));
        assert!(laws.pose[0] > 0.1 && off(&laws, &engine) < 2e-4, "{laws:?} {engine:?}");
        assert!(off(&laws, &engine) > 0.0, "the engine was not asked");
    }

    #[test]
    fn a_wall_stops_it() {
        let inputs = push([40.0, 0.0, 0.0], 3.0);
        let (free, stopped) = (last(wall(100.0), &inputs), last(wall(0.9), &inputs));
        assert!(free.pose[0].hypot(free.pose[1]) > 1.0, "{free:?}");
        assert!(stopped.pose[0] < 0.62 && stopped.twist[0].abs() < 0.05, "{stopped:?}");
        assert!((stopped.pose[2] - TURN).abs() < 1.0, "the heading stays wound up: {stopped:?}");
    }

    #[test]
    fn distances_are_to_the_outline_and_zero_within() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(distance(&square, [0.5, 0.5]), 0.0);
        assert!((distance(&square, [1.5, 0.5]) - 0.5).abs() < 1e-12);
        assert!((distance(&square, [2.0, 2.0]) - 2f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn an_obstacle_that_crosses_itself_is_refused() {
        let bow = vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert!(Obstructed::new(&table(), vec![bow]).unwrap_err().to_string().contains("obstacle 1"));
    }
}
