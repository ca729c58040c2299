//! Preparation of synthetic recordings with known truth.

use std::collections::BTreeMap;

use nalgebra::{UnitQuaternion, Vector3};

use super::*;
use crate::episode::Episode;
use crate::metadata::Metadata;

const HEAD: &str = r#"
format = "trundle-recording/1"
name = "made"
[object]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 20.0
"#;

const OFFSET: [f64; 6] = [3.0, -2.0, 8.0, 0.4, -0.3, 0.2];

fn metadata(wrench: &str) -> Metadata {
    toml::from_str(&format!("{HEAD}[wrench]\n{wrench}")).unwrap()
}

fn columns<const N: usize>(names: [&str; N], rows: &[[f64; N]]) -> BTreeMap<String, Vec<f64>> {
    (0..N).map(|k| (names[k].to_owned(), rows.iter().map(|row| row[k]).collect())).collect()
}

/// The object rotates slowly, starting at 1 rad. The gripper holds it at (0.5, 0.2) of its frame, rotated by -0.4 rad.
fn object_pose(t: f64) -> [f64; 3] {
    let s = (t - 1.0).max(0.0);
    [0.1 * s * s, 0.3, 1.0 + 0.2 * s]
}

const GRASP: [f64; 3] = [0.5, 0.2, -0.4];

fn gripper_pose(t: f64) -> [f64; 3] {
    let [x, y, theta] = object_pose(t);
    let (sin, cos) = theta.sin_cos();
    [x + cos * GRASP[0] - sin * GRASP[1], y + sin * GRASP[0] + cos * GRASP[1], theta + GRASP[2]]
}

/// Planar push in sensor axes.
fn push(t: f64) -> [f64; 3] {
    if t < 1.0 { [0.0; 3] } else { [12.0, -3.0, 0.7] }
}

const TIMES: usize = 300;

fn time(i: usize) -> f64 {
    i as f64 * 0.01
}

fn level_episode(reading: impl Fn(f64) -> [f64; 3]) -> Episode {
    let names = [
        "object_x",
        "object_y",
        "object_theta",
        "gripper_x",
        "gripper_y",
        "gripper_theta",
        "force_x",
        "force_y",
        "torque_z",
    ];
    let row = |i: usize| {
        let t = time(i);
        let ([a, b, c], [d, e, f], [g, h, k]) = (object_pose(t), gripper_pose(t), reading(t));
        [a, b, wrapped(c), d, e, wrapped(f), g, h, k]
    };
    let rows: Vec<[f64; 9]> = (0..TIMES).map(row).collect();
    Episode {
        name: "episode_00".into(),
        t: (0..TIMES).map(time).collect(),
        columns: columns(names, &rows),
        notes: BTreeMap::new(),
    }
}

fn recording(wrench: &str, episode: Episode) -> Recording {
    Recording { metadata: metadata(wrench), episodes: vec![episode] }
}

fn assert_close(a: &[f64], b: &[f64], tolerance: f64) {
    assert!(a.iter().zip(b).all(|(x, y)| (x - y).abs() < tolerance), "{a:?} {b:?}");
}

const RAW: &str = "frame = \"sensor\"\nsign = \"on_sensor\"\nraw = true\nprecontact = [0.0, 0.95]";

#[test]
fn a_raw_reaction_is_tared_and_negated() {
    let episode = level_episode(|t| [0, 1, 2].map(|k| -push(t)[k] + [OFFSET[0], OFFSET[1], OFFSET[5]][k]));
    let dataset = prepare(&recording(RAW, episode)).unwrap();
    let prepared = &dataset.training[0];
    for sample in &prepared.wrench {
        assert_close(&sample.reading, &push(sample.t), 1e-9);
        assert_close(&sample.frame, &GRASP, 3e-3);
    }
    let last = prepared.wrench.last().unwrap().on_object();
    let (sin, cos) = (-0.4_f64).sin_cos();
    let force = [cos * 12.0 + sin * 3.0, sin * 12.0 - cos * 3.0];
    assert_close(&last, &[force[0], force[1], 0.5 * force[1] - 0.2 * force[0] + 0.7], 5e-2);
    assert!((prepared.contact - 1.0).abs() < 0.011, "{}", prepared.contact);
    assert_eq!(dataset.body.mass, 20.0);
}

