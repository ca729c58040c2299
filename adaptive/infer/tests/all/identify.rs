//! Identifiable parameters are reported, unidentifiable ones are withheld, and profiles agree with both.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::collections::BTreeSet;
use trundle_fixtures::{NOISE, World, effect, locked, table};
use trundle_infer::{
    Combination, Fit, FitOptions, MotionLikelihood, Profile, Quiet, Shape, Target, fit, profile,
};
use trundle_model::{Clock, Effect, Kind, Model, State, transport};
use trundle_record::{Counts, PoseSample, Prepared, WrenchSample};

fn nominal() -> Model {
    Model::nominal(table(), None, [true; 3])
}

fn fitted(pushes: &[Prepared], model: &Model) -> Fit {
    let likelihood = MotionLikelihood::new(pushes, &NOISE).unwrap();
    fit(&likelihood, model, &[], &FitOptions::default(), &Quiet).unwrap()
}

fn profiled(pushes: &[Prepared], model: &Model, found: &Fit, name: &str) -> Profile {
    let likelihood = MotionLikelihood::new(pushes, &NOISE).unwrap();
    let target = Target::new(&likelihood, model, &BTreeSet::new()).unwrap();
    let k = found.estimates.iter().position(|e| e.name == name).unwrap();
    profile(&target, found, k, None, &Quiet).unwrap()
}

/// Five seconds from a pose and twist under a force, object axes, at the middle of the left edge.
fn motion(truth: &Model, from: State<f64>, force: impl Fn(f64) -> [f64; 3], seed: u64) -> Prepared {
    let plant = truth.resolved().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let (mut state, dt, frame) = (from, 1e-3, [-0.6, 0.0, 0.0]);
    let (mut wrench, mut pose) = (vec![], vec![]);
    for k in 0..5000 {
        let t = k as f64 * dt;
        if k % 8 == 0 {
            let sd = [NOISE.force, NOISE.force, NOISE.torque];
            let f = force(t);
            wrench.push(WrenchSample {
                t,
                reading: [0, 1, 2].map(|i| f[i] + normal(sd[i])),
                frame,
                ..Default::default()
            });
        }
        if k % 16 == 0 {
            pose.push(PoseSample { t, pose: [0, 1, 2].map(|i| state.pose[i] + normal(NOISE.pose[i])) });
        }
        let applied = transport(force(t + dt / 2.0), frame);
        state = plant.step(&state, applied, Clock::since_contact(t), dt);
    }
    Prepared {
        ordinal: 0,
        name: "push".to_owned(),
        wrench,
        pose,
        contact: 0.0,
        tare_sd: [0.04, 0.04, 0.005],
        at_rest: from.twist == [0.0; 3],
        counts: Counts::default(),
        ..Default::default()
    }
}

/// A table that rolls straight ahead and is pushed straight ahead.
fn straight() -> Prepared {
    let wheel = [("x", -0.3), ("y", 0.0), ("angle", 0.0), ("mu_x", 20.0), ("mu_y", 200.0)];
    let mut truth = locked();
    truth.effects = vec![effect(Kind::ViscousWheel, &wheel)];
    motion(&truth, State::at_rest([0.0; 3]), |t| [14.0 + 9.0 * (3.0 * t).sin(), 0.0, 0.0], 1)
}

#[test]
fn a_straight_push_does_not_identify_rotational_parameters() {
    let push = [straight()];
    let found = fitted(&push, &nominal());
    let identified = |name: &str| found.estimate(name).unwrap().identified;
    assert!(identified("body.mass"), "{:?}", found.estimates);
    assert!(!identified("viscous_wheel.x") && !identified("viscous_wheel.mu_y"), "{:?}", found.estimates);
    let held = found.identifiability();
    assert!(held.identified < held.directions.len());
    assert!(held.unknown.iter().any(|name| name == "viscous_wheel.x"), "{held:?}");
    let across = profiled(&push, &nominal(), &found, "viscous_wheel.mu_y");
    assert!(across.shape != Shape::TwoSided, "{across:?}");
}

#[test]
fn two_wheels_are_not_located() {
    // Any set of viscous wheels moves as one wheel and a rotational damping, so their positions are not
    // identifiable.
    let second = [("x", 0.4), ("y", 0.3), ("angle", 1.0), ("mu_x", 30.0), ("mu_y", 60.0)];
    let truth = locked().with(effect(Kind::ViscousWheel, &second));
    let pushes = World::of(truth).pushes(3, 5);
    let found = fitted(&pushes, &nominal().with(Effect::free(Kind::ViscousWheel)));
    for name in ["viscous_wheel.x", "viscous_wheel.y", "viscous_wheel_2.x", "viscous_wheel_2.y"] {
        assert!(!found.estimate(name).unwrap().identified, "{name}: {:?}", found.estimates);
    }
    let held = found.identifiability();
    // Of the ten parameters of the wheels, the six entries of one damping matrix; and the mass.
    assert!((5..=7).contains(&held.identified), "{held:?}");
}

