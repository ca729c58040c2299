//! Search with a random-walk wrench in every model, while the misfit is large.
//!
//! If a model misfits precise poses by much more than their noise, its density has many local optima: errors of the
//! simulated velocity persist, and a caster, for example, turns the wrong way from then on. Fits then stop far from the
//! optimum, and even the right effects seem to gain little. With a random-walk wrench the filter forgets these errors. Its
//! size is chosen so that the misfit is moderate, and reduced as the best model improves (graduated optimisation: Blake
//! and Zisserman 1987). In the end models are compared without it.

use super::fitting::insert_models;
use super::{MAX_EFFECTS, MAX_FIRST_KINDS, Searcher, kinds};
use crate::fitted_model::{Effort, FittedModel, Job};
use trundle_infer::InferError;

/// The same model again, from its values and under the noise of `base`. Costs with and without a random-walk wrench are
/// not comparable.
fn refit_job(fitted: &FittedModel, base: &FittedModel) -> Job {
    let warm = vec![fitted.fit.values.clone()];
    let job = Job::from(fitted, fitted.added.clone(), warm);
    Job { channels: base.fit.channels, from: f64::INFINITY, ..job }
}

impl Searcher<'_> {
    /// The nominal model, refitted from its fit with a random-walk wrench if that is better.
    pub(super) fn with_softened_start(&self, base: FittedModel) -> Result<FittedModel, InferError> {
        let Some(softened) = self.engine.softened(&base)? else { return Ok(base) };
        let searcher = Searcher { engine: &*softened, ..*self };
        let mut found = vec![base.clone()];
        for searcher in [searcher, *self] {
            let jobs = found.iter().map(|fitted| refit_job(fitted, &base)).collect();
            found = searcher.fitted("the simulation under test", jobs, Effort::Full)?;
        }
        Ok(found.into_iter().find(|found| found.fit.cost < base.fit.cost).unwrap_or(base))
    }

    /// Search models with a random-walk wrench, until the misfit of the best model is moderate without it or no further
    /// effect is found. Returns the model on which the best one improved.
    pub(super) fn search_softened(
        &self,
        base: &FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<FittedModel, InferError> {
        // Not needed if a single effect explains the misfit.
        if self.engine.softened(&models[0])?.is_none() {
            return Ok(base.clone());
        }
        let mut found = vec![base.clone()];
        let improved = self.repeat_softened(base, &mut found)?;
        insert_models(models, found);
        Ok(improved)
    }

    /// Search with a smaller and smaller random-walk wrench, until the best model needs none, stays the same or has no
    /// material gain. Returns the best model before the last round.
    fn repeat_softened(
        &self,
        base: &FittedModel,
        models: &mut Vec<FittedModel>,
    ) -> Result<FittedModel, InferError> {
        let mut improved = base.clone();
        for _ in 0..MAX_EFFECTS {
            let best = models[0].clone();
            let Some(softened) = self.engine.softened(&best)? else { break };
            let searcher = Searcher { engine: &*softened, is_softened: true, ..*self };
            let jobs = models.iter().map(|fitted| refit_job(fitted, base)).collect();
            let mut found = vec![];
            searcher.fit_all("effects and a random-walk wrench", jobs, &mut found)?;
            let Some(nominal) = found.iter().find(|t| t.added.is_empty()).cloned() else { break };
            searcher.add_effects(&nominal, &nominal, &mut found)?;
            let best_of_size =
                |size: usize| found.iter().filter(move |t| t.added.len() == size).take(MAX_FIRST_KINDS);
            let jobs: Vec<Job> =
                (1..=MAX_EFFECTS).flat_map(best_of_size).map(|t| refit_job(t, base)).collect();
            let count = jobs.len();
            self.fit_promising("effects without a random-walk wrench", jobs, count, models)?;
            if kinds(&models[0].added) == kinds(&best.added) {
                break;
            }
            improved = best;
            if !self.is_material_gain(&improved, &models[0])? {
                break;
            }
        }
        Ok(improved)
    }
}
