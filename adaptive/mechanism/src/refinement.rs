//! Refinement of laws: fits of parameters that a simple form of a law leaves at their defaults.

use crate::error::MechanismError;
use crate::fit::{MAX_STEPS, fit};
use crate::fitted_model::FittedModel;
use crate::laws::Scale;
use crate::model::{Effect, Kind};
use crate::problem::Problem;
use crate::rows::Scope;
use crate::search::Searcher;

/// Static over kinetic friction from which the fit of a refined law starts.
const REFINED_RATIO: f64 = 1.5;

impl Searcher<'_> {
    /// The model with refinements of its laws that improve the prediction.
    pub fn refined(
        &self,
        mut model: FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<FittedModel, MechanismError> {
        for index in 0..model.fit.effects.len() {
            self.watch.progress("refinements", index as f64 / model.fit.effects.len() as f64);
            let effects = model.fit.fitted_effects();
            let times = self.times(&model);
            let finer = |values: Vec<f64>| {
                let mut effects = effects.clone();
                effects[index].values = values;
                fit(self.problem, &effects, Some(&model.fit), Scope::Training, MAX_STEPS)
            };
            let all = refinements(self.problem, &effects[index]).into_iter().map(finer);
            let Some(finer) = all.min_by(|a, b| a.cost(&times).total_cmp(&b.cost(&times))) else { continue };
            let finer = self.cross_validated(finer);
            if self.support(&model, &finer).is_certain()
                && finer.log_evidence(&times) > model.log_evidence(&times)
            {
                models.push(finer.clone());
                model = finer;
            }
        }
        Ok(model)
    }
}

/// Values with the refinements of an effect, from which fits start; none if it has none or they are free. The level that was
/// fitted without another one may be either of them.
fn refinements(problem: &Problem, effect: &Effect) -> Vec<Vec<f64>> {
    let (Kind::Joint(_, j), params) = (effect.kind, effect.kind.params()) else { return vec![] };
    let free = |k: usize| params[k].refines && effect.values[k].is_nan();
    if !(0..params.len()).any(free) {
        return vec![];
    }
    let level = effect.values.iter().position(|v| !v.is_nan()).unwrap_or(0);
    let size = effect.values[level];
    let scales = &problem.joints[j].scales;
    let start = |fast: f64| {
        let one = |k: usize| match (free(k), params[k].scale) {
            (false, _) if k == level => fast,
            (false, _) => effect.values[k],
            (true, Scale::Effort) => REFINED_RATIO * fast,
            (true, scale) => 0.1 * scale.of(scales),
        };
        (0..params.len()).map(one).collect()
    };
    let has_levels = (0..params.len()).any(|k| free(k) && params[k].scale == Scale::Effort);
    let levels: &[f64] = if has_levels { &[1.0, 1.0 / REFINED_RATIO] } else { &[1.0] };
    levels.iter().map(|ratio| start(ratio * size)).collect()
}
