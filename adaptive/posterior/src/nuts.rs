//! No-U-Turn sampler of nuts-rs on a whitened density.
//!
//! The gradient of the motion likelihood holds the filter's gains fixed, so it is approximate. The draws are
//! still exact: the leapfrog integrator is reversible and volume-preserving with any force that depends on
//! the position alone, and the choice among the points of a trajectory uses the exact density. An inaccurate
//! gradient only lowers the acceptance rate, to which the step size adapts.

use crate::chain::{Chain, ChainSettings};
use crate::{PosteriorError, Whitened};
use nuts_rs::{
    Chain as _, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError, Settings,
};
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use thiserror::Error;
use trundle_infer::{InferError, Watch};

/// Maximum tree depth: 2⁸ steps.
const MAX_TREE_DEPTH: u64 = 8;

/// Errors of evaluating the density.
#[derive(Debug, Error)]
enum DensityError {
    #[error("the density is not finite")]
    NotFinite,
    #[error(transparent)]
    Failed(#[from] InferError),
}

impl LogpError for DensityError {
    fn is_recoverable(&self) -> bool {
        matches!(self, Self::NotFinite)
    }
}

/// Points evaluated in the current trajectory, with their log density.
type EvaluatedPoints = Arc<Mutex<Vec<(Vec<f64>, f64)>>>;

struct Posterior<'a> {
    density: &'a Whitened<'a>,
    watch: &'a dyn Watch,
    evaluated: EvaluatedPoints,
}

impl HasDims for Posterior<'_> {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("parameter".to_owned(), self.density.dimension() as u64)])
    }
}

impl CpuLogpFunc for Posterior<'_> {
    type LogpError = DensityError;
    type FlowParameters = ();
    type ExpandedVector = Vec<f64>;

    fn dim(&self) -> usize {
        self.density.dimension()
    }

    fn logp(&mut self, w: &[f64], gradient: &mut [f64]) -> Result<f64, DensityError> {
        if self.watch.cancelled() {
            return Err(InferError::Interrupted.into());
        }
        let (cost, slope) = self.density.cost_and_gradient(w)?;
        if !cost.is_finite() || slope.iter().any(|s| !s.is_finite()) {
            return Err(DensityError::NotFinite);
        }
        for (g, s) in gradient.iter_mut().zip(slope.iter()) {
            *g = -s;
        }
        if let Ok(mut evaluated) = self.evaluated.lock() {
            evaluated.push((w.to_vec(), -cost));
        }
        Ok(-cost)
    }

    fn expand_vector<R: nuts_rs::rand::Rng + ?Sized>(
        &mut self,
        _: &mut R,
        w: &[f64],
    ) -> Result<Vec<f64>, CpuMathError> {
        Ok(w.to_vec())
    }
}

/// Samples one chain from `start`, a point `w`.
pub(crate) fn chain(
    density: &Whitened<'_>,
    start: Vec<f64>,
    settings: &ChainSettings,
    rng: &mut ChaCha8Rng,
    watch: &dyn Watch,
    tick: &(dyn Fn() + Sync),
) -> Result<Chain, PosteriorError> {
    let evaluated = EvaluatedPoints::default();
    let math = CpuMath::new(Posterior { density, watch, evaluated: evaluated.clone() });
    let failed = |error| sampler_error(error, watch, settings.chain);
    let mut sampler = nuts_settings(settings).new_chain(settings.chain as u64, math, rng).map_err(failed)?;
    sampler.set_position(&start).map_err(failed)?;
    let (mut kept, mut latest) = (Chain::default(), -density.cost(&start)?);
    for step in 0..settings.warmup + settings.draws {
        let (w, info) = sampler.draw().map_err(failed)?;
        latest = log_density(&evaluated, &w).unwrap_or(latest);
        if step < settings.warmup {
            kept.warmup_evaluations += info.num_gradients;
        } else {
            kept.push(density.point(&w), latest, info.diverging, info.num_gradients);
        }
        kept.step_size = info.step_size;
        tick();
    }
    Ok(kept)
}

fn nuts_settings(settings: &ChainSettings) -> DiagNutsSettings {
    DiagNutsSettings {
        num_tune: settings.warmup as u64,
        num_draws: settings.draws as u64,
        maxdepth: MAX_TREE_DEPTH,
        ..DiagNutsSettings::default()
    }
}

/// Log density of a drawn point, which the trajectory has just evaluated; `None` if the chain did not move.
fn log_density(evaluated: &EvaluatedPoints, w: &[f64]) -> Option<f64> {
    let mut evaluated = evaluated.lock().ok()?;
    let found = evaluated.iter().rev().find(|(point, _)| point == w).map(|(_, value)| *value);
    evaluated.clear();
    found
}

/// Converts an error of the sampler.
fn sampler_error(
    error: impl std::fmt::Display + Into<Box<dyn std::error::Error + Send + Sync>>,
    watch: &dyn Watch,
    chain: usize,
) -> PosteriorError {
    if watch.cancelled() {
        return InferError::Interrupted.into();
    }
    PosteriorError::Chain { chain, reason: error.to_string() }
}
