//! Comparison of the smoother with simulated truth: errors, and coverage of the stated uncertainty.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::prepare::wrapped;

const SD: [f64; 3] = [5e-4, 5e-4, 1.7e-3];

fn noise() -> Noise {
    Noise { pose: SD, force: 0.4, torque: 0.05, time: 0.0, stated: true }
}

/// True motion at irregular times of about 60 Hz: a table of 20 kg with viscous damping, at rest for a second, then pushed
/// by a smooth, varying force.
fn truth() -> Vec<Motion> {
    let push = |t: f64| {
        if t < 1.0 {
            return [0.0; 3];
        }
        let s = t - 1.0;
        [30.0 * (1.3 * s).sin(), 12.0 * (0.8 * s).sin() * (2.1 * s).cos(), 2.0 * (1.7 * s).sin()]
    };
    let (mass, drag) = ([20.0, 20.0, 3.0], [25.0, 60.0, 4.0]);
    let (mut pose, mut twist) = ([1.0, -2.0, 3.0], [0.0; 3]);
    let (dt, mut next) = (1e-4, 0.0);
    let mut motions = vec![];
    for i in 0..80_000 {
        let t = f64::from(i) * dt;
        let accel = [0, 1, 2].map(|k| (push(t)[k] - drag[k] * twist[k]) / mass[k]);
        if t >= next {
            motions.push(Motion { t, pose, twist, accel, cov: [[[0.0; 3]; 3]; 3] });
            next = t + if i % 7 < 3 { 0.0163 } else { 0.0171 };
        }
        for k in 0..3 {
            twist[k] += accel[k] * dt;
            pose[k] += twist[k] * dt;
        }
    }
    motions
}

fn observed(truth: &[Motion], sd: [f64; 3], seed: u64) -> Vec<PoseSample> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
    truth.iter().map(|m| PoseSample { t: m.t, pose: [0, 1, 2].map(|k| m.pose[k] + sd[k] * draw()) }).collect()
}

/// Share of (sample, axis) pairs whose true derivative of this order lies within two stated standard deviations, and the
/// mean normalised squared error.
fn coverage(truth: &[Motion], estimate: &[Motion], order: usize) -> (f64, f64) {
    let value = |m: &Motion| [m.pose, m.twist, m.accel][order];
    let (mut inside, mut nees, mut n) = (0.0, 0.0, 0.0);
    for (t, e) in truth.iter().zip(estimate).filter(|(t, _)| t.t > 1.3) {
        for k in 0..3 {
            let square = (value(t)[k] - value(e)[k]).powi(2) / e.cov[k][order][order];
            inside += f64::from(u8::from(square < 4.0));
            nees += square;
            n += 1.0;
        }
    }
    (inside / n, nees / n)
}

#[test]
fn stated_uncertainty_covers_the_truth() {
    let truth = truth();
    for seed in 0..5 {
        let poses = observed(&truth, SD, seed);
        for (name, estimate) in
            [("smooth", smooth(&poses, &noise(), true)), ("filter", filter(&poses, &noise(), true))]
        {
            for order in 0..3 {
                let (inside, nees) = coverage(&truth, &estimate, order);
                assert!(inside > 0.88, "{name} {order}: {inside} inside two sd, nees {nees}");
                assert!((0.1..2.0).contains(&nees), "{name} {order}: nees {nees}");
            }
        }
    }
}

