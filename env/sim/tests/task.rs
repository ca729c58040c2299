//! The locked wheel's task: seeded, bounded, recorded without being disturbed, copied exactly.

#![allow(clippy::unwrap_used)]

use trundle_sim::task::rules::{BOUNDS, FULL, HALF, MASS, WHEELS};
use trundle_sim::{LockedWheel, Reset, episode};

fn action(k: u32) -> [f64; 3] {
    let t = f64::from(k) * 0.05;
    [60.0 * (2.0 * t).sin(), 30.0 * (3.0 * t).cos(), 10.0 * t.sin()]
}

fn observations(task: &mut LockedWheel, steps: u32) -> Vec<[f64; 16]> {
    (0..steps).map_while(|k| task.step(action(k))).map(|(observation, _)| observation).collect()
}

#[test]
fn a_seed_draws_the_same_episode() {
    let run = |seed| {
        let mut task = LockedWheel::new(1.0).unwrap();
        let first = task.reset(seed, &Reset::default()).unwrap();
        (first, observations(&mut task, 100))
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
}

#[test]
fn recording_does_not_change_the_episode_and_has_the_instruments_rates() {
    let mut plain = LockedWheel::new(1.0).unwrap();
    let mut recorded = LockedWheel::new(1.0).unwrap();
    recorded.record();
    plain.reset(2, &Reset::default()).unwrap();
    recorded.reset(2, &Reset::default()).unwrap();
    let steps = observations(&mut plain, 100);
    assert_eq!(observations(&mut recorded, 100), steps);
    let table = episode("episode_00".to_owned(), &recorded.take_rows());
    let seconds = 0.4 + 0.05 * steps.len() as f64;
    assert!((table.wrench().unwrap().t.len() as f64 - 200.0 * seconds).abs() <= 1.0);
    assert!((table.object().unwrap().t.len() as f64 - 60.0 * seconds).abs() <= 1.0);
    assert!(recorded.take_rows().is_empty());
}

#[test]
fn a_copy_goes_on_to_the_last_bit() {
    let mut task = LockedWheel::new(1.0).unwrap();
    task.reset(9, &Reset::default()).unwrap();
    observations(&mut task, 20);
    let (objects, hidden, saved) = task.save();
    let mut copy = LockedWheel::new(1.0).unwrap();
    copy.restore(objects, hidden, saved.as_ref()).unwrap();
    assert_eq!(observations(&mut copy, 50), observations(&mut task, 50));
}

#[test]
fn the_object_stays_the_same_only_if_asked() {
    let mut task = LockedWheel::new(1.0).unwrap();
    let same = Reset { same_object: true, ..Reset::default() };
    task.reset(1, &same).unwrap();
    let first = task.save().1;
    task.reset(2, &same).unwrap();
    assert_eq!((task.objects(), task.save().1), (1, first));
    task.reset(2, &Reset::default()).unwrap();
    assert_eq!(task.objects(), 2);
    assert_ne!(task.save().1, first);
}

#[test]
fn no_push_leaves_the_bounds() {
    let mut task = LockedWheel::new(10.0).unwrap();
    for seed in 0..200 {
        let mut seen = task.reset(seed, &Reset::default()).unwrap();
        for k in 0..100 {
            for (value, bound) in seen.iter().zip(BOUNDS) {
                assert!(value.abs() <= bound, "{seen:?}");
            }
            // One corner of the action space for a while, then another.
            let corner = seed + k / 20;
            let sign = |bit: u64| if corner >> bit & 1 == 0 { 1.0 } else { -1.0 };
            match task.step([sign(0) * FULL[0], sign(1) * FULL[1], sign(2) * FULL[2]]) {
                Some((observation, _)) => seen = observation,
                None => break,
            }
        }
    }
}

#[test]
fn the_task_ends_at_the_goal_and_when_the_object_is_lost() {
    let mut task = LockedWheel::new(1.0).unwrap();
    let there = Reset { start: Some([0.5; 3]), goal: Some([0.5; 3]), ..Reset::default() };
    task.reset(0, &there).unwrap();
    let (_, outcome) = task.step([0.0; 3]).unwrap();
    assert!(outcome.success && outcome.terminated && outcome.reward > -0.01);
    assert!(task.step([0.0; 3]).is_none());
    task.reset(0, &Reset { start: Some([2.0, 0.0, 0.0]), ..Reset::default() }).unwrap();
    let last = std::iter::from_fn(|| task.step([100.0, 0.0, 0.0])).last().unwrap().1;
    assert!(!last.success && last.terminated && last.reward < -99.0);
}

#[test]
fn what_cannot_be_is_named() {
    let mut task = LockedWheel::new(1.0).unwrap();
    for (told, word) in [
        (Reset { goal: Some([9.0, 0.0, 0.0]), ..Reset::default() }, "goal"),
        (Reset { start: Some([0.0, f64::NAN, 0.0]), ..Reset::default() }, "start"),
        (Reset { grasp: Some([0.7, 0.0]), ..Reset::default() }, "grasp"),
    ] {
        assert!(task.reset(0, &told).unwrap_err().to_string().contains(word));
    }
    assert!(LockedWheel::new(-1.0).is_err());
    assert!(!task.ready() && task.step([0.0; 3]).is_none());
}

#[test]
fn the_table_is_the_one_in_the_object_file() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../configs/objects/office_table.toml");
    let file: toml::Table = toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let points = |key: &str| -> Vec<[f64; 2]> { file["body"][key].clone().try_into().unwrap() };
    assert_eq!(file["body"]["mass"].as_float(), Some(MASS));
    assert_eq!(points("support"), WHEELS);
    assert!(points("footprint").iter().all(|p| p.map(f64::abs) == HALF));
}
