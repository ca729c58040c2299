//! Global search: short searches rank the starts, and the best points are refined to convergence.

use crate::lbfgs;
use crate::levenberg::{self, Stop};
use crate::{Density, FitOptions, InferError, Linearised, Optimiser, Target, Watch, on_all_cores};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use trundle_model::Prior;

/// End point of a search.
pub(crate) struct Optimum {
    pub point: Vec<f64>,
    pub at: Linearised,
    pub converged: bool,
    /// Decrease of the cost in the last step.
    pub falling: f64,
}

const SCOUT: Stop = Stop { iterations: 14, decrease: 0.05, measure_gradient: false };
const POLISH: Stop = Stop { iterations: 60, decrease: 1e-5, measure_gradient: false };
/// Short comparison of two starts near an optimum.
const GLANCE: Stop = Stop { iterations: 4, decrease: 0.05, measure_gradient: false };
/// Decrease of the cost, nats, at which a search near its optimum has converged: a few hundredths of a
/// standard deviation.
const ARRIVED: f64 = 1e-3;

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
        Optimiser::Lbfgs => lbfgs::minimise(target, start, clamp, stop, watch),
    }
}

/// End of a short search: cost and point.
type End = (f64, Vec<f64>);

/// Number of starts with the same end, and number of starts.
pub(crate) type Agreement = (usize, usize);

/// Whether two searches ended at the lowest of these sorted costs. A local optimum is then unlikely.
fn doubled(costs: &[f64]) -> bool {
    costs.len() > 1 && costs[1] < costs[0] + 1.0
}

