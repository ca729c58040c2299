//! One integration step of a table with a wheel and dry friction: plain, and with derivatives.
//!
//! ```text
//! cargo bench -p trundle-model
//! ```

#![allow(missing_docs)] // criterion's macro makes the entry point public

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trundle_model::{Body, Clock, Dual, Effect, Kind, Model, Plant, Real, State};

const DT: f64 = 2e-3;
const CLOCK: Clock = Clock { since_contact: 1.0 };
const WRENCH: [f64; 3] = [12.0, -3.0, 1.5];

fn model() -> Model {
    let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
    let body = Body::from_footprint(&corners, 22.0).unwrap_or_else(|error| unreachable!("{error}"));
    Model::nominal(body, Some(22.0), [true; 3]).with(Effect::free(Kind::CoulombFriction))
}

/// Mass; wheel x, y, angle, μ_x, μ_y; friction x, y, force, static force, Stribeck velocity.
const VALUES: [f64; 11] = [22.0, -0.5, -0.3, 0.2, 15.0, 180.0, 0.4, 0.3, 6.0, 0.0, 0.01];

fn plant<T: Real>(lift: impl Fn(usize, f64) -> T) -> Plant<T> {
    let values: Vec<T> = VALUES.iter().enumerate().map(|(k, &value)| lift(k, value)).collect();
    model().plant(&values).unwrap_or_else(|error| unreachable!("{error}"))
}

fn bench<T: Real>(criterion: &mut Criterion, name: &str, plant: &Plant<T>) {
    let state = State { pose: [0.1, 0.2, 0.3].map(T::lift), twist: [0.4, -0.1, 0.2].map(T::lift) };
    let wrench = WRENCH.map(T::lift);
    criterion.bench_function(name, |bencher| {
        bencher.iter(|| black_box(plant).step(black_box(&state), black_box(wrench), CLOCK, DT));
    });
}

fn steps(criterion: &mut Criterion) {
    bench(criterion, "step/f64", &plant(|_, value| value));
    bench(criterion, "step/dual6", &plant(|k, value| Dual::<6>::variable(value, k)));
    bench(criterion, "step/dual8", &plant(|k, value| Dual::<8>::variable(value, k)));
}

criterion_group!(benches, steps);
criterion_main!(benches);
