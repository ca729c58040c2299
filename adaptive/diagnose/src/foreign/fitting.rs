//! Fits of laws along the seen motion.

use super::black_box::{Basis, BlackBox, on_object};
use super::likelihood::Along;
use crate::engine::{Effort, Job, Tried};
use rayon::prelude::*;
use std::sync::Arc;
use trundle_infer::{Fit, FitOptions, InferError, Watch, fit};
use trundle_model::Model;

/// Fits of a law on the object, each trusting it as far as the one before says.
const ROUNDS: usize = 2;
/// Starts that a search gives for each place of an effect: two steps, with and without what they shift.
const OF_A_PLACE: usize = 4;
/// Linearisations of one model at most.
const TURNS: usize = 4;
/// Change of the logarithm of a parameter below which a model is settled.
const STILL: f64 = 0.03;
impl BlackBox<'_> {
    /// Fit laws where the simulator is linearised, and, to the end, where its parameters went.
    pub(super) fn fit_laws(
        &self,
        job: Job,
        effort: Effort,
        seed: u64,
        watch: &dyn Watch,
    ) -> Result<Tried, InferError> {
        let mut model = self.bare.clone();
        model.effects.extend(job.added.iter().cloned());
        let near = Some(effort.steps());
        let options =
            FitOptions { starts: 0, seed, distant_starts: false, local_steps: near, ..FitOptions::default() };
        let (mut along, own) = match job.basis {
            Some(Basis { along, own, biased: false }) => (along, own),
            _ => (self.along.clone(), self.along.values.clone()),
        };
        if along.channels != job.channels {
            along = Arc::new(along.with_channels(job.channels).sketched());
        }
        let start = |laws: &Vec<f64>| laws.iter().chain(&own).copied().collect();
        let starts: Vec<Vec<f64>> = job.warm.iter().map(start).collect();
        // Those of each place are followed: which place leads where is not seen from its beginning.
        let one = |of_place: &[Vec<f64>]| fitted(&along, &model, of_place, &options, watch);
        let all = starts.par_chunks(OF_A_PLACE).map(one).collect::<Result<Vec<_>, InferError>>()?;
        let best = all.into_iter().min_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
        let Some(mut found) = best else {
            return Err(InferError::NoStart { recording: self.data.name.clone(), starts: 0 });
        };
        let turns = if effort == Effort::Full { TURNS } else { 0 };
        for _ in 0..turns {
            let values = along.trusted(&found);
            let still = |(a, b): (&f64, &f64)| (a - b).abs() < STILL * b.abs().max(1e-9);
            if values.iter().zip(&along.values).all(still) {
                break;
            }
            let dof = self.bare.dof;
            let anew = Along::new(self.foreign, &values, &self.paths, along.channels, dof, watch)?;
            along = Arc::new(anew);
            let at: Vec<f64> = found.values.iter().chain(&values).copied().collect();
            found = fitted(&along, &model, &[at], &options, watch)?;
        }
        let own = along.own(&found);
        Ok(Tried::new(job.added, found, Some(Basis { along, own, biased: false })))
    }
}

/// Fit laws together with the simulator's parameters where it is linearised.
fn fitted(
    along: &Along,
    model: &Model,
    starts: &[Vec<f64>],
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Fit, InferError> {
    let mut found = fit(along, model, starts, options, watch)?;
    if !on_object(model) {
        return Ok(found);
    }
    for _ in 0..ROUNDS {
        let own = along.own(&found);
        let doubting = along.doubting(&found.model.plant(&found.values)?, &own);
        let at: Vec<f64> = found.values.iter().copied().chain(own).collect();
        found = fit(&doubting, model, &[at], options, watch)?;
    }
    Ok(found)
}