/// Points found by short searches from given values and prior draws, best first, and the number of starts
/// that ended within one unit of log density of the best. Each search passes through the densities of
/// `continuation`, the last of which ranks the ends. Runs on all cores; the result does not depend on their
/// number.
pub(crate) fn scout(
    ladder: &[Target<'_>],
    warm: &[Vec<f64>],
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<(Vec<Vec<f64>>, Agreement), InferError> {
    let Some(target) = ladder.last() else { return Ok((vec![], (0, 0))) };
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let given = warm.iter().map(|values| Ok(target.point(values)));
    let drawn = (0..options.starts).map(|_| target.rescaled(target.draw(&mut rng)));
    let starts = given.chain(drawn).collect::<Result<Vec<_>, InferError>>()?;
    let count = starts.len();
    let mut found = ends(ladder, starts, options.optimiser, watch)?;
    if found.is_empty() {
        return Err(InferError::NoStart { recording: "the recording".to_owned(), starts: count });
    }
    let costs: Vec<f64> = found.iter().map(|(cost, _)| *cost).collect();
    let unsure = options.starts > 0 && !doubled(&costs);
    if unsure || (options.from_afar && astray(target, &found[0].1)) {
        found = hop(ladder, found, options.optimiser, watch)?;
    }
    let agree = costs.iter().filter(|&&cost| cost < found[0].0 + 1.0).count();
    Ok((found.into_iter().map(|(_, point)| point).collect(), (agree, count)))
}

/// Distance from the prior centre, in standard deviations, beyond which a search is taken to have diverged.
const AWAY: f64 = 3.0;

/// Whether a search diverged, as along the valley of a local optimum.
fn astray(target: &Target<'_>, z: &[f64]) -> bool {
    let angle = |k: usize| matches!(target.slot(k).prior, Prior::Angle(_));
    z.iter().enumerate().any(|(k, z)| z.abs() > AWAY && !angle(k))
}

/// End of a short search; `None` if the density is not finite at its start.
fn short(
    target: &Target<'_>,
    start: &[f64],
    optimiser: Optimiser,
    watch: &dyn Watch,
) -> Result<Option<Optimum>, InferError> {
    let point = start.to_vec();
    if optimiser == Optimiser::Lbfgs {
        let somewhere = target.cost(start)?.is_finite();
        return somewhere.then(|| descend(target, point, SCOUT, optimiser, watch)).transpose();
    }
    let at = target.linearise(start)?;
    let clamp = |k, z| target.clamp(k, z);
    let somewhere = at.cost.is_finite();
    somewhere.then(|| levenberg::from(target, point, at, clamp, SCOUT, watch)).transpose()
}

/// Ends of short searches from `starts`, best first. Starts with an infinite cost are dropped.
fn ends(
    ladder: &[Target<'_>],
    starts: Vec<Vec<f64>>,
    optimiser: Optimiser,
    watch: &dyn Watch,
) -> Result<Vec<End>, InferError> {
    let (count, done) = (starts.len(), AtomicUsize::new(0));
    let one = |start: Vec<f64>, watch: &dyn Watch| {
        let mut end = (f64::INFINITY, start);
        for target in ladder {
            end = match short(target, &end.1, optimiser, watch)? {
                Some(optimum) => (optimum.at.cost, optimum.point),
                None => (f64::INFINITY, end.1),
            };
        }
        watch.progress("fit", (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / count as f64);
        Ok(end.0.is_finite().then_some(end))
    };
    let ends = on_all_cores(watch, |watch| {
        starts.into_par_iter().map(|start| one(start, watch)).collect::<Result<Vec<_>, InferError>>()
    })?;
    let mut found: Vec<End> = ends.into_iter().flatten().collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(found)
}

/// Repeats the search from the symmetric counterparts of the best end until the cost no longer improves.
fn hop(
    ladder: &[Target<'_>],
    mut found: Vec<End>,
    optimiser: Optimiser,
    watch: &dyn Watch,
) -> Result<Vec<End>, InferError> {
    for _ in 0..HOPS {
        let Some((cost, best)) = found.first().cloned() else { break };
        let others = ladder.last().map_or_else(Vec::new, |target| elsewhere(target, &best));
        if others.is_empty() {
            break;
        }
        found.extend(ends(ladder, others, optimiser, watch)?);
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        if found[0].0 > cost - 1.0 {
            break;
        }
    }
    Ok(found)
}

/// Maximum number of rounds of [`hop`].
const HOPS: usize = 3;

/// Candidates for other optima: a place mirrored about the middle of the body, an angle turned by half its
/// period (a wheel across instead of along), and diverged parameters reset to the prior centre.
fn elsewhere(target: &Target<'_>, z: &[f64]) -> Vec<Vec<f64>> {
    let turned = |k: usize, z: f64, along: [bool; 2], turn: f64| match target.slot(k).prior {
        Prior::OnBody(axis) if along[axis.min(1)] => -z,
        Prior::Angle(period) => z + turn * period,
        _ if z.abs() > AWAY => 0.0,
        _ => z,
    };
    let whole =
        |along, turn| z.iter().enumerate().map(|(k, &z)| turned(k, z, along, turn)).collect::<Vec<_>>();
    let all = [
        whole([true, true], 0.0),
        whole([true, false], 0.0),
        whole([false, true], 0.0),
        whole([false, false], 0.5),
        whole([false, false], 0.0),
    ];
    all.into_iter().filter(|other| other != z).collect()
}

/// Refines some points and returns the best optimum.
pub(crate) fn polish(
    target: &Target<'_>,
    points: Vec<Vec<f64>>,
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let stop = Stop { measure_gradient: options.measure_gradient, ..POLISH };
    let mut best: Option<Optimum> = None;
    let starts = points.len();
    for point in points {
        let optimum = descend(target, point, stop, options.optimiser, watch)?;
        if best.as_ref().is_none_or(|b| optimum.at.cost < b.at.cost) {
            best = Some(optimum);
        }
    }
    best.ok_or_else(|| InferError::NoStart { recording: "the recording".to_owned(), starts })
}

/// From starts near an optimum: a few steps from the two best starts, then at most `steps` steps in all from
/// the better one.
pub(crate) fn follow(
    target: &Target<'_>,
    starts: Vec<Vec<f64>>,
    steps: usize,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let count = starts.len();
    let ranked = starts.into_iter().map(|point| Ok((target.cost(&point)?, point)));
    let mut ranked = ranked.collect::<Result<Vec<_>, InferError>>()?;
    ranked.retain(|(cost, _)| cost.is_finite());
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let clamp = |k, z| target.clamp(k, z);
    let stop = Stop { iterations: GLANCE.iterations.min(steps), ..GLANCE };
    let glance = |(_, point)| levenberg::minimise(target, point, clamp, stop, watch);
    let looked = ranked.into_iter().take(2).map(glance).collect::<Result<Vec<_>, _>>()?;
    let Some(best) = looked.into_iter().min_by(|a, b| a.at.cost.total_cmp(&b.at.cost)) else {
        return Err(InferError::NoStart { recording: "the recording".to_owned(), starts: count });
    };
    let rest = Stop {
        iterations: steps.saturating_sub(stop.iterations),
        decrease: ARRIVED,
        measure_gradient: false,
    };
    if rest.iterations == 0 || best.converged && best.falling < ARRIVED {
        return Ok(best);
    }
    levenberg::from(target, best.point, best.at, clamp, rest, watch)
}
