//! A linearised simulator as the score test sees it.

use super::likelihood::PathLikelihood;
use crate::linearisation::{Linearisation, Start};
use crate::proposals::has_shape;
use nalgebra::{DMatrix, DVector};
use trundle_infer::{Coordinates, Fit, InferError};
use trundle_model::{Effect, Kind, Model};

/// Number of further starts of an effect that has a place.
const PRIOR_STARTS: usize = 3;

/// A linearised simulator with the innovations of a fitted model.
pub(super) struct LinearisedView {
    pub likelihood: PathLikelihood,
    pub sim_values: Vec<f64>,
    pub residual: DVector<f64>,
}

impl Linearisation for LinearisedView {
    fn residual(&self) -> DVector<f64> {
        self.residual.clone()
    }

    fn own_derivatives(&self, fit: &Fit) -> Result<(DMatrix<f64>, Vec<Option<usize>>), InferError> {
        let slots = fit.model.slots();
        let place = |name: &str| slots.iter().position(|s| s.name == name);
        let parameter = |name: &str| self.likelihood.parameters.iter().position(|p| p.name == name);
        let all = fit.estimates.iter().map(|e| (place(&e.name), parameter(&e.name)));
        let column = |(law, own): (Option<usize>, Option<usize>)| law.or(own.map(|k| slots.len() + k));
        let free: Vec<usize> = all.clone().filter_map(column).collect();
        let values: Vec<f64> = fit.values.iter().chain(&self.sim_values).copied().collect();
        let by_parameters = self.likelihood.jacobian(&fit.model, &values, &free)?;
        // The initial states of the laws are fitted as well.
        let by_initial_states =
            self.likelihood.initial_state_jacobian(&fit.model.plant(&fit.values)?, &self.sim_values);
        if by_initial_states.is_empty() {
            return Ok((by_parameters, all.map(|(law, _)| law).collect()));
        }
        let columns: Vec<_> = by_parameters.column_iter().chain(by_initial_states.column_iter()).collect();
        let slots = all.map(|(law, _)| law).chain(by_initial_states.column_iter().map(|_| None)).collect();
        Ok((DMatrix::from_columns(&columns), slots))
    }

    fn derivatives(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<DMatrix<f64>, InferError> {
        let values: Vec<f64> = values.iter().chain(&self.sim_values).copied().collect();
        self.likelihood.jacobian(model, &values, free)
    }
}

/// Starts at places drawn from the prior. Far from the optimum, a linear step ranks places poorly.
pub(super) fn starts_from_prior(bare: &Model, kind: Kind, base: &[f64], seed: u64) -> Vec<Start> {
    use rand::SeedableRng;
    if !has_shape(bare, kind) {
        return vec![];
    }
    let mut model = bare.clone();
    model.effects.push(Effect::free(kind));
    let coordinates = Coordinates::new(&model);
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = || {
        let values = coordinates.values(&coordinates.draw(&mut rng)).0;
        let own = values[1..].iter().map(|&v| Some(v)).collect();
        let effect = Effect { kind, values: own };
        Start { neutral: effect.clone(), effect, base: base.to_vec(), gain: 0.0 }
    };
    (0..PRIOR_STARTS).map(|_| drawn()).collect()
}
