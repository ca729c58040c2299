//! Cost of derivatives: one integration step and a rollout of five seconds of a table with a wheel, with and without dry
//! friction, in `f64` and with six or eight derivatives.
//!
//! ```text
//! cargo bench -p trundle-model
//! ```
//! The ratios at the end compare the fastest of many interleaved runs, to reduce the influence of other load.

#![allow(missing_docs)] // criterion's macro makes the entry point public

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Instant;
use trundle_model::{Body, Clock, Dual, Effect, Kind, Model, Plant, Real, State};

const CLOCK: Clock = Clock::since_contact(1.0);
const STEPS: usize = 500;
const REPETITIONS: usize = 1000;

/// A table of 22 kg on a wheel, optionally with dry friction at a foot.
fn table(has_friction: bool) -> Model {
    let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
    let body = Body::from_footprint(&corners, 22.0).unwrap_or_else(|error| unreachable!("{error}"));
    let wheel = [("x", -0.5), ("y", -0.3), ("angle", 0.2), ("mu_x", 15.0), ("mu_y", 180.0)];
    let foot = [("x", 0.4), ("y", 0.3), ("force", 6.0)];
    let mut model = Model::nominal(body, Some(22.0), [true; 3]);
    model.effects = vec![effect(Kind::ViscousWheel, &wheel)];
    if has_friction { model.with(effect(Kind::CoulombFriction, &foot)) } else { model }
}

fn effect(kind: Kind, values: &[(&str, f64)]) -> Effect {
    values.iter().fold(Effect::free(kind), |effect, (name, value)| effect.with(name, Some(*value)))
}

/// Plant of the table; `lift` seeds derivatives by index: mass; wheel x, y, angle, μ_x, μ_y; friction.
fn plant<T: Real>(has_friction: bool, lift: impl Fn(usize, f64) -> T) -> Plant<T> {
    let model = table(has_friction);
    let slots = model.slots();
    let values = slots.iter().enumerate().filter_map(|(k, slot)| slot.value.map(|value| lift(k, value)));
    model.plant(&values.collect::<Vec<T>>()).unwrap_or_else(|error| unreachable!("{error}"))
}

fn dual<const N: usize>(has_friction: bool) -> Plant<Dual<N>> {
    plant(has_friction, |k, value| Dual::variable(value, k))
}

fn wrench<T: Real>(k: usize) -> [T; 3] {
    let t = k as f64 * 0.01;
    [15.0 + 20.0 * (1.3 * t).sin(), 6.0 * (2.1 * t).cos(), 2.0 * (0.9 * t).sin()].map(T::lift)
}

fn rollout<T: Real>(plant: &Plant<T>, wrenches: &[[T; 3]]) -> State<T> {
    let start = State::at_rest([0.1, 0.2, 0.3]);
    wrenches.iter().fold(start, |state, &wrench| plant.step(&state, wrench, CLOCK, 0.01))
}

fn bench<T: Real>(criterion: &mut Criterion, name: &str, plant: &Plant<T>) {
    let state = State::moving([0.1, 0.2, 0.3].map(T::lift), [0.4, -0.1, 0.2].map(T::lift));
    criterion.bench_function(&format!("step/{name}"), |bencher| {
        bencher.iter(|| black_box(plant).step(black_box(&state), black_box(wrench(0)), CLOCK, 2e-3));
    });
    let wrenches: Vec<_> = (0..STEPS).map(wrench).collect();
    criterion.bench_function(&format!("rollout/{name}"), |bencher| {
        bencher.iter(|| rollout(black_box(plant), black_box(&wrenches)));
    });
}

fn steps(criterion: &mut Criterion) {
    for (has_friction, table) in [(false, "wheel"), (true, "wheel and dry friction")] {
        bench(criterion, &format!("{table}/f64"), &plant(has_friction, |_, value| value));
        bench(criterion, &format!("{table}/dual6"), &dual::<6>(has_friction));
        bench(criterion, &format!("{table}/dual8"), &dual::<8>(has_friction));
    }
}

/// Time per step of a rollout, ns.
fn timed<T: Real>(plant: &Plant<T>, wrenches: &[[T; 3]]) -> f64 {
    let begun = Instant::now();
    black_box(rollout(black_box(plant), black_box(wrenches)));
    begun.elapsed().as_nanos() as f64 / STEPS as f64
}

/// Cost of rollouts with derivatives relative to `f64`.
fn ratios(_: &mut Criterion) {
    for (has_friction, table) in [(false, "wheel"), (true, "wheel and dry friction")] {
        let (plain, six, eight) =
            (plant(has_friction, |_, value| value), dual::<6>(has_friction), dual::<8>(has_friction));
        let (f, s, e): (Vec<_>, Vec<_>, Vec<_>) = (
            (0..STEPS).map(wrench).collect(),
            (0..STEPS).map(wrench).collect(),
            (0..STEPS).map(wrench).collect(),
        );
        let mut best = [f64::INFINITY; 3];
        for _ in 0..REPETITIONS {
            let took = [timed(&plain, &f), timed(&six, &s), timed(&eight, &e)];
            best = [0, 1, 2].map(|k| best[k].min(took[k]));
        }
        let [f, s, e] = best;
        println!(
            "{table}: f64 {f:.0} ns a step, six derivatives {s:.0} ns, {:.2}-fold, eight {:.2}-fold",
            s / f,
            e / f
        );
    }
}

criterion_group!(benches, steps, ratios);
criterion_main!(benches);
