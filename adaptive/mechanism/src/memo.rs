//! Models with one more effect that a search has fitted already.

use crate::model::Kind;
use crate::tried::Tried;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// Largest difference of the costs of two fits of a model that count as the same, nats.
const SAME_COST_NATS: f64 = 0.01;

/// Children of models, by the models' effects.
#[derive(Debug, Default)]
pub(crate) struct Memo(Mutex<BTreeMap<Vec<Kind>, Children>>);

#[derive(Debug)]
struct Children {
    /// Cost of the fit of the model to which they belong.
    cost: f64,
    models: Vec<Tried>,
}

impl Memo {
    /// The children of a fit with a cost.
    pub fn get(&self, parent: &Tried, cost: f64) -> Option<Vec<Tried>> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.get(&parent.kinds())
            .filter(|known| (known.cost - cost).abs() < SAME_COST_NATS)
            .map(|known| known.models.clone())
    }

    /// Keep the children of a fit with a cost.
    pub fn insert(&self, parent: &Tried, cost: f64, children: &[Tried]) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert(parent.kinds(), Children { cost, models: children.to_vec() });
    }
}
