//! Memory of environments: stepping does not allocate.

#![allow(clippy::unwrap_used)]

use allocation_counter::measure;
use trundle_sim::task::{ActionMode, ArmOptions, HiddenKind, TaskKind, WristOptions};
use trundle_sim::{Options, PushTask, ResetOptions};

fn options(task: TaskKind, action: ActionMode) -> Options {
    Options { task, action, hidden: HiddenKind::Wheels, horizon: 0, ..Options::default() }
}

/// Number of allocations in `steps` steps after a warm-up, and the number of steps with contact.
fn allocations(options: Options, action: &[f64], steps: u32) -> (u64, u32) {
    let mut row = vec![0.0; options.observation_len()];
    let mut task = PushTask::new(options).unwrap();
    task.reset(Some(3), &ResetOptions::default()).unwrap();
    for _ in 0..40 {
        task.step(action).unwrap();
    }
    let mut touched = 0;
    let taken = measure(|| {
        for _ in 0..steps {
            let outcome = task.step(action).unwrap();
            touched += u32::from(outcome.is_some_and(|o| o.touched));
            task.observe(&mut row);
        }
    });
    (taken.count_total, touched)
}

#[test]
fn a_step_allocates_nothing() {
    // In the mode `regrasp`, the gripper regrasps continuously.
    let action = [0.02, 0.01, 0.0, 0.9, 0.9, 1.0];
    for mode in [ActionMode::Wrench, ActionMode::Velocity, ActionMode::Regrasp] {
        for task in [TaskKind::Pose, TaskKind::Path] {
            assert_eq!(allocations(options(task, mode), &action, 50).0, 0, "{task:?} {mode:?}");
        }
    }
}

#[test]
fn a_step_with_a_real_arm_allocates_nothing() {
    let arm = ArmOptions {
        lag: 0.08,
        rate: 5.0,
        delay: 0.12,
        saturation: 0.9,
        noise: 0.05,
        wrist: Some(WristOptions::default()),
    };
    for mode in [ActionMode::Wrench, ActionMode::Velocity, ActionMode::Regrasp] {
        let real = Options {
            version: 1,
            arm: arm.clone(),
            sensor_delay: 0.13,
            decision_time: 0.06,
            ..options(TaskKind::Pose, mode)
        };
        assert_eq!(allocations(real, &[0.02, 0.01, 0.0, 0.9, 0.9, 1.0], 50).0, 0, "{mode:?}");
    }
}

/// Memory of an environment as assumed by `task::Batch`, bytes.
const ENVIRONMENT_BYTES: u64 = 64 << 10;

#[test]
fn an_environment_needs_no_more_memory_than_a_batch_assumes() {
    let mut most = 0;
    for task in [TaskKind::Pose, TaskKind::Path, TaskKind::Around, TaskKind::Door] {
        for mode in [ActionMode::Wrench, ActionMode::Push] {
            let object = vec!["random".to_owned()];
            let options = Options { object, hidden: HiddenKind::Catalogue, ..options(task, mode) };
            for seed in 0..10 {
                let mut env = None;
                let taken = measure(|| {
                    let mut task = PushTask::new(options.clone()).unwrap();
                    task.reset(Some(seed), &ResetOptions::default()).unwrap();
                    for _ in 0..40 {
                        task.step(&[0.3, 0.0, 0.0]).unwrap();
                    }
                    env = Some(task);
                });
                most = most.max(u64::try_from(taken.bytes_current).unwrap());
            }
        }
    }
    assert!((ENVIRONMENT_BYTES / 16..ENVIRONMENT_BYTES).contains(&most), "{most}");
}

#[test]
fn in_contact_only_the_engine_allocates() {
    // The engine allocates twice per simulation step, for its solver's barrier and its list of changes, and sometimes a tree.
    let (count, touched) = allocations(options(TaskKind::Door, ActionMode::Wrench), &[0.3, 0.0, 0.0], 200);
    assert!(touched == 200 && count as f64 <= 200.0 * 25.0 * 2.2, "{count} {touched}");
}

#[test]
fn direct_contacts_allocate_nothing() {
    for task in [TaskKind::Door, TaskKind::Around] {
        let direct = Options { version: 1, ..options(task, ActionMode::Wrench) };
        let (count, touched) = allocations(direct, &[0.3, 0.0, 0.0], 200);
        assert!(touched > 100 && count == 0, "{task:?} {count} {touched}");
    }
}

#[test]
fn an_environment_is_small() {
    for (task, most) in [(TaskKind::Pose, 16), (TaskKind::Door, 64)] {
        let mut touched = 0;
        let mut kept = vec![];
        let taken = measure(|| {
            for _ in 0..16 {
                let mut env = PushTask::new(options(task, ActionMode::Wrench)).unwrap();
                env.reset(Some(7), &ResetOptions::default()).unwrap();
                for _ in 0..100 {
                    touched += u32::from(env.step(&[0.3, 0.0, 0.0]).unwrap().is_some_and(|o| o.touched));
                }
                kept.push(env);
            }
        });
        let each = taken.bytes_current / 16 / 1024;
        assert!(each < most, "{task:?}: {each} KiB");
        assert!(task == TaskKind::Pose || touched > 16 * 30, "each environment needs an engine: {touched}");
    }
}
