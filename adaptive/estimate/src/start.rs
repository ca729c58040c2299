//! Starting values of a fit.

use std::collections::BTreeMap;

use trundle_model::{Model, ModelError, Slot};

use crate::EstimateError;

/// Values of all slots of a model from a start that gives every free parameter.
///
/// # Errors
/// If a name is not a free parameter, a value is missing, or a value is out of bounds.
pub(crate) fn start_values(model: &Model, start: &BTreeMap<String, f64>) -> Result<Vec<f64>, EstimateError> {
    let slots = model.slots();
    let is_free = |slot: &&Slot| slot.value.is_none();
    let free = || slots.iter().filter(is_free).map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ");
    if let Some(name) = start.keys().find(|name| !slots.iter().filter(is_free).any(|s| s.name == **name)) {
        return Err(EstimateError::NotFree { name: name.clone(), free: free() });
    }
    let value_of = |slot: &Slot| match slot.value.or_else(|| start.get(&slot.name).copied()) {
        Some(value) if (slot.lower..=slot.upper).contains(&value) => Ok(value),
        Some(value) => Err(EstimateError::Model(ModelError::OutOfBounds {
            name: format!("start: {}", slot.name),
            value,
            lower: slot.lower,
            upper: slot.upper,
            unit: slot.unit,
        })),
        None => Err(EstimateError::NoStartValue { name: slot.name.clone(), free: free() }),
    };
    slots.iter().map(value_of).collect()
}
