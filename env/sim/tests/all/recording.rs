//! Recordings of scenarios: consistent readings, reproducible by seed, without hidden effects.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};

use trundle_model::{Clock, Effect, Kind, State, transport};
use trundle_record::{Contact, Gripper, Precontact, Recording};
use trundle_sim::{DriveMode, GripperPayload, Push, Scenario, simulate};

fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/experiments/demo.toml")
}

fn recording(change: impl FnOnce(&mut Scenario), seed: u64) -> Recording {
    let (mut scenario, model) = Scenario::read(&demo()).unwrap();
    change(&mut scenario);
    simulate(&scenario, &model, seed).unwrap()
}

fn silence(scenario: &mut Scenario) {
    scenario.sensor.force_noise = 0.0;
    scenario.sensor.torque_noise = 0.0;
    scenario.tracker.noise = [0.0; 3];
    scenario.tracker.drop_out = 0.0;
}

#[test]
fn a_seed_determines_the_recording() {
    assert_eq!(recording(|_| {}, 3), recording(|_| {}, 3));
    assert_ne!(recording(|_| {}, 3), recording(|_| {}, 4));
}

#[test]
fn the_metadata_do_not_reveal_hidden_effects() {
    let text = recording(|_| {}, 0).metadata.to_toml().unwrap();
    for kind in Kind::ALL {
        assert!(!text.contains(kind.spec().kind), "{text}");
    }
    for word in ["mu_", "180", "320", "locked", "22.0"] {
        assert!(!text.contains(word), "{word} in {text}");
    }
}

#[test]
fn a_sensor_with_a_gripper_records_six_axes() {
    let bare = recording(silence, 0);
    let loaded = recording(
        |s| {
            silence(s);
            s.sensor.gripper =
                Some(GripperPayload { mass: 1.2, com: [0.01, -0.02, 0.06], offset: [3.0, 0.1, 0.2] });
        },
        0,
    );
    let weight = 1.2 * 9.80665;
    let wrench = loaded.episodes[0].wrench().unwrap();
    for value in &wrench.value {
        let [_, _, fz, tx, ty, _] = *value;
        for (read, expected) in [(fz, 3.0 + weight), (tx, 0.1 - 0.02 * weight), (ty, 0.2 - 0.01 * weight)] {
            assert!((read - expected).abs() < 1e-12, "{value:?}");
        }
    }
    assert_eq!(loaded.metadata.wrench.gripper_mass, Some(1.2));
    let planar = |r: &Recording| -> Vec<[f64; 2]> {
        r.episodes[0].wrench().unwrap().value.iter().map(|w| [w[0], w[5]]).collect()
    };
    assert!(planar(&loaded) == planar(&bare), "the weight of a level gripper is in the other three axes");
    assert!(!bare.episodes[0].columns.contains_key("force_z"));
}

#[test]
fn a_point_contact_is_stated_in_the_recording() {
    let tip = |y: f64, angle: f64| Push {
        start: [0.0; 3],
        grasp: [-0.6, y, angle],
        drive: DriveMode::PointContact,
        knots: vec![
            [0.0, 0.1, 0.0, 0.0],
            [1.5, 0.1, 0.0, 0.0],
            [1.5001, -0.1, 0.0, 0.0],
            [3.0, -0.1, 0.0, 0.0],
        ],
    };
    let pushed = |pushes: Vec<Push>| {
        let (mut scenario, model) = Scenario::read(&demo()).unwrap();
        silence(&mut scenario);
        (scenario.random, scenario.held_out, scenario.pushes) = (None, 0, pushes);
        simulate(&scenario, &model, 0)
    };
    let recording = pushed(vec![tip(0.1, 0.0)]).unwrap();
    assert_eq!(recording.metadata.wrench.contact, Contact::Point);
    let (object, wrench) = (recording.episodes[0].object().unwrap(), recording.episodes[0].wrench().unwrap());
    assert!(object.value.last().unwrap()[0] > 0.02, "the object must move forward");
    let offset = recording.episodes[0].wrench().unwrap().value[0];
    let ahead: Vec<f64> = wrench.value.iter().map(|w| w[0] - offset[0]).collect();
    assert!(ahead.iter().all(|f| *f > -1e-9), "the tip must not pull");
    assert!(ahead[ahead.len() - 5..].iter().all(|f| f.abs() < 1e-9), "a receding tip must not exert a force");
    let mixed = Push { drive: DriveMode::Velocity, ..tip(0.1, 0.0) };
    for (pushes, word) in [
        (vec![tip(0.1, 0.0), mixed], "push.drive"),
        (vec![tip(0.1, 3.0)], "push.grasp"),
        (vec![Push { grasp: [0.0; 3], ..tip(0.0, 0.0) }], "push.grasp"),
    ] {
        assert!(pushed(pushes).unwrap_err().to_string().contains(word));
    }
}