#[test]
fn all_frames_and_references_give_the_same_wrench() {
    let episode = level_episode(push);
    let prepared = |wrench: &str| prepare(&recording(wrench, episode.clone())).unwrap().training.remove(0);
    let at = 250;
    let t = time(at);
    let theta = object_pose(t)[2];
    // The same wrench published in all axes and about all points is read in sensor axes.
    for (wrench, published) in [
        ("frame = \"sensor\"\nreference = \"sensor\"\nsign = \"on_object\"", GRASP),
        ("frame = \"sensor\"\nreference = \"object\"\nsign = \"on_object\"", [0.0, 0.0, GRASP[2]]),
        ("frame = \"object\"\nreference = \"object\"\nsign = \"on_object\"", [0.0; 3]),
        ("frame = \"object\"\nreference = \"sensor\"\nsign = \"on_object\"", [GRASP[0], GRASP[1], 0.0]),
        ("frame = \"world\"\nreference = \"object\"\nsign = \"on_object\"", [0.0, 0.0, -theta]),
        ("frame = \"world\"\nreference = \"sensor\"\nsign = \"on_object\"", [GRASP[0], GRASP[1], -theta]),
    ] {
        let sample = &prepared(wrench).wrench[at];
        assert_close(&sample.frame, &GRASP, 3e-3);
        assert_close(&sample.on_object(), &planar_transform(&published, &push(t)), 1e-2);
    }
    let mut without_gripper = level_episode(push);
    without_gripper.columns.retain(|name, _| !name.starts_with("gripper"));
    let world = "frame = \"world\"\nreference = \"object\"\nsign = \"on_object\"";
    let sample = &prepare(&recording(world, without_gripper)).unwrap().training[0].wrench[at];
    assert_eq!(sample.reading, push(t), "without a gripper pose readings stay as published");
    assert_close(&sample.frame, &[0.0, 0.0, -theta], 1e-5);
}

#[test]
fn a_point_contact_without_torque_acts_at_the_gripper() {
    let mut episode = level_episode(push);
    episode.columns.remove("torque_z");
    let wrench = "frame = \"object\"\nreference = \"object\"\nsign = \"on_object\"\ncontact = \"point\"";
    let prepared = prepare(&recording(wrench, episode)).unwrap().training.remove(0);
    let sample = &prepared.wrench[250];
    assert_close(&sample.frame, &GRASP, 3e-3);
    let [fx, fy, _] = push(time(250));
    assert_close(&sample.on_object(), &[fx, fy, GRASP[0] * fy - GRASP[1] * fx], 1e-2);
}

#[test]
fn readings_use_the_pose_at_their_time_or_the_latest_pose() {
    let mut episode = level_episode(push);
    // Poses only in every tenth row, starting with the tenth.
    for (name, column) in &mut episode.columns {
        if name.starts_with("object") || name.starts_with("gripper") {
            for i in (0..TIMES).filter(|i| i % 10 != 0 || *i == 0) {
                column[i] = f64::NAN;
            }
        }
    }
    let world = "frame = \"world\"\nreference = \"object\"\nsign = \"on_object\"";
    for name in ["gripper_x", "gripper_y", "gripper_theta"] {
        episode.columns.remove(name);
    }
    let prepared = |wrench_pose| {
        let options = Options { wrench_pose, ..Options::default() };
        prepare_with(&recording(world, episode.clone()), options).unwrap().training.remove(0)
    };
    let (latest, own) = (prepared(WrenchPose::Latest), prepared(WrenchPose::OwnTime));
    assert_eq!(latest.counts.before_first_pose, 10);
    for (i, (latest, own)) in latest.wrench.iter().zip(&own.wrench).enumerate() {
        let pose = time((i / 10 * 10).max(10));
        assert_close(&[latest.frame[2]], &[wrapped(-object_pose(pose)[2])], 1e-9);
        assert_eq!(latest.frame_noise, [0.0; 3]);
        if (10..290).contains(&i) {
            assert_close(&[own.frame[2]], &[wrapped(-object_pose(time(i))[2])], 1e-2);
        }
    }
    assert!(own.wrench[155].frame_noise[0] > 0.0, "the pose between samples is uncertain");
}

