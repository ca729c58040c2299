//! Sampling of the posterior of a likelihood.

use crate::canonical::Canonical;
use crate::chain::{Chain, ChainSettings, Method};
use crate::modes::{self, Mode, ModeSummary, SearchExtent, search_modes};
use crate::sampler::chain;
use crate::{PosteriorError, Whitened};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use trundle_infer::{
    Channels, Density, Fit, FitOptions, Likelihood, PriorConflict, Target, Watch, on_all_cores,
};
use trundle_model::{Model, Slot};

/// Settings of sampling.
#[derive(Clone, Debug)]
pub struct SampleOptions {
    /// Sampling method.
    pub method: Method,
    /// Number of chains, each with its own start.
    pub chains: usize,
    /// Number of draws kept from each chain.
    pub draws: usize,
    /// Number of discarded draws before them.
    pub warmup: usize,
    /// Settings of the search for modes; its seed is also that of the chains.
    pub fit: FitOptions,
}

impl Default for SampleOptions {
    fn default() -> Self {
        Self { method: Method::default(), chains: 4, draws: 250, warmup: 150, fit: FitOptions::default() }
    }
}

impl SampleOptions {
    fn check(&self) -> Result<(), PosteriorError> {
        let wrong = |what, value: usize, remedy| {
            Err(PosteriorError::Setting { what, value: value.to_string(), remedy })
        };
        if self.chains == 0 {
            return wrong("chains", self.chains, "give at least 1; convergence checks require 2 or more");
        }
        if self.draws < 4 {
            return wrong("draws", self.draws, "give at least 4; intervals require several hundred");
        }
        if self.warmup < 50 && self.method != Method::Laplace {
            return wrong("warmup", self.warmup, "give at least 50 to tune the sampler");
        }
        Ok(())
    }
}

/// Draws of a posterior.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// The model.
    pub model: Model,
    /// The fit from which the chains start.
    pub fit: Fit,
    /// Slots of the free parameters, in the order of a draw.
    pub slots: Vec<Slot>,
    /// The chains; their points are in the coordinates of the search.
    pub chains: Vec<Chain>,
    /// Values of the free parameters, SI, by chain and draw.
    pub draws: Vec<Vec<Vec<f64>>>,
    /// Values of all slots of the model, by chain and draw.
    pub values: Vec<Vec<Vec<f64>>>,
    /// Whether the data determine the parameter, by the standard deviation of the draws.
    pub identified: Vec<bool>,
    /// Prior-data conflicts, as sentences.
    pub prior_conflicts: Vec<String>,
    /// The best mode, in the coordinates of the search.
    pub best: Vec<f64>,
    /// The modes in which chains start.
    pub modes: Vec<ModeSummary>,
    /// The assumed noise.
    pub channels: Channels,
    /// Names of the parameters with a separate value for each episode.
    pub per_episode: BTreeSet<String>,
}

/// Sample the free parameters of `model` with chains on all cores. The result does not depend on the number
/// of cores.
///
/// Unstated noise is fixed at the estimate of the fit.
///
/// # Errors
/// When a setting is invalid, no parameter is free, no start has a finite density, or the user interrupts.
pub fn sample(
    likelihood: &dyn Likelihood,
    model: &Model,
    options: &SampleOptions,
    watch: &dyn Watch,
) -> Result<Posterior, PosteriorError> {
    options.check()?;
    if Target::new(likelihood, model, &options.fit.per_episode)?.dimension() == 0 {
        return Err(PosteriorError::NothingFree);
    }
    let found = search_modes(likelihood, model, &[], &options.fit, SearchExtent::EveryMode, watch)?;
    let slots = model.slots().len();
    let tuned = likelihood.tuned(model, &all_values(&found.best, slots, likelihood))?;
    let likelihood = tuned.as_deref().unwrap_or(likelihood);
    let target = Target::new(likelihood, model, &options.fit.per_episode)?;
    let chains = run_chains(&target, &found.modes, options, watch)?;
    Ok(summarise(&target, found, chains, likelihood.channels(), &options.fit.per_episode))
}

