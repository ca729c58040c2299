use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;

const SD: [f64; 3] = [5e-4, 5e-4, 1.7e-3];
const SLOW_SD: [f64; 3] = [2e-4, 2e-4, 7e-4];

/// Six seconds at 60 Hz: rest, then a push with a sudden start, a rotation and a sudden stop.
fn clean(seed: u64) -> (Vec<f64>, Vec<[f64; 3]>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |sd: f64| -> f64 {
        let z: f64 = StandardNormal.sample(&mut rng);
        sd * z
    };
    let t: Vec<f64> = (0..360).map(|i| f64::from(i) / 60.0).collect();
    let pose = |&t: &f64| {
        let s = (t - 1.0).clamp(0.0, 4.0);
        [0.3 * s + draw(SD[0]), 0.1 * s * s + draw(SD[1]), wrapped(3.0 + 0.4 * s + draw(SD[2]))]
    };
    let poses = t.iter().map(pose).collect();
    (t, poses)
}

fn outliers(statuses: &[PoseStatus]) -> Vec<usize> {
    (0..statuses.len()).filter(|&i| statuses[i] == PoseStatus::Outlier).collect()
}

#[test]
fn clean_poses_are_valid() {
    for seed in 0..40 {
        let (t, pose) = clean(seed);
        assert_eq!(outliers(&classify(&t, &pose, &SD, &SD)), Vec::<usize>::new(), "seed {seed}");
    }
}

#[test]
fn spikes_are_found_in_position_and_in_angle() {
    for seed in 0..20 {
        let (t, mut pose) = clean(seed);
        pose[150][0] += 0.01;
        pose[200][2] += 0.05;
        pose[320][1] -= 0.4;
        assert_eq!(outliers(&classify(&t, &pose, &SD, &SD)), [150, 200, 320], "seed {seed}");
    }
}

#[test]
fn a_constant_false_pose_is_found() {
    for (first, last) in [(100, 103), (100, 160), (0, 30), (330, 359)] {
        let (t, mut pose) = clean(1);
        for fake in &mut pose[first..=last] {
            *fake = [0.66854, -0.26052, 0.1];
        }
        let found: Vec<usize> = (first..=last).collect();
        assert_eq!(outliers(&classify(&t, &pose, &SD, &SD)), found);
    }
}

/// Three seconds at 10 Hz: a rest, a sudden start at `start`, s, and a glide that drag slows down.
fn blow(seed: u64, start: f64) -> (Vec<f64>, Vec<[f64; 3]>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |sd: f64| -> f64 {
        let z: f64 = StandardNormal.sample(&mut rng);
        sd * z
    };
    let t: Vec<f64> = (0..32).map(|i| 0.1 * f64::from(i)).collect();
    let pose = |&t: &f64| {
        let way = 1.0 - (-0.6 * (t - start).max(0.0)).exp();
        [draw(SLOW_SD[0]) - 0.37 * way, draw(SLOW_SD[1]) + 0.6 * way, draw(SLOW_SD[2]) + 0.01 * way]
    };
    let poses = t.iter().map(pose).collect();
    (t, poses)
}

/// A single pose before a sudden start could also be a spike.
#[test]
fn resting_poses_before_a_blow_are_valid() {
    for seed in 0..40 {
        for resting in 2..=10 {
            let (t, pose) = blow(seed, 0.1 * f64::from(resting) - 0.06);
            let found = outliers(&classify(&t, &pose, &SLOW_SD, &SLOW_SD));
            assert_eq!(found, Vec::<usize>::new(), "seed {seed}, {resting} poses at rest");
        }
    }
}

#[test]
fn a_noisy_burst_is_found() {
    let (t, mut pose) = clean(2);
    for burst in &mut pose[120..150] {
        burst[1] += 0.35;
    }
    assert_eq!(outliers(&classify(&t, &pose, &SD, &SD)), (120..150).collect::<Vec<_>>());
}

#[test]
fn held_values_are_masked_but_a_noiseless_rest_is_not() {
    let (t, mut pose) = clean(3);
    pose[100] = pose[99];
    pose[101] = pose[99];
    let statuses = classify(&t, &pose, &SD, &SD);
    let held: Vec<usize> = (0..360).filter(|&i| statuses[i] == PoseStatus::Held).collect();
    assert_eq!(held, [100, 101]);
    assert!(classify(&t, &pose, &SD, &[1e-6; 3]).iter().all(|v| *v != PoseStatus::Held));
    let resting = vec![[1.0, 2.0, 0.5]; 50];
    let times: Vec<f64> = (0..50).map(f64::from).collect();
    assert_eq!(classify(&times, &resting, &[1e-6; 3], &[1e-6; 3]), vec![PoseStatus::Valid; 50]);
}

#[test]
fn a_drop_out_is_not_a_jump() {
    let (t, pose) = clean(4);
    let keep: Vec<usize> = (0..360).filter(|i| !(150..210).contains(i)).collect();
    let t: Vec<f64> = keep.iter().map(|&i| t[i]).collect();
    let pose: Vec<[f64; 3]> = keep.iter().map(|&i| pose[i]).collect();
    assert!(outliers(&classify(&t, &pose, &SD, &SD)).is_empty());
}

#[test]
fn few_poses_are_valid() {
    let (t, pose) = clean(5);
    for n in 0..4 {
        assert_eq!(classify(&t[..n], &pose[..n], &SD, &SD), vec![PoseStatus::Valid; n]);
    }
}