/// An episode with raw readings (with an offset) of a 1.2 kg gripper that rolls and pitches while it pushes.
fn tilting_episode(name: &str, start: (f64, f64), tilting: f64) -> Episode {
    let attitude = |t: f64| {
        let s = tilting * (t - 1.0).max(0.0);
        UnitQuaternion::from_euler_angles(start.0 + s, start.1 - 0.5 * s, gripper_pose(t)[2])
    };
    let com = Vector3::new(0.01, -0.02, 0.06);
    let row = |i: usize| {
        let t = time(i);
        let (q, [x, y, _]) = (attitude(t), gripper_pose(t));
        let gravity = q.inverse_transform_vector(&Vector3::new(
            0.0,
            0.0,
            -1.2 * trundle_model::STANDARD_GRAVITY_M_PER_S2,
        ));
        let moment = com.cross(&gravity);
        let [fx, fy, tz] = push(t);
        // The push is horizontal; it is given along the heading and transformed to the axes of the tilted sensor.
        let pose = transform::GripperPose { t, position: [x, y], attitude: q };
        let level = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), pose.heading());
        let force = q.inverse_transform_vector(&(level * Vector3::new(fx, fy, 0.0)));
        let torque = q.inverse_transform_vector(&Vector3::new(0.0, 0.0, tz));
        let load = [0, 1, 2].map(|k| force[k] - gravity[k] + OFFSET[k]);
        let turn = [0, 1, 2].map(|k| torque[k] - moment[k] + OFFSET[3 + k]);
        let [a, b, c] = object_pose(t);
        [a, b, c, x, y, 0.8, q.w, q.i, q.j, q.k, load[0], load[1], load[2], turn[0], turn[1], turn[2]]
    };
    let names = [
        "object_x",
        "object_y",
        "object_theta",
        "gripper_x",
        "gripper_y",
        "gripper_z",
        "gripper_qw",
        "gripper_qx",
        "gripper_qy",
        "gripper_qz",
        "force_x",
        "force_y",
        "force_z",
        "torque_x",
        "torque_y",
        "torque_z",
    ];
    let rows: Vec<[f64; 16]> = (0..TIMES).map(row).collect();
    Episode {
        name: name.into(),
        t: (0..TIMES).map(time).collect(),
        columns: columns(names, &rows),
        notes: BTreeMap::new(),
    }
}

const TILTING: &str = "frame = \"sensor\"\nsign = \"on_object\"\nraw = true\nprecontact = [0.0, 0.95]\n";

fn assert_pushes(dataset: &Dataset) {
    for sample in dataset.episodes().flat_map(|e| &e.wrench) {
        assert_close(&sample.reading, &push(sample.t), 1e-6);
        assert_close(&sample.frame[..2], &GRASP[..2], 3e-3);
    }
}

#[test]
fn a_tilting_gripper_of_known_weight_is_tared() {
    let wrench = format!("{TILTING}gripper_mass = 1.2\ngripper_com = [0.01, -0.02, 0.06]");
    let dataset = prepare(&recording(&wrench, tilting_episode("a", (0.1, 0.2), 0.15))).unwrap();
    assert_pushes(&dataset);
}

#[test]
fn a_tilting_gripper_is_weighed_at_several_attitudes() {
    let starts = [(0.0, 0.0), (0.3, 0.0), (0.0, 0.3), (-0.2, 0.2)];
    let episodes: Vec<Episode> =
        starts.iter().enumerate().map(|(i, &s)| tilting_episode(&format!("e{i}"), s, 0.1)).collect();
    let dataset = prepare(&Recording { metadata: metadata(TILTING), episodes }).unwrap();
    assert_pushes(&dataset);
}

