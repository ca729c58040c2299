//! Diagnoses of an axis whose recordings are integrated here, with formulas of this file.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use trundle_diagnose::Verdict;
use trundle_infer::Quiet;
use trundle_mechanism::{JointAnswer, diagnose_joints, motion};
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

/// A recording of eight episodes, of which the last two are held out; `effort` is added to `recording.toml`.
fn recording(
    extra: Extra,
    dry: f64,
    reading: fn(f64) -> f64,
    effort: &str,
    change: &dyn Fn(&mut Episode),
) -> JointRecording {
    let metadata = JointMetadata::from_toml(&format!(
        "format = \"trundle-recording/2\"\nname = \"bench\"\n[mechanism]\naxis = \"hinge\"\njoints = [\"arm\"]\n\
         {effort}[split]\nheld_out = [\"episode_06\", \"episode_07\"]\n",
    ))
    .unwrap();
    let one = |k: usize| {
        let mut episode = episode(k, extra, dry, reading);
        change(&mut episode);
        episode
    };
    JointRecording::new(metadata, (0..8).map(one).collect(), BTreeMap::new()).unwrap()
}

/// Multiply a column.
fn scale(episode: &mut Episode, title: &str, factor: f64) {
    episode.columns.get_mut(title).unwrap().iter_mut().for_each(|value| *value *= factor);
}

fn answer(recording: &JointRecording) -> JointAnswer {
    let motion = motion(recording).unwrap();
    diagnose_joints(recording, &motion, None, &[], &Quiet).unwrap().answer
}

