//! Gains of recorded efforts at joints that move the same bodies.
//!
//! Free masses take the gain of one joint, and the other joints then need the inverse gain: the residual of one
//! joint does not determine at which joint a gain is wrong.

use crate::candidates::candidates;
use crate::error::MechanismError;
use crate::exchange::MIN_EXCHANGE_GAIN_NATS;
use crate::fitted_model::FittedModel;
use crate::laws::JointKind;
use crate::model::Kind;
use crate::search::Searcher;

impl Searcher<'_> {
    /// The model in which no gain at another joint that moves the same bodies increases the evidence in place of a gain. The
    /// other models are models, and may be tied.
    pub fn with_best_gains(
        &self,
        mut model: FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<FittedModel, MechanismError> {
        for index in 0..model.fit.effects.len() {
            let Kind::Joint(JointKind::EffortGain, joint) = model.fit.effects[index].kind else { continue };
            let reduced = self.without_effect(&model, index, models);
            let is_other = |kind: Kind| {
                let moves_same = |j: usize| j != joint && self.coupling.by_masses[joint].contains(&j);
                matches!(kind, Kind::Joint(JointKind::EffortGain, j) if moves_same(j))
            };
            let with = |kind: Kind| {
                let mut kinds = reduced.kinds();
                kinds.push(kind);
                kinds.sort();
                kinds
            };
            let known: Vec<Vec<Kind>> = models.iter().map(FittedModel::kinds).collect();
            let is_new = |kind: Kind| is_other(kind) && !known.contains(&with(kind));
            self.children_above(&reduced, models, &is_new, f64::NEG_INFINITY)?;
            let others: Vec<Vec<Kind>> =
                candidates(self.problem).into_iter().filter(|kind| is_other(*kind)).map(with).collect();
            let times = self.times(&model);
            let gain = |other: &FittedModel| other.log_evidence(&times) - model.log_evidence(&times);
            let competing = models
                .iter()
                .filter(|other| others.contains(&other.kinds()) && gain(other) > MIN_EXCHANGE_GAIN_NATS);
            let best = competing.max_by(|a, b| gain(a).total_cmp(&gain(b))).cloned();
            if let Some(best) = best.filter(|best| self.predicts(&model, best))
                && self.all_pass(&best, models)
            {
                model = best;
            }
        }
        Ok(model)
    }
}
