//! Tasks: reproducibility, bounds, recording, copies and batches.

#![allow(clippy::unwrap_used)]

use std::f64::consts::{PI, TAU};

use trundle_model::Kind;
use trundle_sim::task::{ActionMode, Autoreset, HiddenKind, Rows, TaskKind, household_names};
use trundle_sim::{Batch, Options, Outcome, PushTask, ResetOptions, episode};

const TASKS: [TaskKind; 4] = [TaskKind::Pose, TaskKind::Path, TaskKind::Around, TaskKind::Door];
const MODES: [ActionMode; 4] =
    [ActionMode::Wrench, ActionMode::Velocity, ActionMode::Push, ActionMode::Regrasp];

/// An action for any mode, which uses the first entries.
fn action(k: u32) -> [f64; 6] {
    let t = f64::from(k) * 0.05;
    // Regrasp in the fifth step, so that copies after twelve steps are made during a regrasp.
    let elsewhere = if k == 4 { 1.0 } else { -1.0 };
    [0.6 * (2.0 * t).sin(), 0.3 * (3.0 * t).cos(), 0.25 * t.sin(), (7.0 * t).cos(), 0.8, elsewhere]
}

fn observation(task: &mut PushTask) -> Vec<f64> {
    let mut row = vec![f64::NAN; task.options().observation_len()];
    task.observe(&mut row);
    row
}

fn observations(task: &mut PushTask, steps: u32) -> Vec<Vec<f64>> {
    let mut seen = vec![observation(task)];
    for k in 0..steps {
        if task.step(&action(k)).unwrap().is_none() {
            break;
        }
        seen.push(observation(task));
    }
    seen
}

fn any(task: TaskKind, action: ActionMode) -> Options {
    Options {
        task,
        action,
        object: vec!["random".to_owned()],
        hidden: HiddenKind::Catalogue,
        ..Options::default()
    }
}

fn all() -> impl Iterator<Item = Options> {
    TASKS.into_iter().flat_map(|task| MODES.map(|mode| any(task, mode)))
}

#[test]
fn a_seed_determines_the_episodes() {
    for options in all() {
        let run = |seed| {
            let mut task = PushTask::new(options.clone()).unwrap();
            task.reset(Some(seed), &ResetOptions::default()).unwrap();
            let first = observations(&mut task, 30);
            task.reset(None, &ResetOptions::default()).unwrap();
            (first, observations(&mut task, 5))
        };
        assert_eq!(run(5), run(5));
        assert_ne!(run(5).0, run(6).0);
        assert_ne!(run(5).0[..6], run(5).1[..6], "later episodes must differ");
    }
}

#[test]
fn recording_does_not_change_the_episode_and_has_the_rates_of_the_instruments() {
    let new = || PushTask::new(Options { hidden: HiddenKind::Locked, ..Options::default() }).unwrap();
    let (mut plain, mut recorded) = (new(), new());
    recorded.record();
    plain.reset(Some(2), &ResetOptions::default()).unwrap();
    recorded.reset(Some(2), &ResetOptions::default()).unwrap();
    let steps = observations(&mut plain, 100);
    assert_eq!(observations(&mut recorded, 100), steps);
    let table = episode("episode_00".to_owned(), &recorded.take_rows());
    let seconds = 0.4 + 0.05 * (steps.len() - 1) as f64;
    assert!((table.wrench().unwrap().t.len() as f64 - 200.0 * seconds).abs() <= 1.0);
    assert!((table.object().unwrap().t.len() as f64 - 60.0 * seconds).abs() <= 1.0);
    assert!(recorded.take_rows().is_empty());
}

#[test]
fn copies_and_saved_states_continue_bit_for_bit() {
    for (k, options) in all().enumerate() {
        let mut task = PushTask::new(options.clone()).unwrap();
        for seed in 0..4 {
            task.reset(Some(10 * k as u64 + seed), &ResetOptions::default()).unwrap();
            observations(&mut task, 12);
            let mut copy = task.clone();
            let mut other = PushTask::new(options.clone()).unwrap();
            other.load(&task.save().unwrap()).unwrap();
            let after = observations(&mut task, 20);
            assert_eq!(observations(&mut copy, 20), after);
            assert_eq!(observations(&mut other, 20), after);
            // The seed sequence of later episodes continues identically.
            for task in [&mut task, &mut copy, &mut other] {
                task.reset(None, &ResetOptions::default()).unwrap();
            }
            assert_eq!(observation(&mut task), observation(&mut other));
        }
    }
}

