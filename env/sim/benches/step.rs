//! Time of a step of the world under a push, and of a task from action to observation.

use criterion::{Criterion, criterion_group, criterion_main};
use trundle_model::{Body, Clock, Effect, Kind, Model, State};
use trundle_sim::task::{ActionMode, HiddenKind, TaskKind};
use trundle_sim::{HybridStepper, Options, PushTask, ResetOptions, World};

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
        let Ok(mut stepper) = table().and_then(|model| HybridStepper::new(model, vec![wall])) else { return };
        stepper.precompute_step(2e-3);
        let mut tick = 0;
        c.bench_function(&format!("hybrid step, {name}, 2 ms"), |b| {
            b.iter(|| {
                tick += 1;
                if tick % 2000 == 0 {
                    stepper.set_state(State::at_rest([0.0; 3]));
                }
                stepper.step([30.0, -2.0, 0.1], clock, 2e-3)
            });
        });
    }
}

fn task(c: &mut Criterion) {
    for (name, task, action) in [
        ("pose, wrench", TaskKind::Pose, ActionMode::Wrench),
        ("pose, velocity", TaskKind::Pose, ActionMode::Velocity),
        ("door, wrench", TaskKind::Door, ActionMode::Wrench),
        ("pose, push of 1 s", TaskKind::Pose, ActionMode::Push),
        ("pose, regrasp", TaskKind::Pose, ActionMode::Regrasp),
    ] {
        let options = Options { task, action, hidden: HiddenKind::Locked, ..Options::default() };
        let mut row = vec![0.0; options.observation_len()];
        let Ok(mut task) = PushTask::new(options) else { return };
        c.bench_function(&format!("task step, {name}"), |b| {
            b.iter(|| {
                if !task.ready() {
                    let _ = task.reset(Some(0), &ResetOptions::default());
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
