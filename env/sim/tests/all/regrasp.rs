//! Regrasps: duration, wrench and motion during and after them, and their recording.

#![allow(clippy::unwrap_used)]

use trundle_sim::task::{ActionMode, HiddenKind, constants, household_names};
use trundle_sim::{Options, PushTask, ResetOptions, episode};

/// Control steps of a regrasp.
const AWAY: usize = 20;
/// A request to regrasp halfway to the front right corner. Its wrench has no effect.
const GO: [f64; 6] = [0.3, 0.2, 0.1, 0.5, -0.5, 1.0];
const PUSH: [f64; 6] = [0.3, 0.1, 0.05, 0.0, 0.0, -1.0];

fn noiseless(action: ActionMode) -> Options {
    Options { action, hidden: HiddenKind::Locked, noise: 0.0, horizon: 0, ..Options::default() }
}

fn start_task(options: Options, reset: &ResetOptions) -> PushTask {
    let mut task = PushTask::new(options).unwrap();
    task.reset(Some(3), reset).unwrap();
    task
}

/// Apply an action and return the observation.
fn step(task: &mut PushTask, action: &[f64]) -> Vec<f64> {
    task.step(action).unwrap().unwrap();
    let mut row = vec![f64::NAN; task.options().observation_len()];
    task.observe(&mut row);
    row
}

fn far_goal() -> ResetOptions {
    ResetOptions { start: Some([0.0; 3]), goal: Some([2.0, 2.0, 0.0]), ..ResetOptions::default() }
}

#[test]
fn a_regrasp_takes_a_second_without_a_wrench() {
    let mut task = start_task(noiseless(ActionMode::Regrasp), &far_goal());
    for _ in 0..6 {
        step(&mut task, &PUSH);
    }
    let from = task.task_object().unwrap().default_grasp();
    let to = task.task_object().unwrap().grasp_point([0.5, -0.5]);
    assert_eq!(to, [0.3, -0.2], "of a table of 1.2 m by 0.8 m");
    for k in 1..=AWAY {
        // Requests and wrenches during the regrasp have no effect.
        let seen = step(&mut task, if k == 1 { &GO } else { &[1.0, 1.0, 1.0, -1.0, 1.0, 1.0] });
        let share = k as f64 / AWAY as f64;
        for axis in 0..2 {
            let expected = from[axis] + share * (to[axis] - from[axis]);
            assert!((seen[14 + axis] - expected).abs() < 1e-12, "{k}: {seen:?}");
        }
        assert!(seen[11..14].iter().all(|v| *v == 0.0), "{k}: {seen:?}");
        let (_, holds) = task.view().unwrap();
        assert_eq!(holds, k == AWAY);
        assert!(seen[4] > 0.0, "the object keeps rolling");
    }
    let seen = step(&mut task, &PUSH);
    assert_eq!(seen[14..16], to);
    assert_eq!(seen[11..14], [30.0, 10.0, 2.0]);
}

#[test]
fn a_released_object_coasts_under_its_hidden_effects_alone() {
    let speeds = |hidden| {
        let mut task = start_task(Options { hidden, ..noiseless(ActionMode::Regrasp) }, &far_goal());
        for _ in 0..6 {
            step(&mut task, &PUSH);
        }
        (0..AWAY).map(|_| step(&mut task, &GO)[4..7].to_vec()).collect::<Vec<_>>()
    };
    let free = speeds(HiddenKind::None);
    // The mass centre of the table is its origin, so velocity and spin are constant from the start.
    for (k, twist) in free.iter().enumerate() {
        assert!(twist.iter().zip(&free[0]).all(|(a, b)| (a - b).abs() < 1e-12), "{k}: {twist:?}");
    }
    let before = 6.0 * 0.05 * 30.0 / 22.0;
    assert!(free[0][0] > 0.8 * before && free[0][0] < before, "{free:?}");
    let slowed = speeds(HiddenKind::Locked);
    let speed = |twist: &[f64]| twist[0].hypot(twist[1]);
    assert!(slowed.windows(2).all(|w| speed(&w[1]) < speed(&w[0])), "{slowed:?}");
}

#[test]
fn after_a_regrasp_the_motion_equals_that_of_an_initial_grasp() {
    let place = [0.5, -0.5];
    let mut regrasped = start_task(noiseless(ActionMode::Regrasp), &far_goal());
    let there = regrasped.task_object().unwrap().grasp_point(place);
    // The object is at rest during the regrasp.
    for _ in 0..AWAY {
        step(&mut regrasped, &GO);
    }
    let mut direct =
        start_task(noiseless(ActionMode::Wrench), &ResetOptions { grasp: Some(there), ..far_goal() });
    for _ in 0..30 {
        assert_eq!(step(&mut regrasped, &PUSH), step(&mut direct, &PUSH));
    }
}