#[test]
fn a_copy_in_contact_continues_bit_for_bit() {
    // The physics engine, and direct contacts.
    [0, 1].into_iter().for_each(copy_in_contact);
}

fn copy_in_contact(version: u32) {
    let options = Options {
        task: TaskKind::Door,
        hidden: HiddenKind::Locked,
        horizon: 0,
        version,
        ..Options::default()
    };
    let mut task = PushTask::new(options.clone()).unwrap();
    task.reset(Some(3), &ResetOptions::default()).unwrap();
    let push = |task: &mut PushTask| task.step(&[0.3, 0.0, 0.0]).unwrap();
    let touched = (0..300).find(|_| push(&mut task).is_some_and(|outcome| outcome.touched));
    assert!(touched.is_some(), "the object must reach the wall");
    let mut copy = task.clone();
    let mut other = PushTask::new(options).unwrap();
    other.load(&task.save().unwrap()).unwrap();
    let mut contacts = 0;
    for _ in 0..60 {
        let after = push(&mut task);
        contacts += u32::from(after.is_some_and(|outcome| outcome.touched));
        assert_eq!(push(&mut copy), after);
        assert_eq!(push(&mut other), after);
        assert_eq!(copy.view(), task.view());
        assert_eq!(other.view(), task.view());
    }
    assert!(contacts > 10, "{contacts}");
}

#[test]
fn the_object_stays_the_same_only_on_request() {
    let mut task = PushTask::new(any(TaskKind::Door, ActionMode::Wrench)).unwrap();
    let same = ResetOptions { same_object: true, ..ResetOptions::default() };
    task.reset(Some(1), &same).unwrap();
    let first = task.hidden().cloned();
    let layout = task.layout().cloned().unwrap();
    task.reset(Some(2), &same).unwrap();
    assert_eq!((task.object_count(), task.hidden().cloned()), (1, first.clone()));
    let next = task.layout().cloned().unwrap();
    assert_eq!(next.obstacles, layout.obstacles, "the obstacles must stay the same");
    assert!(next.start != layout.start && next.goal != layout.goal);
    // A saved state draws the object again from its seed.
    let mut other = PushTask::new(task.options().clone()).unwrap();
    other.load(&task.save().unwrap()).unwrap();
    assert_eq!(other.hidden().cloned(), first);
    assert_eq!(observations(&mut other, 10), observations(&mut task, 10));
    task.reset(Some(2), &ResetOptions::default()).unwrap();
    assert_eq!(task.object_count(), 2);
    assert_ne!(task.hidden().cloned(), first);
}

#[test]
fn observations_stay_within_their_bounds() {
    for options in all() {
        let mut task = PushTask::new(Options { noise: 10.0, ..options }).unwrap();
        let bounds = task.options().observation_bounds();
        for seed in 0..30 {
            task.reset(Some(seed), &ResetOptions::default()).unwrap();
            for k in 0..60 {
                let row = observation(&mut task);
                assert!(row.iter().zip(&bounds).all(|(v, most)| v.abs() <= *most), "{row:?}");
                // Each corner of the action space for 20 steps.
                let corner = seed + k / 20;
                let sign = |bit: u64| if corner >> bit & 1 == 0 { 1.0 } else { -1.0 };
                if task.step(&[sign(0), sign(1), sign(2), sign(1), sign(2), sign(0)]).unwrap().is_none() {
                    break;
                }
            }
        }
    }
}