/// Values of all slots at a fit, including the likelihood's own parameters.
fn all_values(fit: &Fit, slots: usize, likelihood: &dyn Likelihood) -> Vec<f64> {
    let own = likelihood.noise();
    let values = own.iter().map(|slot| fit.estimate(&slot.name).map_or(1.0, |e| e.mean));
    fit.values[..slots].iter().copied().chain(values).collect()
}

/// Runs the chains, which are assigned to the modes in turn.
fn run_chains(
    target: &Target<'_>,
    modes: &[Mode],
    options: &SampleOptions,
    watch: &dyn Watch,
) -> Result<Vec<Chain>, PosteriorError> {
    let total = (options.chains * (options.warmup + options.draws)) as f64;
    let done = AtomicUsize::new(0);
    on_all_cores(watch, |watch| {
        let tick = || {
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            watch.progress("sample", (count as f64 / total).min(1.0));
        };
        let white = modes.iter().map(|m| Whitened::new(target, &m.point, &m.precision));
        let views: Vec<_> = white.zip(modes::weights(modes)).collect();
        let one = |k: usize| {
            let settings = ChainSettings {
                warmup: options.warmup,
                draws: options.draws,
                seed: options.fit.seed,
                chain: k,
            };
            chain(options.method, &views, &settings, watch, &tick)
        };
        (0..options.chains).into_par_iter().map(one).collect()
    })
}

/// Draws in canonical form with their names, values and conflicts.
fn summarise(
    target: &Target<'_>,
    found: modes::FoundModes,
    mut chains: Vec<Chain>,
    channels: Channels,
    per_episode: &BTreeSet<String>,
) -> Posterior {
    let best = found.modes[0].point.clone();
    let canonical = Canonical::new(target, &best);
    for point in chains.iter_mut().flat_map(|c| &mut c.points) {
        *point = canonical.canonical_point(point);
    }
    let n = target.dimension();
    let of = |point: &Vec<f64>| (0..n).map(|k| target.value(k, point[k]).0).collect::<Vec<f64>>();
    let all = |point: &Vec<f64>| target.shared_values(point).0[..target.model().slots().len()].to_vec();
    let each = |f: &dyn Fn(&Vec<f64>) -> Vec<f64>| -> Vec<Vec<Vec<f64>>> {
        chains.iter().map(|c| c.points.iter().map(f).collect()).collect()
    };
    let (draws, values) = (each(&of), each(&all));
    let conflicts: Vec<Option<String>> = (0..n).map(|k| conflict(target, &found.modes[0], k)).collect();
    let is_determined = |k: usize| target.coordinates().identified(target.parameter(k), spread(&chains, k));
    let identified = (0..n).map(|k| conflicts[k].is_none() && is_determined(k)).collect();
    let shares = modes::weights(&found.modes);
    let modes = found.modes.iter().zip(shares);
    let modes = modes.map(|(m, weight)| ModeSummary { values: of(&m.point), weight }).collect();
    Posterior {
        model: target.model().clone(),
        fit: found.best,
        slots: (0..n).map(|k| target.slot(k)).collect(),
        draws,
        values,
        identified,
        prior_conflicts: conflicts.into_iter().flatten().collect(),
        best,
        modes,
        channels,
        per_episode: per_episode.clone(),
        chains,
    }
}

/// Sentence on a prior-data conflict of a parameter.
fn conflict(target: &Target<'_>, mode: &Mode, k: usize) -> Option<String> {
    let (coordinates, parameter) = (target.coordinates(), target.parameter(k));
    let prior = coordinates.prior_precision(parameter);
    let conflict = coordinates.prior_conflict(parameter, mode.point[k], mode.precision[(k, k)] - prior)?;
    Some(PriorConflict { name: target.slot(k).name, ..conflict }.to_string())
}

/// Standard deviation of a coordinate over all draws.
fn spread(chains: &[Chain], k: usize) -> f64 {
    let values: Vec<f64> = chains.iter().flat_map(|c| c.points.iter().map(|p| p[k])).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}
