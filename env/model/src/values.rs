//! Values of a model's parameters and initial inner states, as given by a caller.

use std::collections::BTreeMap;

use crate::law::MAX_INNER_STATES;
use crate::{Model, ModelError};

impl Model {
    /// A value for each of [`Model::slots`]: the given one, otherwise that of the model.
    ///
    /// # Errors
    /// If a name is unknown, a value is out of bounds, or a parameter has no value.
    pub fn values_with(&self, given: &BTreeMap<String, f64>) -> Result<Vec<f64>, ModelError> {
        let slots = self.slots();
        if let Some(name) = given.keys().find(|name| slots.iter().all(|s| s.name != **name)) {
            let known: Vec<&str> = slots.iter().map(|s| s.name.as_str()).collect();
            let known = known.join(", ");
            return Err(ModelError::Format(format!(
                "parameters: unknown name `{name}`; the model has {known}"
            )));
        }
        let value = |slot: &crate::Slot| match given.get(&slot.name).copied().or(slot.value) {
            Some(value) if (slot.lower..=slot.upper).contains(&value) => Ok(value),
            Some(value) => Err(ModelError::OutOfBounds {
                name: format!("parameters: {}", slot.name),
                value,
                lower: slot.lower,
                upper: slot.upper,
                unit: slot.unit,
            }),
            None => Err(ModelError::Format(format!(
                "{} has no value: give one, or fit the model to a recording first",
                slot.name
            ))),
        };
        slots.iter().map(value).collect()
    }

    /// Default initial values of the laws' inner states: the first start of each.
    pub fn default_inner(&self) -> Vec<f64> {
        self.inner().iter().map(|inner| inner.starts.first().copied().unwrap_or_default()).collect()
    }

    /// Initial values of the laws' inner states: the given ones, or the defaults if none are given.
    ///
    /// # Errors
    /// If the number of values is wrong, or a value is not finite.
    pub fn inner_with(&self, given: &[f64]) -> Result<[f64; MAX_INNER_STATES], ModelError> {
        let inner = self.inner();
        let defaults = self.default_inner();
        let values = if given.is_empty() { &defaults } else { given };
        if values.len() != inner.len() || !values.iter().all(|value| value.is_finite()) {
            let names: Vec<&str> = inner.iter().map(|inner| inner.name).collect();
            return Err(ModelError::Format(format!(
                "inner = {given:?}: must be {} finite numbers {names:?}",
                inner.len()
            )));
        }
        Ok(std::array::from_fn(|k| values.get(k).copied().unwrap_or_default()))
    }
}
