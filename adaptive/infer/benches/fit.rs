//! Benchmark of a fit of six parameters to one push and to six.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trundle_fixtures::{NOISE, World, locked, table};
use trundle_infer::{Coordinates, FitOptions, Likelihood, MotionLikelihood, Quiet, fit};
use trundle_model::Model;

fn fits(criterion: &mut Criterion) {
    let model = Model::nominal(table(), None, [true; 3]);
    // A fixed start near the centre of the prior.
    let coordinates = Coordinates::new(&model);
    let start = coordinates.values(&vec![0.2; coordinates.free().len()]).0;
    for episodes in [1, 6] {
        let pushes = World::of(locked()).pushes(episodes, 1);
        let likelihood = MotionLikelihood::new(&pushes, &NOISE).unwrap();
        let options = FitOptions { starts: 0, ..FitOptions::default() };
        criterion.bench_function(&format!("fit, six parameters, pushes of 6 s: {episodes}"), |b| {
            b.iter(|| {
                fit(&likelihood, black_box(&model), std::slice::from_ref(&start), &options, &Quiet).unwrap()
            });
        });
        criterion.bench_function(&format!("likelihood and gradient, pushes of 6 s: {episodes}"), |b| {
            b.iter(|| likelihood.linearise(black_box(&model), &start, coordinates.free()).unwrap());
        });
    }
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = fits }
criterion_main!(benches);
