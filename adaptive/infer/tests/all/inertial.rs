//! Estimates from the wrench that a motion requires.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use trundle_fixtures::{NOISE, World, effect, locked, table};
use trundle_infer::{Fit, FitOptions, InertialLikelihood, Joint, Likelihood, Loss, Quiet, fit};
use trundle_model::{Effect, Kind, Model};

fn nominal() -> Model {
    Model::nominal(table(), None, [true; 3])
}

fn inertial(world: &World, seed: u64) -> InertialLikelihood {
    InertialLikelihood::new(&world.pushes(6, seed), &NOISE, [true; 3]).unwrap()
}

fn found(likelihood: &dyn Likelihood, model: &Model) -> Fit {
    fit(likelihood, model, &[], &FitOptions::default(), &Quiet).unwrap()
}

fn off(fit: &Fit, truth: &[(&str, f64, f64)]) {
    for (name, truth, tolerance) in truth {
        let estimate = fit.estimate(name).unwrap();
        assert!(estimate.identified && (estimate.mean - truth).abs() < *tolerance, "{estimate:?}");
    }
}

#[test]
fn a_moving_table_shows_its_mass_and_its_wheel() {
    // The smoother attenuates accelerations, so the mass is a few percent low.
    let wheel = [
        ("viscous_wheel.x", -0.5, 0.015),
        ("viscous_wheel.y", -0.3, 0.03),
        ("viscous_wheel.angle", 0.2, 0.02),
        ("viscous_wheel.mu_x", 15.0, 0.8),
        ("viscous_wheel.mu_y", 180.0, 9.0),
        ("body.mass", 22.0, 1.5),
    ];
    for loss in [Loss::Gaussian, Loss::STUDENT] {
        for seed in 1..4 {
            let fit = found(&inertial(&World::of(locked()), seed).with_loss(loss), &nominal());
            assert!(fit.converged);
            off(&fit, &wheel);
        }
    }
}

#[test]
fn dry_friction_is_distinguished_from_the_wheel() {
    let dry = effect(Kind::CoulombFriction, &[("x", 0.45), ("y", 0.31), ("force", 8.0)]);
    let world = World::of(locked().with(dry));
    let fit = found(&inertial(&world, 1), &nominal().with(Effect::free(Kind::CoulombFriction)));
    off(
        &fit,
        &[
            ("coulomb_friction.x", 0.45, 0.03),
            ("coulomb_friction.y", 0.31, 0.03),
            ("coulomb_friction.force", 8.0, 0.8),
            ("viscous_wheel.x", -0.5, 0.03),
        ],
    );
}

#[test]
fn two_recordings_determine_more_than_one() {
    let one = |seed| inertial(&World::of(locked()), seed);
    let each = [5, 6].map(|seed| found(&one(seed), &nominal()));
    let parts = [5, 6].map(|seed| -> Box<dyn Likelihood> { Box::new(one(seed)) });
    let both = found(&Joint::new(parts.into()).unwrap(), &nominal());
    for k in 0..6 {
        assert!(both.estimates[k].sd < each[0].estimates[k].sd.min(each[1].estimates[k].sd));
    }
}
