//! A richer model must not fit worse than the simpler one that it contains, because its fit also starts from
//! the simpler optimum.

use super::Searcher;
use crate::engine::Engine;
use crate::engine::plant_engine::PlantEngine;
use crate::fitted_model::{Effort, FittedModel};
use trundle_fixtures::{World, effect, locked};
use trundle_infer::Quiet;
use trundle_model::{Kind, Model};

/// Largest rise of the cost for each free parameter of an added law, nats. The posterior density never falls,
/// but a fit may give up likelihood for its prior. A positive amplitude starts at a fiftieth of its median,
/// `ln 50 / 1.5` standard deviations out, and may gain half the square of that.
const MAX_COST_RISE_PER_PARAMETER_NATS: f64 = 3.4;

/// Rise of the cost when a kind is added, nats, and its number of free parameters; `None` if the search does
/// not fit it.
fn cost_rise(searcher: &Searcher<'_>, base: &FittedModel, kind: Kind) -> Option<(f64, usize)> {
    let jobs = searcher.jobs(base, &[kind], 1, 1).unwrap();
    let fitted = searcher.fitted("one", jobs, Effort::Full).unwrap();
    let one = fitted.into_iter().next()?;
    let own = one.fit.estimates.len().saturating_sub(base.fit.estimates.len());
    Some((one.fit.cost - base.fit.cost, own))
}

/// Add every law of the catalogue to the fit of a small recording.
fn check(truth: Model, seed: u64) {
    let data = World::of(truth).recording(seed);
    let engine = PlantEngine::new(&data, None).unwrap();
    let base = engine.base(seed, &Quiet).unwrap();
    let engine_for_effects = engine.for_added_effects(&base, None, &Quiet).unwrap();
    let searcher = Searcher::new(&*engine_for_effects, &[], seed, &Quiet);
    let mut failed = vec![];
    for kind in searcher.offered(&base) {
        if let Some((cost, own)) = cost_rise(&searcher, &base, kind) {
            println!("{seed} {:24} {cost:+10.2} nats, {own} parameters", kind.spec().kind);
            if cost > MAX_COST_RISE_PER_PARAMETER_NATS * own as f64 {
                failed.push((kind, cost));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
#[ignore = "takes minutes"]
fn nothing_missing() {
    check(locked(), 11);
}

#[test]
#[ignore = "takes minutes"]
fn something_missing() {
    check(locked().with(effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)])), 12);
    let friction = effect(Kind::CoulombFriction, &[("x", 0.45), ("y", 0.31), ("force", 8.0)]);
    check(locked().with(friction), 13);
}