#[test]
fn an_episode_ends_at_the_goal_outside_the_workspace_and_at_the_horizon() {
    let mut task = PushTask::new(Options { horizon: 20, ..Options::default() }).unwrap();
    let there = ResetOptions { start: Some([0.5; 3]), goal: Some([0.5; 3]), ..ResetOptions::default() };
    task.reset(Some(0), &there).unwrap();
    let outcome = task.step(&[0.0; 3]).unwrap().unwrap();
    assert!(outcome.success && outcome.terminated && outcome.reward > -0.01);
    assert!(task.step(&[0.0; 3]).unwrap().is_none());
    task.reset(Some(0), &ResetOptions { start: Some([2.0, 0.0, 0.0]), ..ResetOptions::default() }).unwrap();
    let last = std::iter::from_fn(|| task.step(&[1.0, 0.0, 0.0]).unwrap()).last().unwrap();
    assert!(last.lost && last.terminated && !last.success && last.reward < -99.0);
    task.reset(Some(0), &ResetOptions { goal: Some([2.0, 2.0, 0.0]), ..ResetOptions::default() }).unwrap();
    let all: Vec<Outcome> = std::iter::from_fn(|| task.step(&[0.0; 3]).unwrap()).collect();
    assert!(all.len() == 20 && all[19].truncated && !all[18].truncated && !all[19].terminated);
}

#[test]
fn a_simple_controller_completes_the_path_task() {
    let options = Options {
        task: TaskKind::Path,
        action: ActionMode::Velocity,
        hidden: HiddenKind::None,
        noise: 0.0,
        horizon: 0,
        ..Options::default()
    };
    let mut task = PushTask::new(options).unwrap();
    task.reset(Some(4), &ResetOptions { grasp: Some([0.0, 0.0]), ..ResetOptions::default() }).unwrap();
    let (mut gained, mut last) = (0.0, Outcome::default());
    for _ in 0..600 {
        let seen = observation(&mut task);
        let (dx, dy) = (seen[7] - seen[0], seen[8] - seen[1]);
        let ahead = seen[10].atan2(seen[9]) - seen[3].atan2(seen[2]);
        let turn = (ahead + 3.0 * PI).rem_euclid(TAU) - PI;
        let clip = |v: f64| v.clamp(-1.0, 1.0);
        let Some(outcome) = task.step(&[clip(3.0 * dx), clip(3.0 * dy), clip(2.0 * turn)]).unwrap() else {
            break;
        };
        gained += outcome.reward;
        last = outcome;
    }
    assert!(last.success && last.progress > 0.9 && gained > 0.5, "{last:?} {gained}");
}

#[test]
fn obstacles_exist_and_start_and_goal_are_clear() {
    for (task, count) in [(TaskKind::Around, 1), (TaskKind::Door, 2)] {
        for name in household_names() {
            let options = Options { task, object: vec![name.to_owned()], ..Options::default() };
            let mut task = PushTask::new(options).unwrap();
            for seed in 0..20 {
                // Reset fails if start or goal is in an obstacle.
                task.reset(Some(seed), &ResetOptions::default()).unwrap();
                assert_eq!(task.layout().unwrap().obstacles.len(), count);
            }
        }
    }
}

#[test]
fn hidden_effects_match_the_option() {
    let kinds = |hidden, object: &str| {
        let mut task =
            PushTask::new(Options { hidden, object: vec![object.to_owned()], ..Options::default() }).unwrap();
        let draws = (0..60).map(move |seed| {
            task.reset(Some(seed), &ResetOptions::default()).unwrap();
            task.hidden().unwrap().effects.iter().map(|e| e.kind).collect::<Vec<_>>()
        });
        draws.collect::<Vec<_>>()
    };
    assert!(kinds(HiddenKind::None, "bed").iter().all(Vec::is_empty));
    assert!(kinds(HiddenKind::Locked, "bed").iter().all(|k| k == &[Kind::ViscousWheel]));
    let wheels = kinds(HiddenKind::Wheels, "office_table");
    let casters = wheels.iter().filter(|k| k.contains(&Kind::CasterSwivel)).count();
    assert!(wheels.iter().all(|k| k.len() == 4) && (5..30).contains(&casters), "{casters}");
    assert!(kinds(HiddenKind::Wheels, "chair").iter().any(|k| k.contains(&Kind::SupportDrag)));
    let mut met: Vec<Kind> = kinds(HiddenKind::Catalogue, "random").into_iter().flatten().collect();
    met.sort_unstable();
    met.dedup();
    assert!(met.len() > 15, "{met:?}");
}

