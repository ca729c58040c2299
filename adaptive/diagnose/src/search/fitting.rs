//! Fits of candidate models in stages: on thinned data, a few steps on all data, and to the optimum.

use super::Searcher;
use super::effects::have_same_effects;
use super::prior::log_prior;
use crate::fitted_model::{Effort, FittedModel, Job};
use rayon::prelude::*;
use trundle_infer::{InferError, on_all_cores};

/// Largest cost above that of the best model, after the ranking fit, at which a model is fitted to its
/// optimum: in nats, and as a share of the best model's gain. Each model is credited with
/// `EXTRAPOLATED_STEPS` further steps like its last one.
const MAX_COST_GAP_NATS: f64 = 30.0;
const MAX_COST_GAP_SHARE: f64 = 0.1;
const EXTRAPOLATED_STEPS: f64 = 10.0;

/// Stages of fits: their name for the progress, the number of models that are ranked, and a model on which they must
/// improve on thinned data to be ranked.
pub(super) struct Stages<'a> {
    pub what: &'static str,
    pub most: usize,
    pub compared_with: Option<&'a FittedModel>,
}

impl Searcher<'_> {
    /// Fit models that were not fitted before, as [`Self::fit_promising`].
    pub(super) fn fit_new(
        &self,
        what: &'static str,
        jobs: Vec<Job>,
        most: usize,
        models: &mut Vec<FittedModel>,
    ) -> Result<(), InferError> {
        let is_new = |job: &Job| models.iter().all(|t| !have_same_effects(&t.added, &job.added));
        let jobs = jobs.into_iter().filter(is_new).collect();
        self.fit_promising(what, jobs, most, models)
    }

    /// Fit models, of which at most `most` are ranked. Only those that may still become the best are fitted to their
    /// optimum.
    pub(super) fn fit_promising(
        &self,
        what: &'static str,
        jobs: Vec<Job>,
        most: usize,
        models: &mut Vec<FittedModel>,
    ) -> Result<(), InferError> {
        let known = lowest(models.iter().map(|t| t.fit.cost));
        let from = Some(lowest(jobs.iter().map(|j| j.from))).filter(|cost| cost.is_finite()).unwrap_or(known);
        let stages = Stages { what, most, compared_with: None };
        self.fit_in_stages(stages, jobs, models, |ranked| {
            let best = lowest(ranked.iter().map(|t| t.fit.cost)).min(known);
            best + MAX_COST_GAP_NATS.max(MAX_COST_GAP_SHARE * (from - best))
        })
    }

    /// Fit models in three stages: on thinned data, a few steps on all data for the best `most` of them, and to the
    /// optimum if the cost may still fall below `bound` of the ranked models.
    pub(super) fn fit_in_stages(
        &self,
        Stages { what, most, compared_with }: Stages<'_>,
        jobs: Vec<Job>,
        models: &mut Vec<FittedModel>,
        bound: impl Fn(&[FittedModel]) -> f64,
    ) -> Result<(), InferError> {
        let Some(thinned) = self.engine.thinned() else { return self.fit_all(what, jobs, models) };
        let continued = |t: &FittedModel| Job::from(t, t.added.clone(), vec![t.fit.values.clone()]);
        let cheaper = Searcher { engine: &*thinned, ..*self };
        let given = jobs.clone();
        let mut screened = cheaper.fitted(what, jobs, Effort::Screening)?;
        if let Some(other) = compared_with {
            let other = cheaper.fitted(what, vec![continued(other)], Effort::Screening)?;
            screened.retain(|t| other.iter().all(|other| t.fit.cost < other.fit.cost));
        }
        screened.sort_by(|a, b| b.log_weight().total_cmp(&a.log_weight()));
        screened.truncate(most);
        let mut ranked = vec![];
        let once = screened.iter().map(continued).collect();
        insert_models(&mut ranked, self.fitted(what, once, Effort::Ranking)?);
        // The fit to thinned data may have increased the cost. Such a model is ranked from its first starts too.
        let with_first_starts = |t: &FittedModel| {
            let first = given.iter().find(|job| job.added == t.added)?;
            let is_lower = |r: &FittedModel| r.added == t.added && r.fit.cost < first.from;
            let warm = [vec![t.fit.values.clone()], first.warm.clone()].concat();
            (!ranked.iter().any(is_lower)).then(|| Job::from(t, t.added.clone(), warm))
        };
        let repeated = screened.iter().filter_map(with_first_starts).collect();
        insert_models(&mut ranked, self.fitted(what, repeated, Effort::Ranking)?);
        let bound = bound(&ranked);
        let is_promising = |t: &FittedModel| t.fit.cost - EXTRAPOLATED_STEPS * t.fit.last_decrease < bound;
        let (promising, others): (Vec<FittedModel>, Vec<FittedModel>) =
            ranked.into_iter().partition(is_promising);
        let optima = self.fitted(what, promising.iter().map(continued).collect(), Effort::Full)?;
        insert_models(models, optima.into_iter().chain(others));
        Ok(())
    }

    /// Fit models to their optimum, including models that were fitted before.
    pub(super) fn fit_all(
        &self,
        what: &'static str,
        jobs: Vec<Job>,
        models: &mut Vec<FittedModel>,
    ) -> Result<(), InferError> {
        insert_models(models, self.fitted(what, jobs, Effort::Full)?);
        Ok(())
    }

    /// Fit models in parallel. Models that cannot be evaluated at any starting point are left out; this
    /// happens under noise that was fitted with more effects.
    pub(super) fn fitted(
        &self,
        what: &'static str,
        jobs: Vec<Job>,
        effort: Effort,
    ) -> Result<Vec<FittedModel>, InferError> {
        self.watch.progress(what, 0.0);
        let offered = self.engine.candidates().iter().filter(|kind| self.is_allowed(**kind)).count();
        let (count, done) = (jobs.len(), std::sync::atomic::AtomicUsize::new(0));
        on_all_cores(self.watch, |watch| {
            let one = |job: Job| {
                let prior = log_prior(job.added.len(), offered);
                let found = self.engine.fit(job, effort, self.seed, watch);
                let found = found.map(|fitted| FittedModel { log_prior: prior, ..fitted });
                let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                watch.progress(what, done as f64 / count as f64);
                found
            };
            let all: Vec<_> = jobs.into_par_iter().map(one).collect();
            all.into_iter().filter(|found| !matches!(found, Err(InferError::NoStart { .. }))).collect()
        })
    }
}

