//! The gradient of the motion's likelihood, with its measured error, against differences.
#![allow(clippy::unwrap_used)]

mod common;

use common::{NOISE, World, effect, locked, table};
use trundle_infer::{Coordinates, Likelihood, MotionLikelihood};
use trundle_model::{Kind, Model};

/// Slopes of the cost by every slot: as linearised, the same with its error added, and by central differences.
fn slopes(likelihood: &dyn Likelihood, values: &[f64]) -> [Vec<f64>; 3] {
    let model = Model::nominal(table(), None, [true; 3]);
    let free = Coordinates::new(&model).free().to_vec();
    let reaches: Vec<f64> = free.iter().map(|&slot| 1e-4 * values[slot].abs().max(0.1)).collect();
    let given = likelihood.linearise(&model, values, &free).unwrap().gradient;
    let error = likelihood.gradient_error(&model, values, &free, &reaches).unwrap().unwrap();
    let at = |slot: usize, shift: f64| {
        let mut moved = values.to_vec();
        moved[slot] += shift;
        likelihood.cost(&model, &moved).unwrap()
    };
    let exact = free.iter().zip(&reaches).map(|(&slot, &h)| (at(slot, h) - at(slot, -h)) / (2.0 * h));
    let corrected = &given + &error;
    [given.as_slice().to_vec(), corrected.as_slice().to_vec(), exact.collect()]
}

#[test]
fn a_gradient_with_its_error_is_that_of_the_likelihood() {
    // A missing effect: residuals are no longer what the filter's covariances expect.
    let hidden = effect(Kind::MassChange, &[("episode", 1.0), ("time", 2.0), ("mass", 8.0)]);
    let pushes = World::of(locked().with(hidden)).pushes(3, 5);
    let motion = MotionLikelihood::new(&pushes, &NOISE).unwrap();
    let values: Vec<f64> = locked().slots().iter().filter_map(|s| s.value).collect();
    let apart =
        |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2) / b.powi(2)).sum::<f64>().sqrt();
    let [given, corrected, exact] = slopes(&motion.thinned(), &values);
    assert!(apart(&corrected, &exact) < 0.02, "{corrected:?} is not {exact:?}");
    assert!(apart(&given, &exact) > 0.2, "{given:?} is {exact:?}");
    // Measured in longer steps, it serves the shorter ones.
    let [given, corrected, exact] = slopes(&motion, &values);
    assert!(apart(&corrected, &exact) < 0.3 * apart(&given, &exact), "{corrected:?} is not {exact:?}");
}