#[test]
fn errors_name_the_invalid_option() {
    let mut task = PushTask::new(Options { task: TaskKind::Around, ..Options::default() }).unwrap();
    task.reset(Some(0), &ResetOptions::default()).unwrap();
    let [x, y] = task.layout().unwrap().obstacles[0][0];
    for (reset, word) in [
        (ResetOptions { goal: Some([9.0, 0.0, 0.0]), ..ResetOptions::default() }, "goal"),
        (ResetOptions { start: Some([0.0, f64::NAN, 0.0]), ..ResetOptions::default() }, "start"),
        (ResetOptions { grasp: Some([0.7, 0.0]), ..ResetOptions::default() }, "grasp"),
        (ResetOptions { goal: Some([x, y, 0.0]), ..ResetOptions::default() }, "obstacle"),
    ] {
        // A failed reset does not change the episode.
        let before = task.view();
        assert!(task.reset(Some(0), &reset).unwrap_err().to_string().contains(word));
        assert_eq!(task.view(), before);
    }
    for (text, word) in [
        ("noise = -1.0", "noise"),
        ("nois = 1.0", "nois"),
        ("object = [\"piano\"]", "kitchen_table"),
        ("object = []", "object"),
        ("action = \"kick\"", "wrench"),
        ("substeps = 0", "substeps"),
        ("drop_out = 1.0", "drop_out"),
        ("effects = [{kind = \"coulomb_friction\", x = 0.1, y = 0.1}]", "force"),
        ("effects = [{kind = \"ghost\"}]", "ghost"),
    ] {
        let error = Options::from_toml(text).and_then(PushTask::new).err().unwrap().to_string();
        assert!(error.contains(word), "{error}");
    }
    let bytes = task.save().unwrap();
    assert!(task.load(&bytes[..20]).unwrap_err().to_string().contains("not a saved state"));
}

fn batch(
    count: usize,
    autoreset: Autoreset,
    threads: usize,
    mode: ActionMode,
) -> (Vec<f64>, Vec<f64>, Vec<Outcome>) {
    let options = Options { horizon: 7, ..any(TaskKind::Around, mode) };
    let (entries, width) = (options.observation_len(), mode.width());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let mut batch = Batch::new(options, count, autoreset).unwrap();
    let (mut seen, mut finals) = (vec![0.0; count * entries], vec![0.0; count * entries]);
    let mut outcomes = vec![Outcome::default(); count];
    let resets: Vec<_> = (0..count as u64).map(|k| Some((Some(k), ResetOptions::default()))).collect();
    pool.install(|| {
        batch.reset(&resets, &mut seen).unwrap();
        for k in 0..20 {
            let actions: Vec<f64> = (0..count).flat_map(|_| action(k).into_iter().take(width)).collect();
            let rows = Rows { observations: &mut seen, finals: &mut finals, outcomes: &mut outcomes };
            batch.step(&actions, rows).unwrap();
        }
    });
    (seen, finals, outcomes)
}

#[test]
fn a_batch_does_not_depend_on_its_size_or_the_threads() {
    let modes = [Autoreset::NextStep, Autoreset::SameStep];
    for (reset, mode) in modes
        .into_iter()
        .flat_map(|reset| [ActionMode::Wrench, ActionMode::Regrasp].map(|mode| (reset, mode)))
    {
        let (seen, finals, outcomes) = batch(40, reset, 1, mode);
        assert_eq!(batch(40, reset, 4, mode), (seen.clone(), finals.clone(), outcomes.clone()));
        let (few, last, results) = batch(3, reset, 2, mode);
        assert_eq!(
            (&few[..], &last[..], &results[..]),
            (&seen[..few.len()], &finals[..last.len()], &outcomes[..3])
        );
    }
}

#[test]
#[ignore = "takes minutes"]
fn a_million_random_steps_are_finite() {
    let mut steps = 0;
    for (k, options) in std::iter::repeat_with(all).flatten().enumerate() {
        let mut task = PushTask::new(Options { horizon: 200, ..options }).unwrap();
        for seed in 0..40 {
            task.reset(Some(1000 * k as u64 + seed), &ResetOptions::default()).unwrap();
            let mut state = seed + 1;
            let mut any = || {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
            };
            while let Some(outcome) = task.step(&[(); 6].map(|()| any())).unwrap() {
                steps += 1;
                assert!(outcome.reward.is_finite() && outcome.distance.is_finite());
                assert!(observation(&mut task).iter().all(|v| v.is_finite()));
            }
        }
        if steps > 1_000_000 {
            return;
        }
    }
}
