//! The exact likelihood is stationary at the end of a fit, not only its approximate gradient.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use trundle_fixtures::{NOISE, World, effect, locked, table};
use trundle_infer::{Density, FitOptions, MotionLikelihood, Quiet, Target, fit};
use trundle_model::{Kind, Model};

/// Decrease of the cost, nats, that the steepest coordinate predicts at the end of a fit of the nominal
/// model.
fn predicted_decrease(motion: &MotionLikelihood, measure_gradient: bool) -> f64 {
    let model = Model::nominal(table(), None, [true; 3]);
    let options = FitOptions { measure_gradient, ..FitOptions::default() };
    let found = fit(motion, &model, &[], &options, &Quiet).unwrap();
    let target = Target::new(motion, &model, &BTreeSet::new()).unwrap();
    let at = |k: usize, shift: f64| {
        let mut point = found.point.clone();
        point[k] += shift;
        target.cost(&point).unwrap()
    };
    let each = (0..found.point.len()).map(|k| {
        let curvature = found.information[(k, k)].max(1.0);
        let h = 0.01 / curvature.sqrt();
        let slope = (at(k, h) - at(k, -h)) / (2.0 * h);
        slope * slope / (2.0 * curvature)
    });
    each.fold(0.0, f64::max)
}

#[test]
fn a_fit_that_measures_its_gradient_ends_at_an_optimum() {
    // With a missing effect, the residuals do not match the filter's covariances.
    let hidden = effect(Kind::MassChange, &[("episode", 1.0), ("time", 2.0), ("mass", 8.0)]);
    let pushes = World::of(locked().with(hidden)).pushes(3, 5);
    let motion = MotionLikelihood::new(&pushes, &NOISE).unwrap();
    let (approximate, measured) = (predicted_decrease(&motion, false), predicted_decrease(&motion, true));
    // Differences of evidence below one nat are not significant.
    assert!(measured < 1.0 && approximate > 10.0, "{approximate} and {measured} nats");
}
