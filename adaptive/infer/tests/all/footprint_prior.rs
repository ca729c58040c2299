//! The footprint prior moves the estimate of a wheel outside the object under its footprint.

#![allow(clippy::unwrap_used)]

use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;
use trundle_infer::{Channels, Density, FitOptions, InferError, Likelihood, Linearised, Quiet, Target, fit};
use trundle_model::{Body, Model};

const L: [[f64; 2]; 6] = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.0], [0.0, 0.0], [0.0, 0.4], [-0.6, 0.4]];

/// Data that determine the position of the wheel, ± 2 cm in both directions, and nothing else.
struct At([f64; 2]);

const SD: f64 = 0.02;

impl Likelihood for At {
    fn cost(&self, _: &Model, values: &[f64]) -> Result<f64, InferError> {
        Ok([0, 1].iter().map(|&k| 0.5 * ((values[1 + k] - self.0[k]) / SD).powi(2)).sum())
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        let n = free.len();
        let (mut gradient, mut curvature) = (DVector::zeros(n), DMatrix::zeros(n, n));
        for (i, &slot) in free.iter().enumerate().filter(|(_, slot)| [1, 2].contains(*slot)) {
            gradient[i] = (values[slot] - self.0[slot - 1]) / SD.powi(2);
            curvature[(i, i)] = SD.powi(-2);
        }
        Ok(Linearised { cost: self.cost(model, values)?, gradient, curvature })
    }

    fn channels(&self) -> Channels {
        Channels { pose: [1e-3; 3], reading: [1.0; 3], wander: [0.0; 3] }
    }

    fn tuned(&self, _: &Model, _: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        Ok(None)
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        vec![("a".to_owned(), Box::new(Self(self.0))), ("b".to_owned(), Box::new(Self(self.0)))]
    }
}

fn model() -> Model {
    Model::nominal(Body::from_footprint(&L, 22.0).unwrap(), Some(22.0), [true; 3])
}

#[test]
fn a_wheel_in_the_notch_is_pulled_under_the_footprint() {
    let fitted = fit(&At([0.06, 0.2]), &model(), &[], &FitOptions::default(), &Quiet).unwrap();
    let [x, y] = ["x", "y"].map(|p| fitted.estimate(&format!("viscous_wheel.{p}")).unwrap().mean);
    // A compromise between data of ± 20 mm and an edge of ± 6 mm: 5 mm outside instead of 60.
    assert!(x > 0.0 && x < 0.01 && (y - 0.2).abs() < 0.01, "{x} {y}");
}

#[test]
fn gradients_match_differences_with_per_episode_places() {
    let (model, data) = (model(), At([0.1, 0.2]));
    for own in [vec![], vec!["viscous_wheel.x"], vec!["viscous_wheel.x", "viscous_wheel.y"]] {
        let own: BTreeSet<String> = own.into_iter().map(str::to_owned).collect();
        let target = Target::new(&data, &model, &own).unwrap();
        let z: Vec<f64> = (0..target.dimension()).map(|k| 0.3 + 0.05 * k as f64).collect();
        let gradient = target.linearise(&z).unwrap().gradient;
        for k in 0..z.len() {
            let at = |dz: f64| {
                let mut moved = z.clone();
                moved[k] += dz;
                target.cost(&moved).unwrap()
            };
            let numeric = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!(
                (numeric - gradient[k]).abs() < 1e-5 * (1.0 + numeric.abs()),
                "{own:?} {k}: {numeric} {}",
                gradient[k]
            );
        }
    }
}
