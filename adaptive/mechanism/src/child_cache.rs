//! Cache of the models with one more effect that a search has fitted.

use crate::fitted_model::FittedModel;
use crate::model::Kind;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// Largest difference of the costs of two fits of a model that count as the same, nats.
const SAME_COST_NATS: f64 = 0.01;

/// Children of models, by the effects of the models.
#[derive(Debug, Default)]
pub(crate) struct ChildCache(Mutex<BTreeMap<Vec<Kind>, Children>>);

#[derive(Debug)]
struct Children {
    /// Cost of the fit of the model to which they belong.
    cost: f64,
    models: Vec<FittedModel>,
}

impl ChildCache {
    /// The children of a fit with a cost.
    pub fn get(&self, parent: &FittedModel, cost: f64) -> Option<Vec<FittedModel>> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.get(&parent.kinds())
            .filter(|known| (known.cost - cost).abs() < SAME_COST_NATS)
            .map(|known| known.models.clone())
    }

    /// Keep the children of a fit with a cost.
    pub fn insert(&self, parent: &FittedModel, cost: f64, children: &[FittedModel]) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert(parent.kinds(), Children { cost, models: children.to_vec() });
    }
}