#[test]
fn without_a_request_the_mode_equals_wrench_bit_for_bit() {
    let (mut regrasps, mut wrench) = (
        start_task(noiseless(ActionMode::Regrasp), &ResetOptions::default()),
        start_task(noiseless(ActionMode::Wrench), &ResetOptions::default()),
    );
    for k in 0..40 {
        let push = (f64::from(k) * 0.2).sin() * 0.4;
        let action = [push, -0.5 * push, 0.2, 0.7, -0.7, 0.0];
        assert_eq!(step(&mut regrasps, &action), step(&mut wrench, &action));
    }
}

#[test]
fn every_grasp_point_is_the_nearest_point_on_the_object() {
    let shares = || (-4..=4).map(|k| f64::from(k) / 4.0);
    for name in household_names().chain(["random"]) {
        let options = Options { object: vec![name.to_owned()], ..noiseless(ActionMode::Regrasp) };
        let mut task = PushTask::new(options).unwrap();
        for seed in 0..if name == "random" { 30 } else { 1 } {
            task.reset(Some(seed), &ResetOptions::default()).unwrap();
            let body = task.task_object().unwrap().body.clone();
            let [low, high] = body.bounds();
            for (x, y) in shares().flat_map(|x| shares().map(move |y| (x, y))) {
                let place = task.task_object().unwrap().grasp_point([x, y]);
                let asked = [
                    low[0] + (1.0 + x) / 2.0 * (high[0] - low[0]),
                    low[1] + (1.0 + y) / 2.0 * (high[1] - low[1]),
                ];
                let moved = (place[0] - asked[0]).hypot(place[1] - asked[1]);
                assert!((moved - body.outside(asked).0).abs() < 1e-9, "{name}: {asked:?} {place:?}");
                // Reset accepts every grasp point.
                let reset = ResetOptions { grasp: Some(place), same_object: true, ..ResetOptions::default() };
                task.reset(Some(seed), &reset).unwrap();
            }
        }
    }
}

#[test]
fn a_regrasp_takes_a_whole_number_of_actions() {
    for (substeps, away) in [(25, 20), (5, 100), (15, 33), (2000, 1)] {
        let options = Options { substeps, ..noiseless(ActionMode::Regrasp) };
        let mut task = start_task(options, &far_goal());
        let steps = (1..).find(|_| {
            step(&mut task, &GO);
            task.view().unwrap().1
        });
        assert_eq!(steps, Some(away));
    }
}

/// Linear interpolation of the readings reproduces the applied wrench, even if it ends abruptly.
#[test]
fn a_recording_contains_the_impulse_and_the_motion_of_the_gripper() {
    let options = Options { hidden: HiddenKind::None, ..noiseless(ActionMode::Regrasp) };
    let mut task = PushTask::new(options).unwrap();
    task.record();
    task.reset(Some(1), &ResetOptions { grasp: Some([0.0, 0.0]), ..far_goal() }).unwrap();
    let ahead = [0.5, 0.0, 0.0, 0.0, 0.0, -1.0];
    for _ in 0..10 {
        step(&mut task, &ahead);
    }
    let last = (0..AWAY).map(|_| step(&mut task, &[0.0, 0.0, 0.0, 1.0, 0.0, 1.0])).last().unwrap();
    let table = episode("one".to_owned(), &task.take_rows());
    let column = |name: &str| {
        let (_, cells) = table.columns.iter().find(|(key, _)| *key == name).unwrap();
        table.t.iter().copied().zip(cells.iter().copied()).filter(|(_, v)| v.is_finite()).collect::<Vec<_>>()
    };
    let force = column("force_x");
    let tare = force[0].1;
    let impulse: f64 = force.windows(2).map(|w| (w[1].0 - w[0].0) * ((w[0].1 + w[1].1) / 2.0 - tare)).sum();
    let momentum = 22.0 * last[4];
    // Readings coincide with steps of 2 ms, 4 ms before the release and 6 ms after: the jump is located to half a millisecond.
    assert!((impulse - momentum).abs() < 0.51e-3 * 50.0, "{impulse} N s, {momentum} kg m/s");
    // The release is 0.9 s after the start of the recording, and the regrasp ends at 1.9 s.
    let away = force.iter().filter(|(t, _)| *t > 0.9 + 1e-6);
    assert!(away.clone().count() >= 199 && away.clone().all(|(_, f)| (f - tare).abs() < 1e-9));
    let arm: Vec<_> = column("gripper_x").into_iter().zip(column("object_x")).collect();
    for ((t, gripper), (_, object)) in arm {
        let expected = 0.6 * ((t - 0.9) / constants::REGRASP_S).clamp(0.0, 1.0);
        assert!((gripper - object - expected).abs() < 1e-9, "{t}: {}", gripper - object);
    }
}
