//! Draws from the posterior stored in `model.toml`: a mean and a covariance.
//!
//! They are made in the coordinates of the fit ([`Coordinates`]), in which Laplace's approximation is normal,
//! instead of the parameters' units. A mass with 40 % uncertainty therefore stays positive, and a place on
//! the body stays within its bounds. To first order, the moments are those of the file.

use crate::PosteriorError;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::RngExt;
use rand_distr::StandardNormal;
use trundle_infer::Coordinates;
use trundle_model::{Model, Posterior as StoredPosterior, Slot};

/// Half width of a 95 % interval, in standard deviations.
const HALF_WIDTH_SD: f64 = 1.959_963_984_540_054;

/// A posterior to draw from.
#[derive(Clone, Debug)]
pub struct Draws {
    coordinates: Coordinates,
    /// Mean in the coordinates.
    center: DVector<f64>,
    /// A square root of the covariance there.
    root: DMatrix<f64>,
}

/// Posterior interval of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Name as in [`Slot::name`].
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Centre of the posterior.
    pub mean: f64,
    /// 95 % interval.
    pub interval: [f64; 2],
}

impl Draws {
    /// Draws of a posterior over parameters of `model`.
    ///
    /// # Errors
    /// When the posterior names a parameter that the model does not have, or holds a number that is not
    /// finite.
    pub fn new(model: &Model, posterior: &StoredPosterior) -> Result<Self, PosteriorError> {
        let slots = model.slots();
        let mut order = Vec::with_capacity(posterior.names.len());
        for name in &posterior.names {
            let found = slots.iter().position(|slot| slot.name == *name);
            order.push(found.ok_or_else(|| invalid(format!("the model has no parameter `{name}`")))?);
        }
        let coordinates = Coordinates::of(set_free(slots, &order));
        let (center, slopes) = centre(&coordinates, &order, &posterior.mean);
        let indices: Vec<usize> =
            coordinates.free().iter().filter_map(|k| order.iter().position(|o| o == k)).collect();
        let n = indices.len();
        if n != order.len() {
            return Err(invalid("a parameter is named twice in `names`".to_owned()));
        }
        let cell =
            |i: usize, j: usize| posterior.covariance.get(indices[i]).and_then(|row| row.get(indices[j]));
        let scaled =
            DMatrix::from_fn(n, n, |i, j| cell(i, j).copied().unwrap_or(f64::NAN) / (slopes[i] * slopes[j]));
        if !scaled.iter().chain(center.iter()).all(|v| v.is_finite()) {
            return Err(invalid("all means and covariances must be finite and within bounds".to_owned()));
        }
        Ok(Self { coordinates, center: DVector::from_vec(center), root: root(scaled) })
    }

    /// A draw: a value for every parameter of the model. Parameters without a posterior keep the model's
    /// values.
    pub fn draw(&self, rng: &mut impl RngExt) -> Vec<(&str, f64)> {
        let normal = DVector::from_fn(self.center.len(), |_, _| rng.sample::<f64, _>(StandardNormal));
        let z = &self.center + &self.root * normal;
        let values = self.coordinates.values(z.as_slice()).0;
        self.coordinates.slots().iter().map(|slot| slot.name.as_str()).zip(values).collect()
    }

    /// Intervals of the parameters that vary, in the model's order.
    pub fn ranges(&self) -> Vec<Range> {
        let one = |(k, &slot): (usize, &usize)| {
            let sd = self.root.row(k).norm();
            let at = |shift: f64| {
                let z: Vec<f64> = (0..self.center.len())
                    .map(|i| self.center[i] + if i == k { shift } else { 0.0 })
                    .collect();
                self.coordinates.values(&z).0[slot]
            };
            let Slot { name, unit, .. } = &self.coordinates.slots()[slot];
            Range {
                name: name.clone(),
                unit,
                mean: at(0.0),
                interval: [at(-HALF_WIDTH_SD * sd), at(HALF_WIDTH_SD * sd)],
            }
        };
        self.coordinates.free().iter().enumerate().map(one).collect()
    }
}

fn invalid(reason: String) -> PosteriorError {
    PosteriorError::Config { what: "posterior".to_owned(), reason }
}

/// The slots, with those in `order` free and all others fixed.
fn set_free(mut slots: Vec<Slot>, order: &[usize]) -> Vec<Slot> {
    for (k, slot) in slots.iter_mut().enumerate() {
        slot.value = if order.contains(&k) { None } else { Some(slot.value.unwrap_or(f64::NAN)) };
    }
    slots
}

