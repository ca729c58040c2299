//! Search for several effects together, in the presence of a random-walk wrench.
//!
//! Several missing effects bias a fit, and the first effect that is added compensates for all of them. The
//! best single effect may therefore be a wrong one. A random-walk wrench of estimated size absorbs whatever
//! is missing. The parameters then stay near the truth and small effects add up, so that sets of effects can
//! be compared.

use super::{MAX_EFFECTS, MAX_FIRST_KINDS, Searcher, with_free_parameters};
use crate::best_subset::EffectSet;
use crate::fitted_model::{Effort, FittedModel, Job};
use trundle_infer::{Channels, InferError};

impl Searcher<'_> {
    /// Fit the most promising sets of effects, screened on the nominal model with a random-walk wrench.
    pub(super) fn fit_effect_sets(
        &self,
        base: &FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<(), InferError> {
        let Some(robust) = self.refitted_with_random_walk(base)? else { return Ok(()) };
        let options = self.screen_options(self.regions, MAX_FIRST_KINDS);
        let sets = self.engine.sets(&robust, &self.offered(base), &options, MAX_EFFECTS, self.watch)?;
        let job = |set: &EffectSet| {
            let with = |own: &[f64]| -> Vec<f64> {
                let of_effects = set.effects.iter().flat_map(|e| e.values.iter().map(|v| v.unwrap_or(0.0)));
                own.iter().copied().chain(of_effects).collect()
            };
            let warm = vec![with(&set.base), with(&robust.fit.values)];
            Job::from(base, set.effects.iter().map(with_free_parameters).collect(), warm)
        };
        self.fit_new("several effects", sets.iter().map(job).collect(), sets.len(), models)
    }

    /// A model refitted with a random-walk wrench. The size of the walk is estimated under the instruments'
    /// noise, because fitted noise would absorb missing effects.
    fn refitted_with_random_walk(&self, fitted: &FittedModel) -> Result<Option<FittedModel>, InferError> {
        let Some(lack) = self.engine.lack_of_fit(&self.with_instrument_noise(fitted))? else {
            return Ok(None);
        };
        let from = Job::from(fitted, fitted.added.clone(), vec![fitted.fit.values.clone()]);
        let job = Job { channels: lack.channels, ..from };
        Ok(self.fitted("random-walk wrench", vec![job], Effort::Full)?.pop())
    }

    /// A model under the instruments' noise.
    pub(super) fn with_instrument_noise(&self, fitted: &FittedModel) -> FittedModel {
        let mut read = fitted.clone();
        read.fit.channels = Channels::of(&self.engine.data().noise);
        read
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::engine::Engine;
    use crate::engine::plant_engine::PlantEngine;
    use crate::search::{MAX_EFFECTS, Searcher, kinds};
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::Quiet;
    use trundle_model::{Kind, Model};

    /// The sets that the screen with a random-walk wrench keeps, sorted by kind.
    fn kept(truth: Model) -> Vec<Vec<Kind>> {
        let data = World::of(truth).recording(3);
        let engine = PlantEngine::new(&data, None).unwrap();
        let base = engine.base(0, &Quiet).unwrap();
        let searcher = Searcher::new(&engine, &[], 0, &Quiet);
        let Some(robust) = searcher.refitted_with_random_walk(&base).unwrap() else { return vec![] };
        let options = searcher.screen_options(&[], 5);
        let sets = engine.sets(&robust, &searcher.offered(&base), &options, MAX_EFFECTS, &Quiet).unwrap();
        sets.iter().map(|set| kinds(&set.effects)).collect()
    }

    #[test]
    fn two_hidden_effects_are_screened_together() {
        let hidden = [
            effect(Kind::MassChange, &[("episode", 1.0), ("time", 2.0), ("mass", 8.0)]),
            effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]),
        ];
        let found = kept(hidden.iter().cloned().fold(locked(), Model::with));
        assert!(found.contains(&kinds(&hidden)), "{found:?}");
    }

    #[test]
    fn no_set_is_kept_for_a_complete_model() {
        assert_eq!(kept(locked()), Vec::<Vec<Kind>>::new());
    }
}
