//! One of two models that are to be told apart: its values, and how far the data let them go.

use nalgebra::{DMatrix, DVector};
use trundle_infer::{Coordinates, Fit};
use trundle_model::{Model, ModelError, Plant, Posterior, Slot};

/// A model at its values, with the precision of what is known of them.
#[derive(Clone, Debug)]
pub struct Rival {
    /// Its name in a diagnosis.
    pub name: String,
    model: Model,
    coordinates: Coordinates,
    /// Where it stands, standard normal under the prior.
    point: DVector<f64>,
    /// How much a departure from there costs: `½ δᵀ Λ δ` nats.
    precision: DMatrix<f64>,
    /// −log p(recording | values); zero without a recording.
    pub(super) cost: f64,
}

impl Rival {
    /// A model as fitted: it may go as far as the recording and its priors let it.
    pub fn fitted(name: &str, fit: &Fit) -> Self {
        let free = |slot: Slot| fit.slots.iter().find(|s| s.name == slot.name).cloned().unwrap_or(slot);
        let coordinates = Coordinates::of(fit.model.slots().into_iter().map(free).collect());
        let n = coordinates.free().len();
        let own: Vec<Option<usize>> =
            (0..n).map(|k| fit.slots.iter().position(|s| s.name == coordinates.slot(k).name)).collect();
        let at = |k: usize| own[k].and_then(|k| fit.point.get(k)).copied().unwrap_or(0.0);
        let covariance = DMatrix::from_fn(n, n, |i, j| match (own[i], own[j]) {
            (Some(i), Some(j)) => fit.spread[(i, j)],
            _ if i == j => 1.0,
            _ => 0.0,
        });
        let point = DVector::from_fn(n, |k, _| at(k));
        let precision = inverse(covariance);
        Self {
            name: name.to_owned(),
            model: fit.model.clone(),
            coordinates,
            point,
            precision,
            cost: fit.cost,
        }
    }

    /// A model from its file: what its posterior names goes as far as that allows, the rest as far as the catalogue's
    /// priors do, whether or not it has a value; refinements that are left out stay so.
    ///
    /// # Errors
    /// When a value is missing.
    pub fn of_file(name: &str, model: &Model, posterior: Option<&Posterior>) -> Result<Self, ModelError> {
        model.resolved()?;
        let values: Vec<f64> = model.slots().iter().map(|s| s.value.unwrap_or(0.0)).collect();
        let refinement = refinements(model);
        let free = |(slot, fixed): (Slot, bool)| if fixed { slot } else { Slot { value: None, ..slot } };
        let coordinates = Coordinates::of(model.slots().into_iter().zip(refinement).map(free).collect());
        let point = DVector::from_vec(coordinates.point(&values));
        let covariance = believed(&coordinates, point.as_slice(), posterior);
        let (name, model) = (name.to_owned(), model.clone());
        Ok(Self { name, model, coordinates, point, precision: inverse(covariance), cost: 0.0 })
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    pub(super) fn point(&self) -> &DVector<f64> {
        &self.point
    }

    pub(super) fn precision(&self) -> &DMatrix<f64> {
        &self.precision
    }

    /// Indices of the free slots.
    pub(super) fn free(&self) -> &[usize] {
        self.coordinates.free()
    }

    /// Values of all slots at a point, and the slopes of the free ones.
    pub(super) fn values(&self, point: &DVector<f64>) -> (Vec<f64>, Vec<f64>) {
        self.coordinates.values(point.as_slice())
    }

    /// The plant at its values.
    pub(super) fn plant(&self) -> Result<Plant<f64>, ModelError> {
        self.model.plant(&self.values(&self.point).0)
    }
}

/// Which slots stay as they are: refinements at the value of the simple law.
fn refinements(model: &Model) -> Vec<bool> {
    let of_effects = model.effects.iter().flat_map(|effect| {
        let params = effect.kind.spec().params;
        params.iter().zip(&effect.values).map(|(p, value)| {
            let simple = p.role.is_choice() || (p.refinement.is_some() && *value == p.refinement);
            simple || model.fixed(effect.kind, p).is_some()
        })
    });
    std::iter::once(false).chain(of_effects).collect()
}

/// Covariance in the coordinates: the posterior's of what it names, else the prior's.
fn believed(coordinates: &Coordinates, point: &[f64], posterior: Option<&Posterior>) -> DMatrix<f64> {
    let slopes = coordinates.values(point).1;
    let n = slopes.len();
    let named = |k: usize| posterior?.names.iter().position(|name| *name == coordinates.slot(k).name);
    let own: Vec<Option<usize>> = (0..n).map(named).collect();
    let entry =
        |a: usize, b: usize| posterior.and_then(|p| p.covariance.get(a)?.get(b).copied()).unwrap_or(0.0);
    DMatrix::from_fn(n, n, |i, j| match (own[i], own[j]) {
        (Some(a), Some(b)) => entry(a, b) / (slopes[i] * slopes[j]).max(1e-12),
        _ if i == j => coordinates.min_precision(i).recip(),
        _ => 0.0,
    })
}

/// Inverse of a covariance; where it is none, that of its diagonal.
pub(super) fn inverse(covariance: DMatrix<f64>) -> DMatrix<f64> {
    let diagonal = covariance.diagonal();
    let even = 0.5 * (&covariance + covariance.transpose());
    even.cholesky().map_or_else(
        || DMatrix::from_diagonal(&diagonal.map(|v| if v > 0.0 { v.recip() } else { 1.0 })),
        |factor| factor.inverse(),
    )
}