#[test]
fn errors_of_the_time_stamps_are_part_of_the_uncertainty() {
    let (mut truth, precise) = (truth(), [1e-4, 1e-4, 3e-4]);
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut poses = observed(&truth, precise, 6);
    for (pose, motion) in poses.iter_mut().zip(&mut truth) {
        let draw: f64 = StandardNormal.sample(&mut rng);
        let error = 2e-3 * draw.clamp(-3.0, 3.0);
        pose.t += error;
        // The truth at the stated time.
        motion.pose = [0, 1, 2].map(|k| motion.pose[k] + motion.twist[k] * error);
    }
    for order in 0..2 {
        let share = |time: f64| {
            let noise = Noise { pose: precise, time, ..noise() };
            [smooth(&poses, &noise, true), filter(&poses, &noise, true)]
                .map(|m| coverage(&truth, &m, order).0)
        };
        let (stated, ignored) = (share(2e-3), share(0.0));
        assert!(stated.iter().all(|inside| *inside > 0.88), "{order}: {stated:?}");
        assert!(ignored.iter().all(|inside| *inside < 0.88), "{order}: {ignored:?}");
    }
}

#[test]
fn smoothing_is_ten_times_more_accurate_than_differences() {
    let truth = truth();
    let poses = observed(&truth, SD, 1);
    let smoothed = smooth(&poses, &noise(), true);
    let rms = |errors: Vec<f64>| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    let by_smoother = rms(truth.iter().zip(&smoothed).map(|(t, e)| t.twist[0] - e.twist[0]).collect());
    let difference =
        |i: usize| (poses[i + 1].pose[0] - poses[i - 1].pose[0]) / (poses[i + 1].t - poses[i - 1].t);
    let by_difference = rms((1..truth.len() - 1).map(|i| truth[i].twist[0] - difference(i)).collect());
    assert!(10.0 * by_smoother < by_difference, "{by_smoother} {by_difference}");
}

#[test]
fn the_filter_is_causal() {
    let poses = observed(&truth(), SD, 3);
    let whole = filter(&poses, &noise(), true);
    let part = filter(&poses[..200], &noise(), true);
    assert_eq!(whole[..200], part[..]);
}

#[test]
fn an_object_at_rest_has_no_twist() {
    let poses = observed(&truth(), SD, 2);
    for motion in smooth_from(&poses, &noise(), Some(1.0)).iter().filter(|m| m.t <= 1.0) {
        assert_eq!((motion.twist, motion.accel), ([0.0; 3], [0.0; 3]));
        assert!(motion.cov[0][0][0].sqrt() < 0.2 * SD[0]);
        assert!((motion.pose[0] - 1.0).abs() < 3e-4 && wrapped(motion.pose[2] - 3.0).abs() < 1e-3);
    }
}

#[test]
fn initial_velocity_is_estimated_without_rest() {
    let all = truth();
    let moving: Vec<Motion> = all.into_iter().filter(|m| m.t > 2.5).collect();
    let poses = observed(&moving, SD, 4);
    let first = &smooth(&poses, &noise(), false)[0];
    let error = (first.twist[0] - moving[0].twist[0]).abs();
    assert!(error < 3.0 * first.cov[0][1][1].sqrt() && error < 0.05, "{error}");
}

#[test]
fn exact_poses_give_exact_twists() {
    let truth = truth();
    let exact = Noise { pose: [0.0; 3], ..noise() };
    let smoothed = smooth(&observed(&truth, [0.0; 3], 0), &exact, true);
    let worst = truth.iter().zip(&smoothed).map(|(t, e)| (t.twist[0] - e.twist[0]).abs()).fold(0.0, f64::max);
    assert!(worst < 5e-3, "{worst}");
    assert!(smoothed.iter().all(|m| m.cov.iter().flatten().flatten().all(|c| c.is_finite())));
}

#[test]
fn few_poses_give_no_motion_or_finite_motion() {
    let poses = observed(&truth(), SD, 5);
    for n in 0..9 {
        for at_rest in [true, false] {
            for motions in [smooth(&poses[..n], &noise(), at_rest), filter(&poses[..n], &noise(), at_rest)] {
                assert_eq!(motions.len(), if n < MIN_POSES_FOR_MOTION { 0 } else { n });
                assert!(motions.iter().all(|m| m.twist.iter().chain(&m.accel).all(|v| v.is_finite())));
            }
        }
    }
}
