use nalgebra::UnitQuaternion;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trundle_model::STANDARD_GRAVITY_M_PER_S2;

use super::*;

const OFFSET: Wrench6 = [3.0, -2.0, 8.0, 0.4, -0.3, 0.2];

fn attitude(roll: f64, pitch: f64, yaw: f64) -> GripperPose {
    GripperPose {
        t: 0.0,
        position: [0.4, -0.2],
        attitude: UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    }
}

fn gripper() -> Weight {
    Weight {
        force: 1.2 * STANDARD_GRAVITY_M_PER_S2,
        moment: Vector3::new(0.01, -0.02, 0.06) * 1.2 * STANDARD_GRAVITY_M_PER_S2,
    }
}

/// Reading with sign "on_object" of a sensor with an offset, while the gripper pushes with `push`.
fn reading(pose: &GripperPose, push: &Wrench6) -> Wrench6 {
    plus(&minus(&OFFSET, &gripper().wrench(pose)), push)
}

fn unloaded(pose: GripperPose) -> UnloadedReading {
    UnloadedReading { wrench: reading(&pose, &[0.0; 6]), pose }
}

fn assert_close(a: &Wrench6, b: &Wrench6, tolerance: f64) {
    assert!(a.iter().zip(b).all(|(x, y)| (x - y).abs() < tolerance), "{a:?} {b:?}");
}

#[test]
fn weight_matches_a_hand_calculation() {
    // Pitched by 90° about y, the sensor's x points down: 1.2 kg act along x, with the lever arms y and z of the centre.
    let load = gripper().wrench(&attitude(0.0, std::f64::consts::FRAC_PI_2, 0.0));
    let n = 1.2 * STANDARD_GRAVITY_M_PER_S2;
    assert_close(&load, &[n, 0.0, 0.0, 0.0, 0.06 * n, 0.02 * n], 1e-9);
}

#[test]
fn a_known_weight_is_subtracted_at_any_attitude() {
    let push = [10.0, 1.0, -2.0, 0.1, 0.2, 0.3];
    let weight = gripper();
    let tare = Tare::new(TareMethod::Separated, &[unloaded(attitude(0.0, 0.0, 0.3))], Some(&weight)).unwrap();
    let tilted = attitude(0.3, -0.2, 1.0);
    assert_close(&tare.apply(&reading(&tilted, &push), &tilted), &push, 1e-9);
}

#[test]
fn several_attitudes_determine_the_weight() {
    let poses = [(0.0, 0.0, 0.0), (0.4, 0.0, 0.5), (0.0, -0.3, 1.0), (0.2, 0.2, -2.0)];
    let readings: Vec<UnloadedReading> = poses.iter().map(|&(r, p, y)| unloaded(attitude(r, p, y))).collect();
    let together = weigh(std::slice::from_ref(&readings)).unwrap();
    let apart: Vec<Vec<UnloadedReading>> = readings.into_iter().map(|r| vec![r]).collect();
    for weight in [together, weigh(&apart).unwrap()] {
        assert!((weight.force - 1.2 * STANDARD_GRAVITY_M_PER_S2).abs() < 1e-9);
        assert!((weight.moment - gripper().moment).norm() < 1e-5);
    }
}

#[test]
fn rotation_about_the_vertical_does_not_determine_the_weight() {
    assert_eq!(weigh(&[vec![unloaded(attitude(0.0, 0.0, 0.0)), unloaded(attitude(0.0, 0.0, 2.0))]]), None);
    assert_eq!(weigh(&[vec![]]), None);
}

#[test]
fn equation_12_is_exact_only_without_an_offset() {
    let start = attitude(0.0, 0.0, 0.0);
    let now = GripperPose { position: [1.4, 0.3], ..attitude(0.2, -0.3, 1.2) };
    let push = [5.0, -1.0, 2.0, 0.0, 0.0, 0.4];
    let weight_alone = |pose: &GripperPose| minus(&[0.0; 6], &gripper().wrench(pose));
    let first = [UnloadedReading { wrench: weight_alone(&start), pose: start.clone() }];
    let tare = Tare::new(TareMethod::Equation12, &first, None).unwrap();
    let found = tare.apply(&plus(&weight_alone(&now), &push), &now);
    let (planar, expected) = (now.planar_wrench(&found), now.planar_wrench(&push));
    assert!((0..3).all(|k| (planar[k] - expected[k]).abs() < 1e-9), "{planar:?} {expected:?}");

    let offset = Tare::new(TareMethod::Equation12, &[unloaded(start)], None).unwrap();
    let wrong = now.planar_wrench(&offset.apply(&reading(&now, &push), &now));
    assert!((wrong[0] - expected[0]).abs() > 1.0);
}

#[test]
fn sd_of_mean_accounts_for_autocorrelation() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut white_sds, mut red_sds, mut red_means) = (vec![], vec![], vec![]);
    for _ in 0..200 {
        let white: Vec<f64> = (0..100).map(|_| StandardNormal.sample(&mut rng)).collect();
        let mut state = 0.0;
        let red: Vec<f64> = (0..400)
            .map(|_| {
                let z: f64 = StandardNormal.sample(&mut rng);
                state = 0.8 * state + z;
                state
            })
            .collect();
        white_sds.push(sd_of_mean(&white).unwrap());
        red_sds.push(sd_of_mean(&red).unwrap());
        red_means.push(red.iter().sum::<f64>() / 400.0);
    }
    let average = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    assert!((average(&white_sds) - 0.1).abs() < 0.015, "{}", average(&white_sds));
    let actual = (red_means.iter().map(|m| m * m).sum::<f64>() / 200.0).sqrt();
    let ratio = average(&red_sds) / actual;
    assert!((0.75..1.2).contains(&ratio), "{ratio}");
    assert_eq!(sd_of_mean(&[1.0]), None);
}
