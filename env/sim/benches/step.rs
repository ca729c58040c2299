//! What a step costs: the world's under a push, and the task's from action to observation.

use criterion::{Criterion, criterion_group, criterion_main};
use trundle_model::{Body, Clock, Effect, Kind, Model, State};
use trundle_sim::task::{Goal, Mode, Secret};
use trundle_sim::{Mover, Options, Pushing, Reset, World};

fn table() -> Result<Model, trundle_sim::SimError> {
    let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0)?;
    let values = [-0.5, 0.3, 0.3, 180.0, 320.0].map(Some).to_vec();
    let effects = vec![Effect { kind: Kind::ViscousWheel, values }];
    Ok(Model {
        body,
        mass: Some(22.0),
        dof: [true; 3],
        effects,
        priors: Default::default(),
        discrepancy: None,
    })
}

fn world(c: &mut Criterion) {
    let Ok(mut world) = table().and_then(|model| World::new(&model, &[], 2e-3)) else { return };
    let clock = Clock::since_contact(1.0);
    c.bench_function("engine step, free, 2 ms", |b| b.iter(|| world.step([3.0, -2.0, 0.1], clock)));
    for (name, wall) in [("laws alone", 50.0), ("at a wall", 0.61)] {
        let wall = vec![[wall, -3.0], [wall + 0.2, -3.0], [wall + 0.2, 3.0], [wall, 3.0]];
        let Ok(mut mover) = table().and_then(|model| Mover::new(model, vec![wall])) else { return };
        mover.prepare(2e-3);
        let mut tick = 0;
        c.bench_function(&format!("mover step, {name}, 2 ms"), |b| {
            b.iter(|| {
                tick += 1;
                if tick % 2000 == 0 {
                    mover.put(State::at_rest([0.0; 3]));
                }
                mover.step([30.0, -2.0, 0.1], clock, 2e-3)
            });
        });
    }
}

fn task(c: &mut Criterion) {
    for (name, task, action) in [
        ("pose, wrench", Goal::Pose, Mode::Wrench),
        ("pose, velocity", Goal::Pose, Mode::Velocity),
        ("door, wrench", Goal::Door, Mode::Wrench),
        ("pose, push of 1 s", Goal::Pose, Mode::Push),
        ("pose, regrasp", Goal::Pose, Mode::Regrasp),
    ] {
        let options = Options { task, action, hidden: Secret::Locked, ..Options::default() };
        let mut row = vec![0.0; options.entries()];
        let Ok(mut task) = Pushing::new(options) else { return };
        c.bench_function(&format!("task step, {name}"), |b| {
            b.iter(|| {
                if !task.ready() {
                    let _ = task.reset(Some(0), &Reset::default());
                }
                let outcome = task.step(&[0.2, -0.1, 0.05, 0.0, 0.0, -1.0]);
                task.observe(&mut row);
                outcome
            });
        });
    }
}

criterion_group!(benches, world, task);
criterion_main!(benches);
