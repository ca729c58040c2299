//! Diagnoses of an axis whose recordings are integrated here, with formulas of this file.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use trundle_diagnose::Verdict;
use trundle_infer::Quiet;
use trundle_mechanism::{JointAnswer, Problem, diagnose_joints, motion};
use trundle_record::{Episode, JointMetadata, JointRecording};

const INERTIA: f64 = 0.02;
const DAMPING: f64 = 0.05;
const DT: f64 = 1e-3;
/// Steps between samples.
const SAMPLE: usize = 5;

/// Effort on the axis at time, position and velocity, in addition to its drive and damping.
type Extra = fn(f64, f64, f64) -> f64;

/// A repeatable number in ±1.
fn noise(k: usize) -> f64 {
    let hashed = (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d;
    2.0 * ((hashed.wrapping_mul(hashed | 1) >> 40) as f64 / (1u64 << 24) as f64) - 1.0
}

fn episode(index: usize, extra: Extra, dry: f64, reading: fn(f64) -> f64) -> Episode {
    let (mut q, mut v) = (0.0, 0.0);
    let mut columns: [Vec<f64>; 3] = Default::default();
    let phase = index as f64;
    let drive =
        |t: f64, q: f64| 0.4 * (3.1 * t + phase).sin() + 0.3 * (7.3 * t + 2.0 * phase).sin() - 0.3 * q;
    for k in 0..8000 {
        let t = k as f64 * DT;
        let effort = drive(t, q);
        if k % SAMPLE == 0 {
            let row = index * 100_000 + k;
            columns[0].push(t);
            columns[1].push(q + 1e-4 * noise(row));
            columns[2].push(reading(effort) + 2e-3 * noise(row + 1));
        }
        let free = v + DT / INERTIA * (effort + extra(t, q, v) - DAMPING * v);
        let stopping = DT / INERTIA * dry;
        v = if free.abs() <= stopping { 0.0 } else { free - stopping * free.signum() };
        q += DT * v;
    }
    let mut episode = Episode { name: format!("episode_{index:02}"), ..Episode::default() };
    for (title, values) in ["t", "q_arm", "effort_arm"].into_iter().zip(columns) {
        episode.insert(title.to_owned(), values);
    }
    episode
}

fn diagnosed(extra: Extra, dry: f64, reading: fn(f64) -> f64) -> JointAnswer {
    diagnosed_in_units(extra, dry, reading, [1.0, 1.0])
}

/// A diagnosis of the same motion in units of position and effort that are smaller by these factors.
fn diagnosed_in_units(extra: Extra, dry: f64, reading: fn(f64) -> f64, units: [f64; 2]) -> JointAnswer {
    let metadata = JointMetadata::from_toml(
        "format = \"trundle-recording/2\"\nname = \"bench\"\n[mechanism]\naxis = \"hinge\"\njoints = [\"arm\"]\n\
         [split]\nheld_out = [\"episode_06\", \"episode_07\"]\n",
    )
    .unwrap();
    let one = |k: usize| {
        let mut episode = episode(k, extra, dry, reading);
        for (title, factor) in ["q_arm", "effort_arm"].into_iter().zip(units) {
            episode.columns.get_mut(title).unwrap().iter_mut().for_each(|value| *value *= factor);
        }
        episode
    };
    let episodes = (0..8).map(one).collect();
    let recording = JointRecording::new(metadata, episodes, BTreeMap::new()).unwrap();
    let motion = motion(&recording).unwrap();
    let problem = Problem::new(&recording, &motion, None).unwrap();
    diagnose_joints(&problem, &[], &Quiet).unwrap().answer
}

fn names(answer: &JointAnswer) -> Vec<&str> {
    answer.missing.iter().map(|effect| effect.effect.as_str()).collect()
}

fn nothing(_: f64, _: f64, _: f64) -> f64 {
    0.0
}

fn exact(effort: f64) -> f64 {
    effort
}

#[test]
fn nothing_is_missing() {
    let answer = diagnosed(nothing, 0.0, exact);
    assert_eq!((answer.verdict, names(&answer)), (Verdict::Consistent, vec![]));
    let inertia = &answer.nominal.after["inertia:arm"];
    assert!((inertia.mean.unwrap() / INERTIA - 1.0).abs() < 0.02, "{inertia:?}");
}

#[test]
fn dry_friction_is_named_and_improves_held_out_episodes() {
    let answer = diagnosed(nothing, 0.08, exact);
    assert_eq!((answer.verdict, names(&answer)), (Verdict::Explained, vec!["joint_dry_friction"]));
    let effort = &answer.missing[0].parameters["effort"];
    assert!((effort.mean - 0.08).abs() < 0.004, "{effort:?}");
    let held_out = answer.fit.held_out.unwrap();
    let [before, after] = [held_out.before, held_out.after].map(|figures| figures.joints["arm"]);
    assert!(after.effort_rmse.unwrap() < 0.4 * before.effort_rmse.unwrap());
    assert!(after.window_position_rmse.unwrap() < before.window_position_rmse.unwrap());
}

#[test]
fn two_effects_are_named() {
    let answer = diagnosed(|_, q, _| 0.12 * (6.0 * q).sin(), 0.06, exact);
    let mut found = names(&answer);
    found.sort_unstable();
    assert_eq!((answer.verdict, found), (Verdict::Explained, vec!["joint_cogging", "joint_dry_friction"]));
    let cogging = answer.missing.iter().find(|effect| effect.effect == "joint_cogging").unwrap();
    let period = cogging.parameters["period"].mean;
    assert!((period / (std::f64::consts::TAU / 6.0) - 1.0).abs() < 0.01, "{period}");
}

#[test]
fn an_offset_of_the_reading_is_tied_to_friction_that_differs_by_direction() {
    let answer = diagnosed(nothing, 0.0, |effort| effort + 0.05);
    assert_eq!(answer.verdict, Verdict::Explained);
    assert!(answer.tied[0].contains(&"effort_bias:arm".to_owned()), "{:?}", answer.tied);
}

#[test]
fn a_disturbance_in_time_is_unexplained() {
    let answer = diagnosed(|t, _, _| 0.15 * (1.7 * t).sin(), 0.0, exact);
    assert_eq!((answer.verdict, names(&answer)), (Verdict::Unexplained, vec![]));
}

#[test]
fn the_answer_does_not_depend_on_the_units() {
    let extra: Extra = |_, q, _| 0.12 * (6.0 * q).sin();
    let of = |units| diagnosed_in_units(extra, 0.06, exact, units);
    let reference = of([1.0, 1.0]);
    for units in [[1024.0, 1.0], [1.0, 1.0 / 1024.0], [1.0 / 1024.0, 1024.0]] {
        let other = of(units);
        assert_eq!((other.verdict, names(&other)), (reference.verdict, names(&reference)), "{units:?}");
        for (a, b) in other.missing.iter().zip(&reference.missing) {
            assert!((a.probability - b.probability).abs() < 1e-3, "{units:?} {a:?}");
        }
    }
}