#[test]
fn streams_have_their_rates_and_their_noise() {
    let noisy = recording(|s| s.random.as_mut().unwrap().count = 3, 0);
    for episode in &noisy.episodes {
        let wrench = episode.wrench().unwrap();
        assert!((wrench.t.len() as f64 - 6.4 * 125.0).abs() < 2.0);
        let poses = episode.object().unwrap().t.len() as f64;
        assert!(poses > 0.95 * 6.4 * 60.0 && poses < 6.4 * 60.0 + 1.0, "{poses} poses with drop-outs");
        let tare: Vec<f64> =
            wrench.t.iter().zip(&wrench.value).filter(|(t, _)| **t < 0.4).map(|(_, w)| w[0]).collect();
        let mean = tare.iter().sum::<f64>() / tare.len() as f64;
        assert!((mean - 1.7).abs() < 0.3, "offset {mean}");
        let variance = tare.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / tare.len() as f64;
        assert!((0.25..0.55).contains(&variance.sqrt()), "noise {}", variance.sqrt());
    }
}

/// The recorded wrench, transformed to the object by the recorded poses and integrated with the model, reproduces the
/// recorded motion. This verifies readings, frames, signs and clocks.
#[test]
fn the_recorded_wrench_reproduces_the_recorded_motion() {
    let (mut scenario, model) = Scenario::read(&demo()).unwrap();
    silence(&mut scenario);
    // One sample per step: the error is due to rounding and the gripper's coupling, not to interpolation.
    scenario.step = 1e-3;
    scenario.tracker.rate = 1000.0;
    scenario.sensor.rate = 1000.0;
    let plant = model.resolved().unwrap();
    for episode in simulate(&scenario, &model, 1).unwrap().episodes {
        let object = episode.object().unwrap();
        let Some(Gripper::Level(gripper)) = episode.gripper() else { panic!("a level gripper") };
        let readings = episode.wrench().unwrap().value;
        let offset = readings[0];
        let wrench = |k: usize| {
            let ([x, y, theta], [gx, gy, gtheta]) = (object.value[k], gripper.value[k]);
            let (sin, cos) = theta.sin_cos();
            let (dx, dy) = (gx - x, gy - y);
            let frame = [cos * dx + sin * dy, cos * dy - sin * dx, gtheta - theta];
            transport([0, 1, 5].map(|axis| readings[k][axis] - offset[axis]), frame)
        };
        let mut state = State::at_rest(object.value[0]);
        for k in 1..object.t.len() {
            let (before, after) = (wrench(k - 1), wrench(k));
            let clock = Clock::since_contact(object.t[k - 1] - scenario.sensor.precontact);
            let mean = [0, 1, 2].map(|axis| (before[axis] + after[axis]) / 2.0);
            state = plant.step(&state, mean, clock, object.t[k] - object.t[k - 1]);
        }
        let end = object.value.last().unwrap();
        let miss = (state.pose[0] - end[0]).hypot(state.pose[1] - end[1]);
        assert!(miss < 1e-4, "{}: {miss} m after {} s", episode.name, object.t.last().unwrap());
    }
}