/// The means as a point of the coordinates, and the derivatives of the values there.
fn centre(coordinates: &Coordinates, order: &[usize], mean: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut values: Vec<f64> = coordinates.slots().iter().map(|s| s.value.unwrap_or(0.0)).collect();
    for (&slot, &mean) in order.iter().zip(mean) {
        values[slot] = mean;
    }
    let point = coordinates.point(&values);
    let slopes = coordinates.values(&point).1;
    (point, slopes)
}

/// A matrix whose product with its transpose is `covariance`. Directions with negative eigenvalues due to
/// rounding get zero variance.
fn root(covariance: DMatrix<f64>) -> DMatrix<f64> {
    let symmetric = (&covariance + covariance.transpose()) * 0.5;
    let SymmetricEigen { eigenvectors, eigenvalues } = symmetric.symmetric_eigen();
    eigenvectors * DMatrix::from_diagonal(&eigenvalues.map(|v| v.max(0.0).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const TABLE: &str = r#"
format = "trundle-model/1"
[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 20.0
[[effect]]
kind = "viscous_wheel"
x = -0.1
y = -0.3
angle = 0.2
mu_x = 15.0
mu_y = 180.0
[posterior]
names = ["viscous_wheel.mu_x", "body.mass", "viscous_wheel.x"]
mean = [15.0, 20.0, -0.1]
covariance = [[0.09, 0.048, 0.0], [0.048, 0.04, 0.0], [0.0, 0.0, 0.0004]]
"#;

    fn draws(text: &str) -> Result<Draws, PosteriorError> {
        let (model, posterior) = Model::from_toml(text).unwrap();
        Draws::new(&model, &posterior.unwrap())
    }

    #[test]
    fn draws_have_the_moments_of_the_file() {
        let draws = draws(TABLE).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let all: Vec<Vec<f64>> =
            (0..20_000).map(|_| draws.draw(&mut rng).into_iter().map(|(_, v)| v).collect()).collect();
        let mean = |k: usize| all.iter().map(|d| d[k]).sum::<f64>() / all.len() as f64;
        let cov = |i: usize, j: usize| {
            all.iter().map(|d| (d[i] - mean(i)) * (d[j] - mean(j))).sum::<f64>() / all.len() as f64
        };
        // Slots: mass, x, y, angle, mu_x, mu_y.
        assert!(
            (mean(0) - 20.0).abs() < 0.01 && (mean(4) - 15.0).abs() < 0.02 && (mean(1) + 0.1).abs() < 1e-3
        );
        for (i, j, expected) in [(0, 0, 0.04), (4, 4, 0.09), (0, 4, 0.048), (1, 1, 0.0004)] {
            assert!((cov(i, j) / expected - 1.0).abs() < 0.05, "{i} {j}: {}", cov(i, j));
        }
        assert_eq!((all[7][2], all[7][3], all[7][5]), (-0.3, 0.2, 180.0));
    }

    #[test]
    fn draws_respect_bounds() {
        let wide = TABLE.replace("0.09, 0.048", "225.0, 0.0").replace("0.048, 0.04", "0.0, 0.04");
        let draws = draws(&wide.replace("0.0004", "0.25")).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for _ in 0..2000 {
            let drawn = draws.draw(&mut rng);
            assert!(drawn[4].1 > 0.0 && (-0.6..=0.6).contains(&drawn[1].1), "{drawn:?}");
        }
    }

    #[test]
    fn ranges_are_those_of_the_draws() {
        let draws = draws(TABLE).unwrap();
        let ranges = draws.ranges();
        assert_eq!(ranges.iter().map(|r| r.name.as_str()).collect::<Vec<_>>()[0], "body.mass");
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut mass: Vec<f64> = (0..20_000).map(|_| draws.draw(&mut rng)[0].1).collect();
        mass.sort_by(f64::total_cmp);
        let [low, high] = ranges[0].interval;
        assert!((mass[500] - low).abs() < 0.02 && (mass[19_500] - high).abs() < 0.02, "{low} {high}");
    }

    #[test]
    fn a_posterior_of_another_model_is_an_error() {
        let error = draws(&TABLE.replace("\"body.mass\"", "\"tether.stiffness\"")).unwrap_err().to_string();
        assert!(error.contains("tether.stiffness"), "{error}");
        let error = draws(&TABLE.replace("\"body.mass\"", "\"viscous_wheel.x\"")).unwrap_err().to_string();
        assert!(error.contains("twice"), "{error}");
    }
}
