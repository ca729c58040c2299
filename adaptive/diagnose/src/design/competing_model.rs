//! One of two models that an experiment compares: its values and their precision.

use nalgebra::{DMatrix, DVector};
use trundle_infer::{Coordinates, Fit};
use trundle_model::{Model, ModelError, Plant, Posterior, Slot};

/// A model with values and the precision of its parameters.
#[derive(Clone, Debug)]
pub struct CompetingModel {
    /// Name of the model in a diagnosis.
    pub name: String,
    model: Model,
    coordinates: Coordinates,
    /// Parameter values in coordinates that are standard normal under the prior.
    point: DVector<f64>,
    /// Precision Λ of the parameters: a departure δ costs `½ δᵀ Λ δ` nats.
    precision: DMatrix<f64>,
    /// −log p(recording | values); zero without a recording.
    pub(super) cost: f64,
}

impl CompetingModel {
    /// A fitted model, whose parameters are limited by the recording and the priors.
    pub fn from_fit(name: &str, fit: &Fit) -> Self {
        let free = |slot: Slot| fit.slots.iter().find(|s| s.name == slot.name).cloned().unwrap_or(slot);
        let coordinates = Coordinates::of(fit.model.slots().into_iter().map(free).collect());
        let n = coordinates.free().len();
        let index: Vec<Option<usize>> =
            (0..n).map(|k| fit.slots.iter().position(|s| s.name == coordinates.slot(k).name)).collect();
        let at = |k: usize| index[k].and_then(|k| fit.point.get(k)).copied().unwrap_or(0.0);
        let covariance = DMatrix::from_fn(n, n, |i, j| match (index[i], index[j]) {
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

    /// A model from a file. Its posterior limits the parameters that it names; the catalogue's priors limit all
    /// others, whether they have a value or not. Refinements that are not used stay fixed.
    ///
    /// # Errors
    /// If a value is missing.
    pub fn from_file(name: &str, model: &Model, posterior: Option<&Posterior>) -> Result<Self, ModelError> {
        model.resolved()?;
        let values: Vec<f64> = model.slots().iter().map(|s| s.value.unwrap_or(0.0)).collect();
        let refinement = fixed_refinements(model);
        let free = |(slot, fixed): (Slot, bool)| if fixed { slot } else { Slot { value: None, ..slot } };
        let coordinates = Coordinates::of(model.slots().into_iter().zip(refinement).map(free).collect());
        let point = DVector::from_vec(coordinates.point(&values));
        let covariance = covariance_of(&coordinates, point.as_slice(), posterior);
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

    /// Values of all slots at a point, and the derivatives of the free ones.
    pub(super) fn values(&self, point: &DVector<f64>) -> (Vec<f64>, Vec<f64>) {
        self.coordinates.values(point.as_slice())
    }

    /// The plant with the model's values.
    pub(super) fn plant(&self) -> Result<Plant<f64>, ModelError> {
        self.model.plant(&self.values(&self.point).0)
    }
}

/// Whether each slot stays fixed because it is a refinement at the value of the simple law, or is fixed by the
/// model.
fn fixed_refinements(model: &Model) -> Vec<bool> {
    let of_effects = model.effects.iter().flat_map(|effect| {
        let params = effect.kind.spec().params;
        params.iter().zip(&effect.values).map(|(p, value)| {
            let simple = p.role.is_choice() || (p.refinement.is_some() && *value == p.refinement);
            simple || model.fixed_value(effect.kind, p).is_some()
        })
    });
    std::iter::once(false).chain(of_effects).collect()
}

/// Covariance in the coordinates: that of the posterior for the parameters that it names, else that of the prior.
fn covariance_of(coordinates: &Coordinates, point: &[f64], posterior: Option<&Posterior>) -> DMatrix<f64> {
    let slopes = coordinates.values(point).1;
    let n = slopes.len();
    let named = |k: usize| posterior?.names.iter().position(|name| *name == coordinates.slot(k).name);
    let index: Vec<Option<usize>> = (0..n).map(named).collect();
    let entry =
        |a: usize, b: usize| posterior.and_then(|p| p.covariance.get(a)?.get(b).copied()).unwrap_or(0.0);
    DMatrix::from_fn(n, n, |i, j| match (index[i], index[j]) {
        (Some(a), Some(b)) => entry(a, b) / (slopes[i] * slopes[j]).max(1e-12),
        _ if i == j => coordinates.min_precision(i).recip(),
        _ => 0.0,
    })
}

/// Inverse of a covariance, or of its diagonal if it is not positive definite.
pub(super) fn inverse(covariance: DMatrix<f64>) -> DMatrix<f64> {
    let diagonal = covariance.diagonal();
    let symmetric = 0.5 * (&covariance + covariance.transpose());
    symmetric.cholesky().map_or_else(
        || DMatrix::from_diagonal(&diagonal.map(|v| if v > 0.0 { v.recip() } else { 1.0 })),
        |factor| factor.inverse(),
    )
}
