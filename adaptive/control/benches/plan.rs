//! Time of replanning: 1,000 plans of 20 steps with and without obstacles, single-threaded.

use criterion::{Criterion, criterion_group, criterion_main};
use trundle_control::{ObstacleMap, Planner, PlanningTask, Settings};
use trundle_model::{Body, Effect, Kind, Model, Plant, State};

const TABLE: [[f64; 2]; 4] = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];

fn table(effects: Vec<Effect>) -> Option<(Body, Plant<f64>)> {
    let body = Body::from_footprint(&TABLE, 22.0).ok()?;
    let mut model = Model::nominal(body.clone(), Some(22.0), [true; 3]);
    model.effects = effects;
    Some((body, model.resolved().ok()?))
}

fn plan(c: &mut Criterion) {
    let wheel =
        Effect { kind: Kind::ViscousWheel, values: [-0.5, 0.3, 0.3, 180.0, 320.0].map(Some).to_vec() };
    let values = [("x", 0.5), ("y", -0.3), ("force", 14.0)];
    let dry = values.iter().fold(Effect::free(Kind::CoulombFriction), |e, (k, v)| e.with(k, Some(*v)));
    let walls = vec![
        vec![[0.95, 0.55], [1.05, 0.55], [1.05, 5.0], [0.95, 5.0]],
        vec![[0.95, -5.0], [1.05, -5.0], [1.05, -0.55], [0.95, -0.55]],
    ];
    let goal = [2.0, 0.0, 0.0];
    for (name, effects, obstacles) in [
        ("wheel", vec![wheel.clone()], vec![]),
        ("wheel and dry friction", vec![wheel.clone(), dry], vec![]),
        ("wheel, at a doorway", vec![wheel], walls),
    ] {
        let Some((body, plant)) = table(effects) else { return };
        let mut settings = Settings::within([-100.0, -100.0, -40.0], [100.0, 100.0, 40.0]);
        (settings.samples, settings.horizon, settings.hold, settings.iterations) = (1000, 20, 0.05, 1);
        let (Ok(mut planner), Ok(obstacle_map)) =
            (Planner::new(settings, 0), ObstacleMap::new(&body, &obstacles, [goal, [0.0; 3]], 0.3))
        else {
            return;
        };
        let task = PlanningTask {
            state: State::at_rest([0.0; 3]),
            goal,
            grasp: [-0.6, 0.0],
            arm: Default::default(),
        };
        let plants = [plant];
        let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(1).build() else { return };
        c.bench_function(&format!("1000 plans of 20 steps, {name}"), |b| {
            pool.install(|| b.iter(|| planner.plan(&plants, &task, &obstacle_map).map(|plan| plan[0])));
        });
    }
}

criterion_group!(benches, plan);
criterion_main!(benches);
