//! Random starts reach the optimum, also for a large and heavy object: the bed, with which the paper failed.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use trundle_fixtures::{NOISE, World, effect, locked, table};
use trundle_infer::{
    Channels, Fit, FitOptions, InferError, Likelihood, Linearised, MotionLikelihood, Optimiser, Quiet, fit,
};
use trundle_model::{Body, Kind, Model};
use trundle_record::Prepared;

/// A bed, 2.0 m × 1.6 m and 60 kg, with one locked castor.
fn bed() -> Model {
    let body = Body::from_footprint(&[[-1.0, -0.8], [1.0, -0.8], [1.0, 0.8], [-1.0, 0.8]], 60.0).unwrap();
    let wheel = [("x", 0.85), ("y", -0.6), ("angle", 1.2), ("mu_x", 20.0), ("mu_y", 300.0)];
    let mut model = Model::nominal(body, Some(60.0), [true; 3]);
    model.effects = vec![effect(Kind::ViscousWheel, &wheel)];
    model
}

fn found(pushes: &[Prepared], body: &Body, seed: u64, starts: usize, optimiser: Optimiser) -> Fit {
    let likelihood = MotionLikelihood::new(pushes, &NOISE).unwrap();
    let model = Model::nominal(body.clone(), None, [true; 3]);
    let options = FitOptions { starts, seed, optimiser, ..FitOptions::default() };
    fit(&likelihood, &model, &[], &options, &Quiet).unwrap()
}

/// Number of `n` fits with one random start each that reach the optimum of many starts.
fn reached(truth: &Model, data: u64, n: u64, optimiser: Optimiser) -> u64 {
    let pushes = World::of(truth.clone()).pushes(1, data);
    let best = found(&pushes, &truth.body, 99, 12, Optimiser::LevenbergMarquardt);
    let begun = Instant::now();
    let costs = (0..n).map(|seed| found(&pushes, &truth.body, seed, 1, optimiser).cost);
    let reached = costs.filter(|&cost| cost < best.cost + 1.0).count() as u64;
    let each = begun.elapsed().as_secs_f64() / n as f64;
    println!("{optimiser:?}, body of {} kg: {reached} of {n}, {:.0} ms each", truth.body.mass, 1e3 * each);
    reached
}

#[test]
fn one_random_start_reaches_the_optimum_of_the_table_and_of_the_bed() {
    for truth in [locked(), bed()] {
        assert_eq!(reached(&truth, 1, 10, Optimiser::LevenbergMarquardt), 10);
        assert!(reached(&truth, 1, 10, Optimiser::Lbfgs) >= 9);
    }
}

#[test]
fn both_optimisers_reach_the_same_optimum() {
    for data in 1..4 {
        let pushes = World::of(locked()).pushes(2, data);
        let [a, b] = [Optimiser::LevenbergMarquardt, Optimiser::Lbfgs]
            .map(|optimiser| found(&pushes, &table(), data, 4, optimiser));
        assert!((a.log_evidence - b.log_evidence).abs() < 0.1, "{} {}", a.log_evidence, b.log_evidence);
        for (x, y) in a.estimates.iter().zip(&b.estimates) {
            assert!((x.mean - y.mean).abs() < 0.1 * x.sd, "{data}: {x:?} {y:?}");
        }
    }
}

#[test]
fn nearby_starts_reach_the_optimum_and_few_steps_do_not() {
    let truth = locked();
    let pushes = World::of(truth.clone()).pushes(2, 3);
    let likelihood = MotionLikelihood::new(&pushes, &NOISE).unwrap();
    let model = Model::nominal(truth.body.clone(), None, [true; 3]);
    let best = found(&pushes, &truth.body, 99, 12, Optimiser::LevenbergMarquardt);
    let shifted = |by: f64| best.values.iter().map(|v| v * (1.0 + by)).collect::<Vec<f64>>();
    let near = |warm: &[Vec<f64>], steps: usize| {
        let options = FitOptions { local_steps: Some(steps), ..FitOptions::default() };
        fit(&likelihood, &model, warm, &options, &Quiet).unwrap()
    };
    let (far, close) = (shifted(3.0), shifted(0.1));
    let whole = near(&[far.clone(), close.clone()], 60);
    assert!((whole.cost - best.cost).abs() < 0.01, "{} {}", whole.cost, best.cost);
    assert!(whole.converged && whole.last_decrease < 0.01, "{}", whole.last_decrease);
    let short = near(&[far], 5);
    assert!(
        !short.converged && short.last_decrease > 0.01 && short.cost > whole.cost,
        "{}",
        short.last_decrease
    );
}

/// A likelihood that counts its own evaluations, not those of its coarse one, with or without the χ² of its residuals.
struct Counted {
    inner: MotionLikelihood,
    has_chi_squared: bool,
    evaluations: AtomicUsize,
}

impl Likelihood for Counted {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        self.inner.cost(model, values)
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        self.inner.linearise(model, values, free)
    }

    fn chi_squared(&self, model: &Model, values: &[f64]) -> Result<(f64, usize), InferError> {
        if self.has_chi_squared { self.inner.chi_squared(model, values) } else { Ok((0.0, 0)) }
    }

    fn channels(&self) -> Channels {
        self.inner.channels()
    }

    fn tuned(&self, _: &Model, _: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        Ok(None)
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        self.inner.split()
    }

    fn coarse(&self) -> Option<&dyn Likelihood> {
        self.inner.coarse()
    }
}

/// Where residuals are far larger than the noise, decreases of the cost that noise would explain many times over
/// do not prolong a search.
#[test]
fn a_large_misfit_ends_a_search_early_at_the_same_optimum() {
    let dry = effect(Kind::CoulombFriction, &[("x", 0.45), ("y", 0.31), ("force", 15.0)]);
    let pushes = World::of(locked().with(dry)).pushes(4, 1);
    let nominal = Model::nominal(table(), None, [true; 3]);
    let options = FitOptions { measure_gradient: true, ..FitOptions::default() };
    let [(long, most), (short, fewer)] = [false, true].map(|has_chi_squared| {
        let inner = MotionLikelihood::new(&pushes, &NOISE).unwrap();
        let counted = Counted { inner, has_chi_squared, evaluations: AtomicUsize::new(0) };
        let fit = fit(&counted, &nominal, &[], &options, &Quiet).unwrap();
        (fit, counted.evaluations.into_inner())
    });
    let motion = MotionLikelihood::new(&pushes, &NOISE).unwrap();
    let (sum, count) = motion.chi_squared(&long.model, &long.values).unwrap();
    let factor = sum / count as f64;
    println!("mean square {factor:.0}: {most} and {fewer} evaluations");
    assert!(factor > 100.0 && 10 * fewer < 9 * most, "{factor}: {most} and {fewer} evaluations");
    for (x, y) in long.estimates.iter().zip(&short.estimates) {
        assert!((x.mean - y.mean).abs() < 0.1 * factor.sqrt() * x.sd, "{x:?} {y:?}");
    }
}
