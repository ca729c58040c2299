//! Moves of the search that change a model without adding an effect to it.

use crate::error::MechanismError;
use crate::fit::{MAX_STEPS, fit};
use crate::model::{Effect, Kind, Role};
use crate::problem::Problem;
use crate::rows::Scope;
use crate::search::Searcher;
use crate::tried::Tried;

/// Least increase of the log evidence by which another effect replaces one, nats. Smaller differences are within the error of
/// the approximate evidence.
pub(crate) const MIN_BETTER_NATS: f64 = 1.0;
/// Static over kinetic friction from which the fit of a refined law starts.
const REFINED_RATIO: f64 = 1.5;

impl Searcher<'_> {
    /// A model without one of its effects, fitted to its optimum.
    pub fn without_effect(&self, model: &Tried, index: usize, tried: &mut Vec<Tried>) -> Tried {
        if let Some(known) = known_without(model, index, tried) {
            return tried[known].clone();
        }
        let found = self.fitted_without(model, index);
        tried.push(found.clone());
        found
    }

    /// Fit a model without one of its effects from its own values, and keep the better of this and an earlier fit, which
    /// may have ended at another optimum.
    pub fn refit_without(&self, model: &Tried, index: usize, tried: &mut [Tried]) {
        let Some(known) = known_without(model, index, tried) else { return };
        let (found, times) = (self.fitted_without(model, index), self.times(model));
        if found.fit.cost(&times) < tried[known].fit.cost(&times) {
            tried[known] = found;
        }
    }

    fn fitted_without(&self, model: &Tried, index: usize) -> Tried {
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
        self.tried(fit(self.problem, &effects, Some(&from), Scope::Training, MAX_STEPS))
    }

    /// The model in which no exchange of one effect for another increases the evidence.
    pub fn exchanged(&self, mut model: Tried, tried: &mut Vec<Tried>) -> Result<Tried, MechanismError> {
        let count = model.fit.effects.len();
        if count < 2 {
            return Ok(model);
        }
        for index in 0..count {
            let reduced = self.without_effect(&model, index, tried);
            let times = self.times(&model);
            for child in self.children(&reduced, tried)? {
                let is_better = child.log_evidence(&times) > model.log_evidence(&times) + MIN_BETTER_NATS;
                if is_better && self.predicts(&model, &child) && self.all_pass(&child, tried) {
                    model = child;
                    break;
                }
            }
        }
        Ok(model)
    }

    /// The model with refinements of its laws that improve the prediction.
    pub fn refined(&self, mut model: Tried, tried: &mut Vec<Tried>) -> Result<Tried, MechanismError> {
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
            let finer = self.tried(finer);
            if self.support(&model, &finer).is_certain()
                && finer.log_evidence(&times) > model.log_evidence(&times)
            {
                tried.push(finer.clone());
                model = finer;
            }
        }
        Ok(model)
    }

    /// The model without effects that do not pass the tests any more.
    pub fn reduced(&self, mut model: Tried, tried: &mut Vec<Tried>) -> Result<Tried, MechanismError> {
        loop {
            for index in 0..model.fit.effects.len() {
                self.refit_without(&model, index, tried);
            }
            let support = self.support_of_all(&model, tried);
            let worst = (0..support.len())
                .filter(|k| !support[*k].passes())
                .min_by(|a, b| support[*a].error_ratio.total_cmp(&support[*b].error_ratio));
            match worst {
                Some(k) => model = self.without_effect(&model, k, tried),
                None => return Ok(model),
            }
        }
    }

    /// The model in which no effect in place of two increases the evidence.
    pub fn merged(&self, mut model: Tried, tried: &mut Vec<Tried>) -> Result<Tried, MechanismError> {
        'pairs: loop {
            let count = model.fit.effects.len();
            for (first, second) in (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b))) {
                let joints = [first, second].map(|k| model.fit.effects[k].kind.joint());
                let reduced = self.without_effect(&self.without_effect(&model, second, tried), first, tried);
                let times = self.times(&model);
                // An effect at one joint cannot replace effects at two.
                let can_replace =
                    |kind: Kind| kind.joint().is_none_or(|j| joints.iter().all(|joint| *joint == Some(j)));
                for child in self.children_where(&reduced, tried, &can_replace)? {
                    let is_better = child.log_evidence(&times) > model.log_evidence(&times);
                    if is_better && self.predicts(&model, &child) && self.all_pass(&child, tried) {
                        model = child;
                        continue 'pairs;
                    }
                }
            }
            return Ok(model);
        }
    }
}

/// Index of the first model with all effects of a model but one.
fn known_without(model: &Tried, index: usize, tried: &[Tried]) -> Option<usize> {
    let mut kinds: Vec<Kind> = model.fit.effects.iter().map(|e| e.kind).collect();
    kinds.remove(index);
    kinds.sort();
    tried.iter().position(|t| t.kinds() == kinds && t.fit.slots.len() < model.fit.slots.len())
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
            (true, crate::laws::Scale::Effort) => REFINED_RATIO * fast,
            (true, scale) => 0.1 * scale.of(scales),
        };
        (0..params.len()).map(one).collect()
    };
    let has_levels = (0..params.len()).any(|k| free(k) && params[k].scale == crate::laws::Scale::Effort);
    let levels: &[f64] = if has_levels { &[1.0, 1.0 / REFINED_RATIO] } else { &[1.0] };
    levels.iter().map(|ratio| start(ratio * size)).collect()
}
