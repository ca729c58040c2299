//! A recording's likelihood along the seen motion, with its derivatives by laws' parameters and a foreign simulator's own.

use super::likelihood::Along;
use super::linear::scale;
use super::own_states::Start;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use trundle_infer::{Channels, InferError, Likelihood, Linearised};
use trundle_model::{Model, Plant, Slot};

/// Step of a finite difference by a law's parameter, in what its prior takes for its scale.
const RELATIVE: f64 = 1e-4;

impl Along {
    fn parted<'v>(&self, model: &Model, values: &'v [f64]) -> Result<(&'v [f64], &'v [f64]), InferError> {
        let (own, got) = (model.slots().len(), values.len());
        let expected = own + self.parameters.len();
        if got != expected {
            return Err(trundle_model::ModelError::Length { what: "parameters", got, expected }.into());
        }
        Ok(values.split_at(own))
    }

    /// Derivatives of the innovations by the slots `free`: the model's, then the simulator's.
    pub fn jacobian(
        &self,
        model: &Model,
        values: &[f64],
        free: &[usize],
    ) -> Result<DMatrix<f64>, InferError> {
        let (laws, own) = self.parted(model, values)?;
        self.jacobian_from(model, values, free, &self.starts(&model.plant(laws)?, own))
    }

    fn jacobian_from(
        &self,
        model: &Model,
        values: &[f64],
        free: &[usize],
        starts: &[Start],
    ) -> Result<DMatrix<f64>, InferError> {
        let (laws, own) = self.parted(model, values)?;
        let rows = self.base.len();
        let column = |&k: &usize| -> Result<Vec<f64>, InferError> {
            let Some(parameter) = k.checked_sub(laws.len()) else {
                return self.slope(model, laws, k, starts);
            };
            let place = self.free.iter().position(|&f| f == parameter);
            let Some(j) = place else { return Ok(vec![0.0; rows]) };
            let (at, value) = (self.values[parameter], own[parameter]);
            let slope = if self.is_positive(parameter) { at / value.max(f64::MIN_POSITIVE) } else { 1.0 };
            Ok(self.columns[j].iter().map(|c| slope * c).collect())
        };
        let columns = free.par_iter().map(column).collect::<Result<Vec<_>, InferError>>()?;
        Ok(DMatrix::from_fn(rows, free.len(), |i, j| columns[j][i]))
    }

    /// With the laws' own states starting where they do: their cost is stationary there.
    fn slope(&self, model: &Model, laws: &[f64], k: usize, starts: &[Start]) -> Result<Vec<f64>, InferError> {
        let h = RELATIVE * scale(&model.slots()[k], laws[k]);
        let side = |sign: f64| -> Result<Vec<f64>, InferError> {
            let mut moved = laws.to_vec();
            moved[k] += sign * h;
            Ok(self.of_laws(&model.plant(&moved)?, starts))
        };
        let (high, low) = (side(1.0)?, side(-1.0)?);
        Ok(high.iter().zip(&low).map(|(a, b)| (a - b) / (2.0 * h)).collect())
    }

    /// −log density with the laws' own states starting where they do, and the innovations.
    fn cost_from(&self, plant: &Plant<f64>, own: &[f64], starts: &[Start]) -> (f64, Vec<f64>) {
        let innovations = self.innovations_from(plant, own, starts);
        let certain: f64 = self.gains.iter().map(|g| g.normaliser).sum();
        let priced: f64 = starts.iter().map(|start| start.price).sum();
        let cost = certain + priced + 0.5 * innovations.iter().map(|e| e * e).sum::<f64>();
        (if cost.is_finite() { cost } else { f64::INFINITY }, innovations)
    }

    /// Derivatives of the innovations by the starts of the laws' own states, each in its episode.
    pub(super) fn by_starts(&self, plant: &Plant<f64>, own: &[f64]) -> DMatrix<f64> {
        let starts = self.starts(plant, own);
        let columns = starts.iter().map(|start| start.slopes.ncols()).sum();
        let mut all = DMatrix::zeros(if columns > 0 { self.base.len() } else { 0 }, columns);
        let (mut row, mut column) = (0, 0);
        for (path, Start { slopes, .. }) in self.paths.iter().zip(&starts) {
            if !slopes.is_empty() {
                all.view_mut((row, column), slopes.shape()).copy_from(slopes);
            }
            (row, column) = (row + 3 * path.intervals.len(), column + slopes.ncols());
        }
        all
    }
}

impl Likelihood for Along {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        let (laws, own) = self.parted(model, values)?;
        let plant = model.plant(laws)?;
        Ok(self.cost_from(&plant, own, &self.starts(&plant, own)).0)
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        let (laws, own) = self.parted(model, values)?;
        let plant = model.plant(laws)?;
        let starts = self.starts(&plant, own);
        let (cost, innovations) = self.cost_from(&plant, own, &starts);
        let jacobian = self.jacobian_from(model, values, free, &starts)?;
        let mut curvature = jacobian.tr_mul(&jacobian);
        let mut row = 0;
        for (path, start) in self.paths.iter().zip(&starts) {
            let rows = 3 * path.intervals.len();
            if let Some(absorbed) = start.absorbed(&jacobian.rows(row, rows).into_owned()) {
                curvature -= absorbed;
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
        self.sketch.as_deref().map(|sketch| sketch as &dyn Likelihood)
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        let one = |k: usize| -> (String, Box<dyn Likelihood + '_>) {
            (self.paths[k].name.clone(), Box::new(self.only(|e| e == k)))
        };
        (0..self.paths.len()).map(one).collect()
    }
}
