//! Open-loop simulations of an axis whose commands are held, and that starts at rest.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use trundle_infer::Quiet;
use trundle_mechanism::{JointOutcome, diagnose_joints, motion};
use trundle_record::{Episode, JointMetadata, JointRecording};

const INERTIA: f64 = 4.0;
const DAMPING: f64 = 12.0;
const DT: f64 = 5e-4;
/// Steps for which a command is held.
const HOLD: usize = 20;

fn episode(index: usize) -> Episode {
    let (mut q, mut v, mut command) = (0.0, 0.0, 0.0);
    let mut columns: [Vec<f64>; 3] = Default::default();
    let phase = index as f64;
    for k in 0..20_000 {
        let t = k as f64 * DT;
        if k % HOLD == 0 {
            let wanted = 0.3 * ((3.1 * t + phase).sin() - phase.sin()) + 0.1 * (9.7 * t).sin();
            command = 900.0 * (wanted - q) - 60.0 * v;
            columns[0].push(t);
            columns[1].push((q * 1e6).round() * 1e-6);
            columns[2].push(command);
        }
        v += DT / INERTIA * (command - DAMPING * v);
        q += DT * v;
    }
    let mut episode = Episode { name: format!("episode_{index:02}"), ..Episode::default() };
    for (title, values) in ["t", "q_x", "effort_x"].into_iter().zip(columns) {
        episode.insert(title.to_owned(), values);
    }
    episode
}

fn outcome(at_rest: bool) -> JointOutcome {
    let metadata = JointMetadata::from_toml(&format!(
        "format = \"trundle-recording/2\"\nname = \"rail\"\n[mechanism]\naxis = \"slide\"\njoints = [\"x\"]\n\
         inertia = {INERTIA:?}\n[effort]\nsource = \"commanded\"\n[start]\nat_rest = {at_rest}\n\
         [split]\nheld_out = [\"episode_03\"]\n",
    ))
    .unwrap();
    let episodes = (0..4).map(episode).collect();
    let recording = JointRecording::new(metadata, episodes, BTreeMap::new()).unwrap();
    diagnose_joints(&recording, &motion(&recording).unwrap(), None, &[], &Quiet).unwrap()
}

#[test]
fn held_commands_act_at_their_time() {
    // To hold them for another step gives 4.8 mm.
    let error = outcome(false).answer.fit.held_out.unwrap().before.joints["x"].position_rmse.unwrap();
    assert!(error < 1e-3, "{error}");
}

#[test]
fn an_episode_that_starts_at_rest_is_simulated_from_rest() {
    let path = |at_rest: bool| outcome(at_rest).predictions["episode_03"][0].clone().unwrap();
    let (moving, resting) = (path(false), path(true));
    assert!(moving.t[0] > 0.01);
    assert_eq!((resting.t[0], resting.simulated[0]), (0.0, resting.observed[0]));
    let error = |k: usize| (resting.simulated[k] - resting.observed[k]).abs();
    assert!((0..10).all(|k| error(k) < 2e-5), "{:?}", (0..10).map(error).collect::<Vec<f64>>());
}
