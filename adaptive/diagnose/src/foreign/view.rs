//! A linearised simulator as the screen of candidates looks at it.

use super::likelihood::Along;
use crate::proposals::has_shape;
use crate::screen::{Linearisation, Start};
use nalgebra::{DMatrix, DVector};
use trundle_infer::{Coordinates, Fit, InferError};
use trundle_model::{Effect, Kind, Model};

/// Further starts of a kind that has a place.
const ELSEWHERE: usize = 3;

/// What a fitted model leaves along the linearised simulator.
pub(super) struct Linear {
    pub along: Along,
    pub own: Vec<f64>,
    pub residual: DVector<f64>,
}

impl Linearisation for Linear {
    fn residual(&self) -> DVector<f64> {
        self.residual.clone()
    }

    fn own_derivatives(&self, fit: &Fit) -> Result<(DMatrix<f64>, Vec<Option<usize>>), InferError> {
        let slots = fit.model.slots();
        let place = |name: &str| slots.iter().position(|s| s.name == name);
        let parameter = |name: &str| self.along.parameters.iter().position(|p| p.name == name);
        let all = fit.estimates.iter().map(|e| (place(&e.name), parameter(&e.name)));
        let column = |(law, own): (Option<usize>, Option<usize>)| law.or(own.map(|k| slots.len() + k));
        let free: Vec<usize> = all.clone().filter_map(column).collect();
        let values: Vec<f64> = fit.values.iter().chain(&self.own).copied().collect();
        let by_parameters = self.along.jacobian(&fit.model, &values, &free)?;
        // The laws' own states give way as well.
        let by_starts = self.along.by_starts(&fit.model.plant(&fit.values)?, &self.own);
        if by_starts.is_empty() {
            return Ok((by_parameters, all.map(|(law, _)| law).collect()));
        }
        let columns: Vec<_> = by_parameters.column_iter().chain(by_starts.column_iter()).collect();
        let slots = all.map(|(law, _)| law).chain(by_starts.column_iter().map(|_| None)).collect();
        Ok((DMatrix::from_columns(&columns), slots))
    }

    fn derivatives(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<DMatrix<f64>, InferError> {
        let values: Vec<f64> = values.iter().chain(&self.own).copied().collect();
        self.along.jacobian(model, &values, free)
    }
}

/// Starts at places drawn from the prior: what a linear step promises far from the optimum ranks places badly.
pub(super) fn elsewhere(bare: &Model, kind: Kind, base: &[f64], seed: u64) -> Vec<Start> {
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
    (0..ELSEWHERE).map(|_| drawn()).collect()
}