fn diagnosed(extra: Extra, dry: f64, reading: fn(f64) -> f64) -> JointAnswer {
    answer(&recording(extra, dry, reading, "", &|_| {}))
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
    let [before, after] = [held_out.before, held_out.after].map(|errors| errors.joints["arm"]);
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
fn an_effort_that_repeats_faster_than_the_motion_is_named() {
    let found = diagnosed(|_, q, _| 0.2 * (q * std::f64::consts::TAU / 0.4).sin(), 0.0, exact);
    let bandwidth = found.fit.held_out.as_ref().map(|fit| fit.after.effort_bandwidth);
    assert_eq!(names(&found), ["joint_cogging"], "{:?} {bandwidth:?}", found.verdict);
    assert!((found.missing[0].parameters["period"].mean - 0.4).abs() < 1e-3);
    assert!(bandwidth.is_some_and(|bandwidth| bandwidth > 4.0), "{bandwidth:?}");
}

#[test]
fn a_disturbance_in_time_is_unexplained() {
    let answer = diagnosed(|t, _, _| 0.15 * (1.7 * t).sin(), 0.0, exact);
    assert_eq!((answer.verdict, names(&answer)), (Verdict::Unexplained, vec![]));
}

/// Dry friction and cogging.
fn two_effects(effort: &str, change: &dyn Fn(&mut Episode)) -> JointAnswer {
    answer(&recording(|_, q, _| 0.12 * (6.0 * q).sin(), 0.06, exact, effort, change))
}

fn assert_same(other: &JointAnswer, reference: &JointAnswer) {
    assert_eq!((other.verdict, names(other)), (reference.verdict, names(reference)));
    for (a, b) in other.missing.iter().zip(&reference.missing) {
        assert!((a.probability - b.probability).abs() < 1e-3, "{a:?}");
    }
}

#[test]
fn the_answer_does_not_depend_on_the_units() {
    let reference = two_effects("", &|_| {});
    for [length, force] in [[1024.0, 1.0], [1.0, 1.0 / 1024.0], [1.0 / 1024.0, 1024.0]] {
        let other = two_effects("", &|episode| {
            scale(episode, "q_arm", length);
            scale(episode, "effort_arm", force);
        });
        assert_same(&other, &reference);
    }
}

#[test]
fn the_answer_does_not_depend_on_the_recorded_unit_of_a_command() {
    let reference = two_effects("[effort]\nsource = \"commanded\"\n", &|_| {});
    let other = two_effects("[effort]\nsource = \"commanded\"\ngain = 32.0\n", &|episode| {
        scale(episode, "effort_arm", 1.0 / 32.0);
    });
    assert_same(&other, &reference);
    let [a, b] =
        [other, reference].map(|answer| answer.fit.held_out.unwrap().after.relative_effort_rmse.unwrap());
    assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
}

/// The recording without effects, its readings early by a number of samples.
fn early_readings(samples: f64) -> JointAnswer {
    answer(&recording(nothing, 0.0, exact, "", &|episode| {
        let column = episode.columns.get_mut("effort_arm").unwrap();
        let last = column.len() - 1;
        let at = |k: usize| {
            let place = (k as f64 + samples).min(last as f64);
            let (before, share) = (place as usize, place.fract());
            column[before] * (1.0 - share) + column[(before + 1).min(last)] * share
        };
        *column = (0..=last).map(at).collect();
    }))
}

#[test]
fn a_shift_within_half_a_sample_is_no_delay() {
    let within = early_readings(0.4);
    assert_eq!((within.verdict, names(&within)), (Verdict::Consistent, vec![]));
    let timing = within.nominal.after["timing:arm"].mean.unwrap();
    assert!((timing - 0.4 * 0.005).abs() < 5e-4, "{timing}");
    assert_eq!(names(&early_readings(4.0)), ["effort_delay"]);
}

#[test]
fn an_effect_that_leaves_much_of_the_misfit_is_less_probable() {
    let answer = diagnosed(|t, _, _| 0.02 * (1.7 * t).sin(), 0.08, exact);
    assert_eq!(names(&answer), ["joint_dry_friction"]);
    let (probability, explained) = (answer.missing[0].probability, answer.residual.explained["arm"]);
    assert!(explained < 0.45 && probability <= 2.0 * explained + 1e-9, "{probability} {explained}");
    // More probably wrong than right.
    let doubtful = diagnosed(|t, _, _| 0.03 * (1.7 * t).sin(), 0.08, exact);
    assert_eq!((doubtful.verdict, names(&doubtful)), (Verdict::Unexplained, vec![]));
    let well = diagnosed(nothing, 0.08, exact);
    assert!(well.residual.explained["arm"] > 0.8, "{:?}", well.residual.explained);
}

#[test]
fn a_residual_that_is_small_for_the_effort_but_not_for_the_noise_is_unexplained() {
    let verdict = |extra: Extra| diagnosed(extra, 0.0, exact).verdict;
    assert_eq!(verdict(|t, _, _| 0.03 * (1.7 * t).sin()), Verdict::Unexplained);
    assert_eq!(verdict(|t, _, _| 0.003 * (1.7 * t).sin()), Verdict::Consistent);
}

#[test]
fn held_out_episodes_change_no_name_and_no_value() {
    let reference = two_effects("", &|_| {});
    let other = two_effects("", &|episode| {
        if *episode.name >= *"episode_06" {
            let positions = episode.columns.get_mut("q_arm").unwrap();
            positions.iter_mut().enumerate().for_each(|(k, q)| *q = 3.0 * *q + 0.05 * noise(k));
            scale(episode, "effort_arm", -0.3);
        }
    });
    // The order of the effects is that of their contributions in the held-out episodes.
    let sorted = |mut answer: JointAnswer| {
        answer.missing.sort_by(|a, b| a.effect.cmp(&b.effect));
        answer
    };
    let (other, reference) = (sorted(other), sorted(reference));
    assert_same(&other, &reference);
    for (name, parameter) in &reference.nominal.after {
        assert_eq!(other.nominal.after[name].mean, parameter.mean, "{name}");
    }
    for (a, b) in other.missing.iter().zip(&reference.missing) {
        assert_eq!(a.parameters, b.parameters);
    }
}

#[test]
fn a_small_effect_is_immaterial() {
    let answer = answer(&recording(nothing, 0.012, exact, "", &|episode| {
        let efforts = episode.columns.get_mut("effort_arm").unwrap();
        efforts.iter_mut().enumerate().for_each(|(k, effort)| *effort += 0.1 * noise(k * k));
    }));
    let found: Vec<&str> = answer.immaterial.iter().map(|effect| effect.effect.as_str()).collect();
    assert_eq!((answer.verdict, names(&answer)), (Verdict::Consistent, vec![]));
    assert_eq!(found, ["joint_dry_friction"]);
}

/// Command of a drive whose effort falls by a tenth of it per N·m.
fn command_of(effort: f64) -> f64 {
    (1.0 - (1.0 - 0.4 * effort.abs()).sqrt()) / 0.2 * effort.signum()
}

#[test]
fn a_drooping_drive_is_named_in_any_recorded_unit() {
    for gain in [1.0, 32.0] {
        let effort = format!("[effort]\nsource = \"commanded\"\ngain = {gain:?}\n");
        let rescale = |episode: &mut Episode| scale(episode, "effort_arm", 1.0 / gain);
        let answer = answer(&recording(nothing, 0.0, command_of, &effort, &rescale));
        assert_eq!(
            (answer.verdict, names(&answer)),
            (Verdict::Explained, vec!["drive_gain_droop"]),
            "{gain}"
        );
        let droop = answer.missing[0].parameters["droop"].mean;
        assert!((0.03..0.3).contains(&droop), "{gain} {droop}");
    }
}

#[test]
fn smooth_reversals_add_no_name_to_dry_friction() {
    let answer = diagnosed(|_, _, v| -0.08 * (v / 0.1).tanh(), 0.0, exact);
    assert_eq!((answer.verdict, names(&answer)), (Verdict::Explained, vec!["joint_dry_friction"]));
}

/// An episode in which the drive delivers at most 0.95 N·m; `size` is that of the commands.
fn limited_episode(index: usize, size: f64) -> Episode {
    let (mut q, mut v, phase) = (0.0, 0.0, index as f64);
    let mut columns: [Vec<f64>; 3] = Default::default();
    for k in 0..8000 {
        let t = k as f64 * DT;
        let command: f64 =
            size * (0.4 * (3.1 * t + phase).sin() + 0.3 * (7.3 * t + 2.0 * phase).sin()) - 0.3 * q;
        if k % SAMPLE == 0 {
            columns[0].push(t);
            columns[1].push(q + 1e-4 * noise(index * 100_000 + k));
            columns[2].push(command);
        }
        v += DT / INERTIA * (command.clamp(-0.95, 0.95) - DAMPING * v);
        q += DT * v;
    }
    let mut episode = Episode { name: format!("episode_{index:02}"), ..Episode::default() };
    for (title, values) in ["t", "q_arm", "effort_arm"].into_iter().zip(columns) {
        episode.insert(title.to_owned(), values);
    }
    episode
}

#[test]
fn a_drive_that_saturates_in_one_episode_only_is_named() {
    let metadata = JointMetadata::from_toml(
        "format = \"trundle-recording/2\"\nname = \"bench\"\n[mechanism]\naxis = \"hinge\"\njoints = [\"arm\"]\n\
         [effort]\nsource = \"commanded\"\n",
    )
    .unwrap();
    // Only the third episode has commands above the limit.
    let episodes = (0..6).map(|k| limited_episode(k, if k == 2 { 1.2 } else { 1.0 })).collect();
    let answer = answer(&JointRecording::new(metadata, episodes, BTreeMap::new()).unwrap());
    assert_eq!((answer.verdict, names(&answer)), (Verdict::Explained, vec!["effort_saturation"]));
    let (probability, limit) = (answer.missing[0].probability, &answer.missing[0].parameters["limit"]);
    assert!(probability > 0.9 && (limit.mean / 0.95 - 1.0).abs() < 0.02, "{probability} {limit:?}");
}
