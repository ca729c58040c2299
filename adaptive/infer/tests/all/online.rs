//! The recursive estimate agrees with a joint fit of all pushes, at a bounded cost.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::time::Instant;
use trundle_fixtures::{NOISE, World, locked, table};
use trundle_infer::{Fit, FitOptions, MotionLikelihood, Online, OnlineOptions, Quiet, fit};
use trundle_model::Model;
use trundle_record::Prepared;

fn nominal() -> Model {
    Model::nominal(table(), None, [true; 3])
}

fn one(push: &Prepared) -> MotionLikelihood {
    MotionLikelihood::new(std::slice::from_ref(push), &NOISE).unwrap()
}

fn batch(pushes: &[Prepared]) -> Fit {
    let likelihood = MotionLikelihood::new(pushes, &NOISE).unwrap();
    fit(&likelihood, &nominal(), &[], &FitOptions::default(), &Quiet).unwrap()
}

/// Squared distance of the online estimate from the batch's, by the batch's covariance, per parameter.
fn distance(online: &Online, batch: &Fit) -> f64 {
    let estimates = online.estimate();
    let n = estimates.len();
    let d = nalgebra::DVector::from_fn(n, |k, _| {
        estimates[k].mean - batch.estimates.iter().find(|e| e.name == estimates[k].name).unwrap().mean
    });
    let solved = batch.covariance.clone().cholesky().unwrap().solve(&d);
    d.dot(&solved) / n as f64
}

#[test]
fn it_agrees_with_the_joint_fit_within_its_uncertainty() {
    let mut sum = 0.0;
    let mut latencies = vec![];
    for seed in 0..8 {
        let pushes = World::of(locked()).pushes(5, seed);
        let mut online = Online::new(nominal(), OnlineOptions::default());
        for (k, push) in pushes.iter().enumerate() {
            let likelihood = Box::new(one(push));
            let begun = Instant::now();
            online.update(likelihood).unwrap();
            if k > 0 {
                latencies.push(begun.elapsed().as_secs_f64() * 1e3);
            } else {
                println!("first {:.1} ms", begun.elapsed().as_secs_f64() * 1e3);
            }
        }
        let found = batch(&pushes);
        let off = distance(&online, &found);
        println!("seed {seed}: {off:.4}, modes {}", online.hypotheses());
        assert!(off < 1.0, "seed {seed}: {off}");
        assert!(online.estimate().iter().all(|e| e.identified));
        for (a, b) in online.estimate().iter().zip(&found.estimates) {
            assert!((0.8..1.25).contains(&(a.sd / b.sd)), "{a:?} {b:?}");
        }
        sum += off;
    }
    latencies.sort_by(f64::total_cmp);
    println!(
        "median {:.2} ms, p95 {:.2} ms",
        latencies[latencies.len() / 2],
        latencies[latencies.len() * 95 / 100]
    );
    assert!(sum / 8.0 < 0.2, "mean squared distance per parameter: {}", sum / 8.0);
}

#[test]
fn old_pushes_are_kept_as_a_sum() {
    let pushes = World::of(locked()).pushes(8, 3);
    let mut online = Online::new(nominal(), OnlineOptions { kept: 2, ..OnlineOptions::default() });
    for push in &pushes {
        online.update(Box::new(one(push))).unwrap();
    }
    let off = distance(&online, &batch(&pushes));
    assert!(off < 1.0, "{off}");
    assert_eq!(online.pushes(), 8);
}

#[test]
fn a_push_in_parts_gives_the_estimate_of_the_whole_push() {
    let pushes = World::of(locked()).pushes(3, 4);
    let [mut whole, mut pieces] = [0; 2].map(|_| Online::new(nominal(), OnlineOptions::default()));
    for push in &pushes {
        whole.update(Box::new(one(push))).unwrap();
        for share in [0.3, 0.6, 0.9] {
            let end = 6.0 * share;
            let mut part = push.clone();
            part.pose.retain(|p| p.t < end);
            part.wrench.retain(|w| w.t < end);
            pieces.peek(&one(&part)).unwrap();
        }
        pieces.update(Box::new(one(push))).unwrap();
    }
    for (a, b) in whole.estimate().iter().zip(pieces.estimate()) {
        assert!((a.mean - b.mean).abs() < 0.3 * a.sd, "{a:?} {b:?}");
    }
}

#[test]
fn before_any_push_nothing_is_identified_and_after_one_at_rest_neither() {
    let mut online = Online::new(nominal(), OnlineOptions::default());
    assert!(online.estimate().iter().all(|e| !e.identified));
    let mut push = World::of(locked()).pushes(1, 2).remove(0);
    let rest = push.pose[0].pose;
    push.wrench.iter_mut().for_each(|w| w.reading = [0.0; 3]);
    push.pose.iter_mut().for_each(|p| p.pose = rest);
    online.update(Box::new(one(&push))).unwrap();
    assert!(online.estimate().iter().all(|e| !e.identified), "{:?}", online.estimate());
}

#[test]
fn a_growing_push_ends_at_the_fit_of_the_complete_push() {
    for seed in 0..8 {
        let push = &World::of(locked()).pushes(1, seed)[0];
        let mut online = Online::new(nominal(), OnlineOptions { starts: 1, ..OnlineOptions::default() });
        let end = push.pose.len();
        for share in 7..=80 {
            let mut so_far = push.clone();
            so_far.pose.truncate(end * share / 80);
            so_far.motion_cache = Default::default();
            online.peek(&one(&so_far)).unwrap();
        }
        let found = batch(std::slice::from_ref(push));
        let off = distance(&online, &found);
        assert!(off < 1.0, "seed {seed}: {off}");
        // The same wheel rotated by a quarter turn is no second mode.
        assert_eq!(online.hypotheses(), 1, "seed {seed}");
        assert!(online.estimate().iter().all(|e| e.identified), "seed {seed}: {:?}", online.estimate());
    }
}
