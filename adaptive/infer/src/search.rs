//! From many starts to one optimum: short searches sort the starts, the best are followed to the end.

use crate::levenberg::{self, Stop};
use crate::{Density, FitOptions, InferError, Linearised, Optimiser, Target, Watch, on_all_cores};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Where a search ended.
pub(crate) struct Optimum {
    pub point: Vec<f64>,
    pub at: Linearised,
    pub converged: bool,
}

const SCOUT: Stop = Stop { iterations: 14, decrease: 0.05 };
const POLISH: Stop = Stop { iterations: 60, decrease: 1e-5 };

fn descend(
    target: &Target<'_>,
    start: Vec<f64>,
    stop: Stop,
    optimiser: Optimiser,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let clamp = |k, z| target.clamp(k, z);
    match optimiser {
        Optimiser::LevenbergMarquardt => levenberg::minimise(target, start, clamp, stop, watch),
    }
}

/// Points found by short searches from given values and draws of the prior, best first. On all cores, with the
/// same result as on one.
pub(crate) fn scout(
    target: &Target<'_>,
    warm: &[Vec<f64>],
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Vec<Vec<f64>>, InferError> {
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let given = warm.iter().map(|values| target.point(values));
    let drawn = (0..options.starts).map(|_| target.draw(&mut rng));
    let starts: Vec<_> = given.chain(drawn).collect();
    let (count, done) = (starts.len(), AtomicUsize::new(0));
    let one = |start: Vec<f64>, watch: &dyn Watch| {
        if !target.cost(&start)?.is_finite() {
            return Ok(None);
        }
        let optimum = descend(target, start, SCOUT, options.optimiser, watch)?;
        watch.progress("fit", (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / count as f64);
        Ok(Some((optimum.at.cost, optimum.point)))
    };
    let ends = on_all_cores(watch, |watch| {
        starts.into_par_iter().map(|start| one(start, watch)).collect::<Result<Vec<_>, InferError>>()
    })?;
    let mut found: Vec<_> = ends.into_iter().flatten().collect();
    if found.is_empty() {
        return Err(InferError::NoStart { recording: "the recording".to_owned(), starts: count });
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(found.into_iter().map(|(_, point)| point).collect())
}

/// The best optimum from some points, and how many of them lead there.
pub(crate) fn polish(
    target: &Target<'_>,
    points: Vec<Vec<f64>>,
    optimiser: Optimiser,
    watch: &dyn Watch,
) -> Result<(Optimum, (usize, usize)), InferError> {
    let mut best: Option<Optimum> = None;
    let mut costs = Vec::with_capacity(points.len());
    for point in points {
        let optimum = descend(target, point, POLISH, optimiser, watch)?;
        costs.push(optimum.at.cost);
        if best.as_ref().is_none_or(|b| optimum.at.cost < b.at.cost) {
            best = Some(optimum);
        }
    }
    let Some(best) = best else {
        return Err(InferError::NoStart { recording: "the recording".to_owned(), starts: costs.len() });
    };
    let agree = costs.iter().filter(|&&c| c < best.at.cost + 1.0).count();
    Ok((best, (agree, costs.len())))
}
