//! Cost of a recording along the measured motion, and its derivatives with respect to the parameters of the laws
//! and of the simulator.

use super::law_states::InitialState;
use super::likelihood::PathLikelihood;
use super::linearisation::parameter_scale;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use trundle_infer::{Channels, InferError, Likelihood, Linearised};
use trundle_model::{Model, Plant, Slot};

/// Step of a finite difference with respect to a law's parameter, as a share of the scale of its prior.
const RELATIVE_STEP: f64 = 1e-4;

impl PathLikelihood {
    fn split_values<'v>(
        &self,
        model: &Model,
        values: &'v [f64],
    ) -> Result<(&'v [f64], &'v [f64]), InferError> {
        let (law_count, got) = (model.slots().len(), values.len());
        let expected = law_count + self.parameters.len();
        if got != expected {
            return Err(trundle_model::ModelError::Length { what: "parameters", got, expected }.into());
        }
        Ok(values.split_at(law_count))
    }

    /// Jacobian of the innovations with respect to the slots `free`. Slots count the model's first, then the
    /// simulator's.
    pub fn jacobian(
        &self,
        model: &Model,
        values: &[f64],
        free: &[usize],
    ) -> Result<DMatrix<f64>, InferError> {
        let (laws, sim_values) = self.split_values(model, values)?;
        self.jacobian_from(model, values, free, &self.initial_states(&model.plant(laws)?, sim_values))
    }

    fn jacobian_from(
        &self,
        model: &Model,
        values: &[f64],
        free: &[usize],
        initial: &[InitialState],
    ) -> Result<DMatrix<f64>, InferError> {
        let (laws, sim_values) = self.split_values(model, values)?;
        let rows = self.base.len();
        let column = |&k: &usize| -> Result<Vec<f64>, InferError> {
            let Some(parameter) = k.checked_sub(laws.len()) else {
                return self.law_derivative(model, laws, k, initial);
            };
            let position = self.free.iter().position(|&f| f == parameter);
            let Some(j) = position else { return Ok(vec![0.0; rows]) };
            let (at, value) = (self.values[parameter], sim_values[parameter]);
            let slope = if self.is_positive(parameter) { at / value.max(f64::MIN_POSITIVE) } else { 1.0 };
            Ok(self.columns[j].iter().map(|c| slope * c).collect())
        };
        let columns = free.par_iter().map(column).collect::<Result<Vec<_>, InferError>>()?;
        Ok(DMatrix::from_fn(rows, free.len(), |i, j| columns[j][i]))
    }

    /// Derivative with the initial states of the laws fixed, where their cost is stationary.
    fn law_derivative(
        &self,
        model: &Model,
        laws: &[f64],
        k: usize,
        initial: &[InitialState],
    ) -> Result<Vec<f64>, InferError> {
        let h = RELATIVE_STEP * parameter_scale(&model.slots()[k], laws[k]);
        let side = |sign: f64| -> Result<Vec<f64>, InferError> {
            let mut moved = laws.to_vec();
            moved[k] += sign * h;
            Ok(self.law_innovations(&model.plant(&moved)?, initial))
        };
        let (high, low) = (side(1.0)?, side(-1.0)?);
        Ok(high.iter().zip(&low).map(|(a, b)| (a - b) / (2.0 * h)).collect())
    }

    /// Negative log density with given initial states of the laws, and the innovations.
    fn cost_from(&self, plant: &Plant<f64>, sim_values: &[f64], initial: &[InitialState]) -> (f64, Vec<f64>) {
        let innovations = self.innovations_from(plant, sim_values, initial);
        let normaliser: f64 = self.gains.iter().map(|g| g.normaliser).sum();
        let laplace_cost: f64 = initial.iter().map(|start| start.laplace_cost).sum();
        let cost = normaliser + laplace_cost + 0.5 * innovations.iter().map(|e| e * e).sum::<f64>();
        (if cost.is_finite() { cost } else { f64::INFINITY }, innovations)
    }

    /// Derivatives of the innovations with respect to the initial states of the laws. Each episode has columns of its
    /// own.
    pub(super) fn initial_state_jacobian(&self, plant: &Plant<f64>, sim_values: &[f64]) -> DMatrix<f64> {
        let initial = self.initial_states(plant, sim_values);
        let columns = initial.iter().map(|start| start.slopes.ncols()).sum();
        let mut all = DMatrix::zeros(if columns > 0 { self.base.len() } else { 0 }, columns);
        let (mut row, mut column) = (0, 0);
        for (path, InitialState { slopes, .. }) in self.paths.iter().zip(&initial) {
            if !slopes.is_empty() {
                all.view_mut((row, column), slopes.shape()).copy_from(slopes);
            }
            (row, column) = (row + 3 * path.intervals.len(), column + slopes.ncols());
        }
        all
    }
}

impl Likelihood for PathLikelihood {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        let (laws, sim_values) = self.split_values(model, values)?;
        let plant = model.plant(laws)?;
        Ok(self.cost_from(&plant, sim_values, &self.initial_states(&plant, sim_values)).0)
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        let (laws, sim_values) = self.split_values(model, values)?;
        let plant = model.plant(laws)?;
        let initial = self.initial_states(&plant, sim_values);
        let (cost, innovations) = self.cost_from(&plant, sim_values, &initial);
        let jacobian = self.jacobian_from(model, values, free, &initial)?;
        let mut curvature = jacobian.tr_mul(&jacobian);
        let mut row = 0;
        for (path, start) in self.paths.iter().zip(&initial) {
            let rows = 3 * path.intervals.len();
            if let Some(absorbed_curvature) = start.absorbed_curvature(&jacobian.rows(row, rows).into_owned())
            {
                curvature -= absorbed_curvature;
            }
            row += rows;
        }
        let gradient = jacobian.tr_mul(&DVector::from_vec(innovations));
        Ok(Linearised { cost, gradient, curvature })
    }

    fn channels(&self) -> Channels {
        self.channels
    }

    fn tuned(&self, _: &Model, _: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        Ok(None)
    }

    fn noise(&self) -> Vec<Slot> {
        self.parameters.clone()
    }

    fn coarse(&self) -> Option<&dyn Likelihood> {
        self.subset.as_deref().map(|subset| subset as &dyn Likelihood)
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        let one = |k: usize| -> (String, Box<dyn Likelihood + '_>) {
            (self.paths[k].name.clone(), Box::new(self.only(|e| e == k)))
        };
        (0..self.paths.len()).map(one).collect()
    }
}
