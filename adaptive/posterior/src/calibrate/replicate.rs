//! One round of a calibration: draw, simulate, infer, rank.

use crate::calibrate::Calibration;
use crate::canonical::Canonical;
use crate::{Method, Posterior, PosteriorError, SampleOptions, sample};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use trundle_infer::{FitOptions, InferError, MotionLikelihood, Target, Watch, on_all_cores};

/// Number of draws among which a true value is ranked. The ranks are 0 to 399, so that central intervals
/// contain whole ranks.
pub const RANKS: usize = 399;

/// Result of one round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Replicate {
    /// Number of the round: its stream of random numbers.
    pub index: u64,
    /// True values of the recording, in the order of the posterior.
    pub truth: Vec<f64>,
    /// Posterior means.
    pub mean: Vec<f64>,
    /// Posterior standard deviations.
    pub sd: Vec<f64>,
    /// How many of [`RANKS`] draws are below the truth.
    pub rank: Vec<usize>,
    /// Number of divergent trajectories.
    pub divergences: usize,
    /// Number of sampled modes.
    pub modes: usize,
}

/// The rounds with the numbers `indices`, on all cores. The result does not depend on the number of cores.
///
/// # Errors
/// When a round fails, or the user interrupts.
pub fn replicates(
    calibration: &Calibration,
    indices: &[u64],
    seed: u64,
    watch: &dyn Watch,
) -> Result<Vec<Replicate>, PosteriorError> {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let found: Vec<Mutex<Option<_>>> = indices.iter().map(|_| Mutex::new(None)).collect();
    let work = |watch: &dyn Watch| {
        while let Some(k) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&k| k < indices.len()) {
            let round = calibration.replicate(indices[k], seed, watch);
            if let Ok(mut place) = found[k].lock() {
                *place = Some(round);
            }
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            watch.progress("calibrate", count as f64 / indices.len() as f64);
        }
    };
    // Separate threads, because a round waits for work on the common pool.
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    on_all_cores(watch, |watch| {
        std::thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(|| work(watch)))));
    });
    let interrupted = || Err(InferError::Interrupted.into());
    found.into_iter().map(|r| r.into_inner().ok().flatten().unwrap_or_else(interrupted)).collect()
}

/// Passes on cancellation but not progress.
struct Inner<'a>(&'a dyn Watch);

impl Watch for Inner<'_> {
    fn progress(&self, _: &str, _: f64) {}
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

impl Calibration {
    fn replicate(&self, index: u64, seed: u64, watch: &dyn Watch) -> Result<Replicate, PosteriorError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index + 1);
        let z = self.coordinates.draw(&mut rng);
        let values = self.coordinates.values(&z).0;
        let plant = self.model.plant(&values).map_err(InferError::from)?;
        let pushes: Vec<_> = (0..self.push.episodes).map(|k| self.push(&plant, k, &mut rng)).collect();
        let likelihood = MotionLikelihood::new(&pushes, &self.noise)?;
        let posterior = sample(&likelihood, &self.model, &self.options(rng.random()), &Inner(watch))?;
        let target = Target::new(&likelihood, &self.model, &BTreeSet::new())?;
        let truth = Canonical::new(&target, &posterior.best).canonical_point(&z);
        Ok(self.ranked(index, &target, &truth, &posterior))
    }

    fn options(&self, seed: u64) -> SampleOptions {
        let chains = if self.method == Method::Laplace { 1 } else { self.chains.max(1) };
        let fit = FitOptions { starts: self.starts, seed, ..FitOptions::default() };
        let draws = (RANKS + 1).div_ceil(chains).max(4);
        SampleOptions { method: self.method, chains, draws, warmup: self.warmup, fit }
    }

    fn ranked(&self, index: u64, target: &Target<'_>, truth: &[f64], posterior: &Posterior) -> Replicate {
        let draws: Vec<&Vec<f64>> = posterior.chains.iter().flat_map(|c| &c.points).take(RANKS).collect();
        let n = draws.len() as f64;
        let mean_of = |k: usize| draws.iter().map(|d| d[k]).sum::<f64>() / n;
        let rank = |k: usize| {
            let mean = mean_of(k);
            draws.iter().filter(|d| mean + self.shrink * (d[k] - mean) < truth[k]).count()
        };
        let values = posterior.draws.iter().flatten().collect::<Vec<_>>();
        let mean = |k: usize| values.iter().map(|v| v[k]).sum::<f64>() / values.len() as f64;
        let variance = |k: usize| {
            let mean = mean(k);
            values.iter().map(|v| (v[k] - mean).powi(2)).sum::<f64>() / values.len() as f64
        };
        let all = 0..truth.len();
        Replicate {
            index,
            truth: all.clone().map(|k| target.value(k, truth[k]).0).collect(),
            mean: all.clone().map(mean).collect(),
            sd: all.clone().map(|k| variance(k).sqrt()).collect(),
            rank: all.map(rank).collect(),
            divergences: posterior.chains.iter().flat_map(|c| &c.diverging).filter(|d| **d).count(),
            modes: posterior.modes.len(),
        }
    }
}
