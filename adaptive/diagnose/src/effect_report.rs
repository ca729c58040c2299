//! Report of an effect: statement, parameters, place and contribution.

use crate::answer::MissingEffect;
use crate::candidates;
use crate::engine::Engine;
use crate::fitted_model::FittedModel;
use crate::fitted_model::with_kinds;
use crate::place::FittedEffect;
use crate::search::SearchResult;
use crate::statements::statement;
use trundle_infer::{InferError, Score};
use trundle_model::Kind;

/// The fitted model without one of the effects.
pub(crate) fn without_effect<'a>(
    found: &'a SearchResult,
    full: &FittedModel,
    dropped: usize,
) -> Option<&'a FittedModel> {
    let mut kinds: Vec<Kind> = full.added.iter().map(|e| e.kind).collect();
    kinds.remove(dropped);
    with_kinds(&found.models, kinds)
}

/// The misfit that measures an effect's contribution: of the open-loop motion, or of the wrench if wrenches
/// are compared. A torque counts as a force at the radius of gyration.
fn misfit(score: &Score, gyration: f64) -> Option<f64> {
    let moment = score.torque_rmse.map_or(0.0, |torque| torque / gyration);
    score.r2.map(|r2| 1.0 - r2).or(score.force_rmse.map(|force| force * force + moment * moment))
}

/// The report of effect number `k` of a model.
pub(crate) fn reported_effect(
    engine: &dyn Engine,
    found: &SearchResult,
    best: &FittedModel,
    k: usize,
    probability: f64,
) -> Result<MissingEffect, InferError> {
    let effect = &best.added[k];
    let names = best.fit.model.effect_names();
    let name = &names[names.len() - best.added.len() + k];
    let data = engine.data();
    let episodes = if data.held_out.is_empty() { &data.training } else { &data.held_out };
    let gyration = best.fit.model.body.gyration;
    let with = misfit(&engine.score(best, best, episodes)?, gyration);
    let dropped = match without_effect(found, best, k) {
        Some(simpler) => misfit(&engine.score(simpler, best, episodes)?, gyration),
        None => None,
    };
    let explains = with.zip(dropped).filter(|(_, d)| *d > 0.0).map(|(w, d)| 1.0 - w / d);
    let fitted = FittedEffect { fit: &best.fit, kind: effect.kind, name };
    Ok(MissingEffect {
        effect: candidates::name(effect).to_owned(),
        probability,
        statement: statement(effect, name, &best.fit, data),
        parameters: fitted.parameters(),
        place: fitted.place(data),
        explains,
    })
}

/// Total probability of the models that contain an effect of this name.
pub(crate) fn effect_probability(models: &[FittedModel], probabilities: &[f64], name: &str) -> f64 {
    models.iter().zip(probabilities).filter(|(t, _)| t.names().contains(&name)).map(|(_, p)| p).sum()
}