#[test]
fn random_pushes_have_reasonable_distances_and_forces() {
    let recording = recording(silence, 0);
    for episode in &recording.episodes {
        let poses = episode.object().unwrap().value;
        let reach = |k: usize| {
            let all = poses.iter().map(|p| p[k]);
            all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
        };
        let distance = reach(0).hypot(reach(1));
        assert!((0.1..3.0).contains(&distance), "{}: {distance} m", episode.name);
        let loads = episode.wrench().unwrap().value;
        let largest = loads.iter().map(|w| w[0].hypot(w[1])).fold(0.0, f64::max);
        assert!((20.0..400.0).contains(&largest), "{}: {largest} N", episode.name);
    }
}

#[test]
fn errors_of_scenarios_name_the_cause() {
    let text = std::fs::read_to_string(demo()).unwrap();
    let folder = std::env::temp_dir().join(format!("trundle-scenario-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("experiments")).unwrap();
    std::fs::create_dir_all(folder.join("objects")).unwrap();
    std::fs::copy(
        demo().with_file_name("../objects/office_table.toml"),
        folder.join("objects/office_table.toml"),
    )
    .unwrap();
    let path = folder.join("experiments/demo.toml");
    for (from, to, words) in [
        ("held_out = 2", "hold_out = 2", vec!["hold_out", "held_out"]),
        ("held_out = 2", "held_out = 8", vec!["held_out = 8", "one episode to fit"]),
        ("rate = 125.0", "rate = -1.0", vec!["sensor.rate = -1", "positive"]),
        ("force = 14.0", "farce = 14.0", vec!["farce", "static_force"]),
        ("mu_x = 180.0", "", vec!["viscous_wheel.mu_x", "no value"]),
        ("trundle-scenario/1", "trundle-scenario/7", vec!["trundle-scenario/7", "trundle-scenario/1"]),
        ("office_table.toml", "nothing.toml", vec!["nothing.toml", "cannot be read"]),
        ("[random]", "[randy]", vec!["randy", "random"]),
    ] {
        std::fs::write(&path, text.replace(from, to)).unwrap();
        let message = Scenario::read(&path).unwrap_err().to_string();
        for word in words {
            assert!(message.contains(word), "{message} should say {word}");
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn halving_the_step_moves_the_end_by_less_than_the_tracker_noise() {
    let ends = |step: f64| {
        let recording = recording(
            |scenario| {
                silence(scenario);
                scenario.step = step;
            },
            0,
        );
        let last = |e: &trundle_record::Episode| e.object().unwrap().value.last().copied().unwrap();
        recording.episodes.iter().map(last).collect::<Vec<_>>()
    };
    for (coarse, fine) in ends(2.5e-4).iter().zip(ends(1.25e-4)) {
        let moved = (coarse[0] - fine[0]).hypot(coarse[1] - fine[1]);
        assert!(moved < 3e-4, "{moved} m");
    }
}

#[test]
fn a_leading_clock_shortens_the_precontact_interval() {
    let early = |delay: f64| {
        let (mut scenario, model) = Scenario::read(&demo()).unwrap();
        scenario.random.as_mut().unwrap().count = 3;
        let latency = Effect::free(Kind::Latency).with("delay", Some(delay));
        simulate(&scenario, &model.with(latency), 0)
    };
    let recording = early(-0.1).unwrap();
    let Some(Precontact::Everywhere([_, end])) = recording.metadata.wrench.precontact else { panic!() };
    assert!((end - 0.3).abs() < 1e-12, "{end}");
    let loads = recording.episodes[0].wrench().unwrap();
    let first =
        loads.t.iter().zip(&loads.value).find(|(_, w)| (w[0] - 1.7).hypot(w[1] + 0.9) > 5.0).unwrap().0;
    assert!((0.3..0.4).contains(first), "first reading of the push at {first} s");
    let message = early(-0.35).unwrap_err().to_string();
    assert!(message.contains("latency.delay = -0.35") && message.contains("sensor.precontact"), "{message}");
}

#[test]
fn the_demo_needs_no_file() {
    let (scenario, model) = Scenario::demo().unwrap();
    assert_eq!(simulate(&scenario, &model, 0).unwrap(), recording(|_| {}, 0));
}