#[test]
fn rolling_to_a_stop_identifies_only_the_ratio_of_mass_and_friction() {
    let wheel = [("x", 0.0), ("y", 0.0), ("angle", 0.0), ("mu_x", 12.0), ("mu_y", 12.0)];
    let mut truth = locked();
    truth.effects = vec![effect(Kind::ViscousWheel, &wheel)];
    let from = State::moving([0.0; 3], [0.6, 0.2, 0.0]);
    let pushes: Vec<Prepared> = (0..2).map(|seed| motion(&truth, from, |_| [0.0; 3], seed)).collect();
    let found = fitted(&pushes, &nominal());
    assert!(!found.estimate("body.mass").unwrap().identified, "{:?}", found.estimates);
    let held = found.identifiability();
    let ratio = held.combinations.iter().find_map(|c| match c {
        Combination::Ratio(p) if p.names[0] == "body.mass" => Some(p),
        _ => None,
    });
    let ratio = ratio.unwrap_or_else(|| panic!("{held:?}"));
    assert!((ratio.value - 22.0 / 12.0).abs() < 5.0 * ratio.relative_sd * ratio.value, "{ratio:?}");
    assert!(ratio.relative_sd < 0.3, "{ratio:?}");
}

#[test]
fn at_one_heading_only_the_sum_of_slope_and_force_bias_is_identified() {
    let model = nominal().with(Effect::free(Kind::FloorSlope)).with(Effect::free(Kind::ForceBias));
    let found = fitted(&[straight()], &model);
    for estimate in found.estimates.iter().filter(|e| e.name.starts_with("force_bias.force_x")) {
        assert!(!estimate.identified, "{estimate:?}");
    }
    assert!(!found.identifiability().combinations.is_empty(), "{:?}", found.identifiability());
}

#[test]
fn profiles_agree_with_laplace_where_the_posterior_is_gaussian() {
    let pushes = World::of(locked()).pushes(2, 3);
    let found = fitted(&pushes, &nominal());
    for estimate in &found.estimates {
        let seen = profiled(&pushes, &nominal(), &found, &estimate.name);
        let half = 1.645 * estimate.sd;
        assert_eq!(seen.shape, Shape::TwoSided, "{seen:?}");
        assert_eq!(seen.modes.len(), 1, "{seen:?}");
        for (end, sign) in seen.interval.iter().zip([-1.0, 1.0]) {
            let off = end.unwrap() - (estimate.mean + sign * half);
            assert!(off.abs() < 0.2 * half, "{}: {:?} {estimate:?}", estimate.name, seen.interval);
        }
    }
}

#[test]
fn at_rest_no_profile_has_two_ends_and_no_parameter_is_identified() {
    let push = [motion(&locked(), State::at_rest([0.0; 3]), |_| [0.0; 3], 4)];
    let found = fitted(&push, &nominal());
    // Noisy readings at rest favour a heavy object and a distant wheel slightly.
    for estimate in &found.estimates {
        assert!(!estimate.identified);
        let seen = profiled(&push, &nominal(), &found, &estimate.name);
        assert!(seen.shape != Shape::TwoSided, "{seen:?}");
    }
    // At most one direction: the object is not both light and free to roll.
    let held = found.identifiability();
    assert!(held.identified <= 1, "{held:?}");
}

#[test]
fn a_given_grid_is_used() {
    let pushes = World::of(locked()).pushes(1, 3);
    let likelihood = MotionLikelihood::new(&pushes, &NOISE).unwrap();
    let (model, found) = (nominal(), fitted(&pushes, &nominal()));
    let target = Target::new(&likelihood, &model, &BTreeSet::new()).unwrap();
    let seen = profile(&target, &found, 0, Some(&[21.0, 23.0]), &Quiet).unwrap();
    assert_eq!(seen.values.len(), 3);
    assert!((seen.values[0] - 21.0).abs() < 1e-6 && (seen.values[2] - 23.0).abs() < 1e-6, "{seen:?}");
    assert!(seen.deviance[0] > 10.0 && seen.deviance[1] < 1e-6, "{seen:?}");
    assert!(profile(&target, &found, 99, None, &Quiet).is_err());
}