#[test]
fn a_tilting_gripper_of_unknown_weight_is_refused() {
    let error = prepare(&recording(TILTING, tilting_episode("a", (0.1, 0.2), 0.15))).unwrap_err();
    let sentence = error.to_string();
    assert!(sentence.contains("gripper_mass") && sentence.starts_with("episode a"), "{sentence}");
    assert_pushes(&prepare(&recording(TILTING, tilting_episode("a", (0.1, 0.2), 0.0))).unwrap());
}

#[test]
fn equation_12_is_wrong_with_an_offset() {
    let recording = recording(TILTING, tilting_episode("a", (0.0, 0.0), 0.15));
    let by_equation_12 =
        prepare_with(&recording, Options { tare: TareMethod::Equation12, ..Options::default() }).unwrap();
    let last = by_equation_12.training[0].wrench.last().unwrap();
    let error = (last.reading[0] - push(last.t)[0]).hypot(last.reading[1] - push(last.t)[1]);
    assert!(error > 0.5, "equation 12 rotates the offset with the gripper");
}

#[test]
fn a_tare_without_samples_is_refused() {
    let wrench = RAW.replace("[0.0, 0.95]", "[7.0, 8.0]");
    let sentence = prepare(&recording(&wrench, level_episode(push))).unwrap_err().to_string();
    assert!(sentence.contains("7") && sentence.contains("precontact"), "{sentence}");
}

#[test]
fn an_object_whose_first_pose_comes_after_contact_is_not_at_rest() {
    let prepared = |lost: f64| {
        let mut episode = level_episode(push);
        for (name, column) in &mut episode.columns {
            if name.starts_with("object_") {
                column.iter_mut().take((lost / 0.01) as usize).for_each(|value| *value = f64::NAN);
            }
        }
        let dataset = prepare(&recording(RAW, episode)).unwrap();
        dataset.training.into_iter().chain(dataset.held_out).next().unwrap()
    };
    assert!(prepared(0.5).at_rest);
    let late = prepared(1.8);
    assert!(!late.at_rest);
    assert!((late.first_twist[2] - 0.2).abs() < 0.05, "{:?}", late.first_twist);
}

#[test]
fn no_force_no_motion_and_one_sample_do_not_panic() {
    let mut one = level_episode(push);
    one.t.truncate(1);
    one.columns.values_mut().for_each(|column| column.truncate(1));
    let resting = level_episode(|_| [0.0; 3]);
    for episode in [one, resting] {
        let dataset = prepare(&recording("frame = \"object\"\nsign = \"on_object\"", episode)).unwrap();
        let prepared = &dataset.training[0];
        assert!(prepared.contact.is_finite() && dataset.noise.force > 0.0);
        assert!(prepared.motion(&dataset.noise).iter().all(|m| m.twist.iter().all(|v| v.is_finite())));
    }
}

#[test]
fn an_episode_without_a_pose_is_refused() {
    let mut episode = level_episode(push);
    for name in ["object_x", "object_y", "object_theta"] {
        episode.columns.get_mut(name).unwrap().fill(f64::NAN);
    }
    let sentence = prepare(&recording(RAW, episode)).unwrap_err().to_string();
    assert!(sentence.contains("episode_00") && sentence.contains("pose"), "{sentence}");
}

#[test]
fn the_mass_guess_has_the_right_magnitude() {
    let mut meta = metadata("frame = \"world\"\nreference = \"object\"\nsign = \"on_object\"");
    meta.object.mass = None;
    // From 1 s on, object_pose accelerates with 0.2 m/s²: 4 N at 20 kg.
    let episode = level_episode(|t| if t < 1.0 { [0.0; 3] } else { [4.0, 0.0, 0.0] });
    let dataset = prepare(&Recording { metadata: meta, episodes: vec![episode] }).unwrap();
    assert!((10.0..40.0).contains(&dataset.body.mass), "{}", dataset.body.mass);
    assert_eq!(dataset.mass_given, None);
}
