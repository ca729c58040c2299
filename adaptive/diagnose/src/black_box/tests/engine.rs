//! Screening, fits and discriminating experiments with a black-box simulator.

use super::{pushed, under_test, wheeled};
use crate::black_box::engine::BlackBoxEngine;
use crate::engine::Engine;
use crate::fitted_model::{Effort, FittedModel, Job};
use crate::screen::ScreenOptions;
use trundle_fixtures::{effect, locked};
use trundle_infer::Quiet;
use trundle_model::{Effect, Kind, Model};
use trundle_record::Dataset;

/// Calls `check` with the engine of a recording, its nominal fit, and the engine for effects added to that fit.
fn with(data: &Dataset, check: impl Fn(&BlackBoxEngine<'_>, &FittedModel, &dyn Engine)) {
    let simulator = wheeled();
    let black_box = under_test(&simulator, false);
    let engine = BlackBoxEngine::new(data, &black_box, 0, &Quiet).unwrap();
    let base = engine.base(0, &Quiet).unwrap();
    let before = engine.lack_of_fit(&base).unwrap();
    check(&engine, &base, &*engine.for_added_effects(&base, before, &Quiet).unwrap());
}

#[test]
fn laws_with_internal_states_are_candidates() {
    with(&pushed(locked()), |engine, _, _| {
        let candidates = engine.candidates();
        for kind in [Kind::CasterSwivel, Kind::SwingingLoad, Kind::SensorLag, Kind::SensorPlay] {
            assert!(candidates.contains(&kind), "{kind:?}");
        }
        assert!(!candidates.contains(&Kind::WheelEvent));
    });
}

#[test]
#[ignore = "slow: fits two effects of a black-box simulator"]
fn two_hidden_effects_are_screened_together() {
    let hidden = [
        effect(Kind::MassChange, &[("episode", 1.0), ("time", 2.0), ("mass", 8.0)]),
        effect(Kind::FloorSlope, &[("accel_x", 0.3), ("accel_y", -0.2)]),
    ];
    let mut kinds: Vec<Kind> = hidden.iter().map(|e| e.kind).collect();
    kinds.sort_unstable();
    with(&pushed(hidden.into_iter().fold(locked(), Model::with)), |engine, base, upon| {
        let left = engine.lack_of_fit(base).unwrap().unwrap();
        let from = Job::from(base, vec![], vec![base.fit.values.clone()]);
        let job = Job { channels: left.channels, ..from };
        let unbiased = upon.fit(job, Effort::Full, 0, &Quiet).unwrap();
        assert_eq!(unbiased.fit.channels, left.channels);
        let wanted = ScreenOptions { regions: &[], starts: 2, most: 9, seed: 0 };
        let sets = upon.sets(&unbiased, &upon.candidates(), &wanted, 4, &Quiet).unwrap();
        let found = sets.iter().any(|set| {
            let mut own: Vec<Kind> = set.effects.iter().map(|e| e.kind).collect();
            own.sort_unstable();
            own == kinds
        });
        assert!(found, "{:?}", sets.iter().map(|set| &set.effects).collect::<Vec<_>>());
    });
}

#[test]
fn standard_deviations_are_those_of_the_spread_between_episodes() {
    let slope = Effect::free(Kind::FloorSlope);
    with(&pushed(locked()), |engine, base, upon| {
        let start = [base.fit.values.clone(), vec![0.0, 0.0]].concat();
        let job = Job::from(base, vec![slope.clone()], vec![start]);
        let fitted = upon.fit(job, Effort::Full, 0, &Quiet).unwrap();
        let wide = engine.widened(&fitted).unwrap();
        for (wide, own) in wide.fit.estimates.iter().zip(&fitted.fit.estimates) {
            assert!(wide.name == own.name && wide.sd > 1.2 * own.sd, "{wide:?} {own:?}");
        }
        assert!(wide.fit.estimate("mass").is_some(), "the simulator's parameters are included");
    });
}

#[test]
#[ignore = "slow: simulates a designed push with both models"]
fn the_simulator_verifies_a_designed_push() {
    let foot = [("x", 0.4), ("y", 0.3), ("force", 8.0)];
    let data = pushed(locked().with(effect(Kind::CoulombFriction, &foot)));
    with(&data, |engine, base, upon| {
        let fitted = |kind: Kind, start: &[f64]| {
            let warm = [base.fit.values.as_slice(), start].concat();
            upon.fit(Job::from(base, vec![Effect::free(kind)], vec![warm]), Effort::Full, 0, &Quiet).unwrap()
        };
        let foot = fitted(Kind::CoulombFriction, &[0.4, 0.3, 8.0, 0.0, 0.01, 1e-4]);
        let drag = fitted(Kind::QuadraticDrag, &[30.0]);
        let noise = foot.fit.channels;
        let names = ["coulomb_friction", "quadratic_drag"];
        let planned = engine.experiment(names, [&foot, &drag], &noise, &Quiet).unwrap().unwrap();
        assert!(planned.is_informative(), "{}", planned.sentence);
        assert!(planned.separation.iter().all(|nats| *nats > 10.0), "{:?}", planned.separation);
        // No push separates a model from itself.
        let planned = engine.experiment(names, [&foot, &foot], &noise, &Quiet).unwrap().unwrap();
        assert!(!planned.is_informative() && planned.pushes.is_empty(), "{}", planned.sentence);
    });
}
