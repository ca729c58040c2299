//! What a step costs: the world's under a push, and the task's from action to observation.

use criterion::{Criterion, criterion_group, criterion_main};
use trundle_model::{Body, Clock, Effect, Kind, Model};
use trundle_sim::{LockedWheel, Reset, World};

fn table() -> Result<Model, trundle_sim::SimError> {
    let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0)?;
    let values = [-0.5, 0.3, 0.3, 180.0, 320.0].map(Some).to_vec();
    let effects = vec![Effect { kind: Kind::ViscousWheel, values }];
    Ok(Model { body, mass: Some(22.0), dof: [true; 3], effects, priors: Default::default(), unnamed: None })
}

fn world(c: &mut Criterion) {
    let Ok(mut world) = table().and_then(|model| World::new(&model, &[], 2e-3)) else { return };
    let clock = Clock::since_contact(1.0);
    c.bench_function("world step, free, 2 ms", |b| b.iter(|| world.step([3.0, -2.0, 0.1], clock)));
}

fn task(c: &mut Criterion) {
    let Ok(mut task) = LockedWheel::new(1.0) else { return };
    c.bench_function("task step, 50 ms", |b| {
        b.iter(|| {
            if !task.ready() {
                let _ = task.reset(0, &Reset::default());
            }
            task.step([20.0, -10.0, 2.0])
        });
    });
}

criterion_group!(benches, world, task);
criterion_main!(benches);
