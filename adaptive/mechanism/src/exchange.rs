//! Exchange of effects: one effect in place of another, or of two.

use crate::error::MechanismError;
use crate::fitted_model::FittedModel;
use crate::model::Kind;
use crate::search::Searcher;

/// Least increase of the log evidence by which another effect replaces one, nats. Smaller differences are within the error of
/// the approximate evidence.
pub(crate) const MIN_EXCHANGE_GAIN_NATS: f64 = 1.0;

impl Searcher<'_> {
    /// The model in which no exchange of one effect for another increases the evidence.
    pub fn exchanged(
        &self,
        mut model: FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<FittedModel, MechanismError> {
        let count = model.fit.effects.len();
        if count < 2 {
            return Ok(model);
        }
        for index in 0..count {
            let reduced = self.without_effect(&model, index, models);
            let times = self.times(&model);
            for child in self.children(&reduced, models)? {
                let is_better =
                    child.log_evidence(&times) > model.log_evidence(&times) + MIN_EXCHANGE_GAIN_NATS;
                if is_better && self.predicts(&model, &child) && self.all_pass(&child, models) {
                    model = child;
                    break;
                }
            }
        }
        Ok(model)
    }

    /// The model in which no effect in place of two increases the evidence.
    pub fn merged(
        &self,
        mut model: FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<FittedModel, MechanismError> {
        'pairs: loop {
            let count = model.fit.effects.len();
            for (first, second) in (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b))) {
                let joints = [first, second].map(|k| model.fit.effects[k].kind.joint());
                let reduced =
                    self.without_effect(&self.without_effect(&model, second, models), first, models);
                let times = self.times(&model);
                // An effect at one joint cannot replace effects at two.
                let can_replace =
                    |kind: Kind| kind.joint().is_none_or(|j| joints.iter().all(|joint| *joint == Some(j)));
                for child in self.children_where(&reduced, models, &can_replace)? {
                    let is_better = child.log_evidence(&times) > model.log_evidence(&times);
                    if is_better && self.predicts(&model, &child) && self.all_pass(&child, models) {
                        model = child;
                        continue 'pairs;
                    }
                }
            }
            return Ok(model);
        }
    }
}
