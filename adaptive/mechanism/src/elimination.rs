//! Backward elimination: removal of effects that a model does not need.

use crate::error::MechanismError;
use crate::fit::{MAX_STEPS, fit};
use crate::fitted_model::FittedModel;
use crate::model::{Kind, Role};
use crate::rows::Scope;
use crate::search::Searcher;

impl Searcher<'_> {
    /// A model without one of its effects, fitted to its optimum.
    pub fn without_effect(
        &self,
        model: &FittedModel,
        index: usize,
        models: &mut Vec<FittedModel>,
    ) -> FittedModel {
        if let Some(known) = known_without(model, index, models) {
            return models[known].clone();
        }
        let found = self.fitted_without(model, index);
        models.push(found.clone());
        found
    }

    /// Fit a model without one of its effects from its own values, and keep the better of this and an earlier fit, which
    /// may have ended at another optimum.
    pub fn refit_without(&self, model: &FittedModel, index: usize, models: &mut [FittedModel]) {
        let Some(known) = known_without(model, index, models) else { return };
        let (found, times) = (self.fitted_without(model, index), self.times(model));
        if found.fit.cost(&times) < models[known].fit.cost(&times) {
            models[known] = found;
        }
    }

    fn fitted_without(&self, model: &FittedModel, index: usize) -> FittedModel {
        let mut effects = model.fit.fitted_effects();
        effects.remove(index);
        let mut from = model.fit.clone();
        from.slots.iter_mut().for_each(|slot| {
            // Indices of the effects behind the removed one change.
            if let Role::Effect(k, param) = slot.role
                && k > index
            {
                slot.role = Role::Effect(k - 1, param);
            }
        });
        self.cross_validated(fit(self.problem, &effects, Some(&from), Scope::Training, MAX_STEPS))
    }

    /// The model without effects that do not pass the tests any more.
    pub fn reduced(
        &self,
        mut model: FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<FittedModel, MechanismError> {
        loop {
            for index in 0..model.fit.effects.len() {
                self.refit_without(&model, index, models);
            }
            let support = self.support_of_all(&model, models);
            let worst = (0..support.len())
                .filter(|k| !support[*k].passes())
                .min_by(|a, b| support[*a].error_ratio.total_cmp(&support[*b].error_ratio));
            match worst {
                Some(k) => model = self.without_effect(&model, k, models),
                None => return Ok(model),
            }
        }
    }
}

/// Index of the first model with all effects of a model but one.
fn known_without(model: &FittedModel, index: usize, models: &[FittedModel]) -> Option<usize> {
    let mut kinds: Vec<Kind> = model.fit.effects.iter().map(|e| e.kind).collect();
    kinds.remove(index);
    kinds.sort();
    models.iter().position(|t| t.kinds() == kinds && t.fit.slots.len() < model.fit.slots.len())
}