/// The lowest of some costs.
fn lowest(costs: impl Iterator<Item = f64>) -> f64 {
    costs.fold(f64::INFINITY, f64::min)
}

/// Insert models into the fitted ones, sorted by weight. Of models with the same effects only the best is
/// kept.
pub(super) fn insert_models(models: &mut Vec<FittedModel>, more: impl IntoIterator<Item = FittedModel>) {
    models.extend(more);
    models.sort_by(|a, b| b.log_weight().total_cmp(&a.log_weight()));
    let mut kept: Vec<FittedModel> = Vec::with_capacity(models.len());
    for one in models.drain(..) {
        if kept.iter().all(|k| !have_same_effects(&k.added, &one.added)) {
            kept.push(one);
        }
    }
    *models = kept;
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::Stages;
    use crate::engine::Engine;
    use crate::engine::plant_engine::PlantEngine;
    use crate::search::{Searcher, kinds};
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::Quiet;
    use trundle_model::Kind;

    #[test]
    fn models_that_do_not_improve_on_thinned_data_are_not_ranked() {
        let slope = effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]);
        let data = World::of(locked().with(slope)).recording(3);
        let engine = PlantEngine::new(&data, None).unwrap();
        let base = engine.base(0, &Quiet).unwrap();
        let searcher = Searcher::new(&engine, &[], 0, &Quiet);
        let jobs = |kind| searcher.jobs(&base, &[kind], 1, 1).unwrap();
        let mut models = vec![base.clone()];
        searcher.fit_new("one effect", jobs(Kind::FloorSlope), 1, &mut models).unwrap();
        let best = models[0].clone();
        assert_eq!(kinds(&best.added), [Kind::FloorSlope]);
        let mut added = |compared_with| {
            let stages = Stages { what: "one effect", most: 1, compared_with };
            searcher.fit_in_stages(stages, jobs(Kind::ForceScale), &mut models, |_| f64::INFINITY).unwrap();
            models.len() - 2
        };
        assert_eq!(added(Some(&best)), 0);
        assert_eq!(added(None), 1);
    }
}
