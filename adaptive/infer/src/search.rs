//! Global search: short searches rank the starts, and the best points are refined to convergence.

use crate::fit_options::{FitOptions, Optimiser};
use crate::lbfgs;
use crate::levenberg;
use crate::optimum::{Optimum, Stop};
use crate::{Density, InferError, Target, Watch, on_all_cores};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use trundle_model::Prior;

const SHORT_SEARCH_STOP: Stop = Stop { iterations: 14, decrease: 0.05, measure_gradient: false };
const REFINEMENT_STOP: Stop = Stop { iterations: 60, decrease: 1e-5, measure_gradient: false };
/// Short comparison of two starts near an optimum.
const COMPARISON_STOP: Stop = Stop { iterations: 4, decrease: 0.05, measure_gradient: false };
/// Decrease of the cost, nats, at which a search near its optimum has converged: a few hundredths of a
/// standard deviation.
const MIN_DECREASE_NATS: f64 = 1e-3;

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
fn is_reproduced(costs: &[f64]) -> bool {
    costs.len() > 1 && costs[1] < costs[0] + 1.0
}

/// Points found by short searches from given values and prior draws, best first, and the number of starts
/// that ended within one unit of log density of the best. Each search passes through the densities of
/// `continuation`, the last of which ranks the ends. Runs on all cores; the result does not depend on their
/// number.
pub(crate) fn search_starts(
    continuation: &[Target<'_>],
    warm: &[Vec<f64>],
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<(Vec<Vec<f64>>, Agreement), InferError> {
    let Some(target) = continuation.last() else { return Ok((vec![], (0, 0))) };
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let given = warm.iter().map(|values| Ok(target.point(values)));
    let drawn = (0..options.starts).map(|_| target.rescaled(target.draw(&mut rng)));
    let starts = given.chain(drawn).collect::<Result<Vec<_>, InferError>>()?;
    let count = starts.len();
    let mut found = search_ends(continuation, starts, options.optimiser, watch)?;
    if found.is_empty() {
        return Err(InferError::NoStart { recording: "the recording".to_owned(), starts: count });
    }
    let costs: Vec<f64> = found.iter().map(|(cost, _)| *cost).collect();
    let unsure = options.starts > 0 && !is_reproduced(&costs);
    if unsure || (options.distant_starts && has_diverged(target, &found[0].1)) {
        found = search_symmetric(continuation, found, options.optimiser, watch)?;
    }
    let agree = costs.iter().filter(|&&cost| cost < found[0].0 + 1.0).count();
    Ok((found.into_iter().map(|(_, point)| point).collect(), (agree, count)))
}

/// Distance from the prior centre, in standard deviations, beyond which a search is taken to have diverged.
const MAX_PLAUSIBLE_Z: f64 = 3.0;

/// Whether a search diverged, as along the valley of a local optimum.
fn has_diverged(target: &Target<'_>, z: &[f64]) -> bool {
    let angle = |k: usize| matches!(target.slot(k).prior, Prior::Angle(_));
    z.iter().enumerate().any(|(k, z)| z.abs() > MAX_PLAUSIBLE_Z && !angle(k))
}

/// End of a short search; `None` if the density is not finite at its start.
fn short_search(
    target: &Target<'_>,
    start: &[f64],
    optimiser: Optimiser,
    watch: &dyn Watch,
) -> Result<Option<Optimum>, InferError> {
    let point = start.to_vec();
    if optimiser == Optimiser::Lbfgs {
        let is_finite = target.cost(start)?.is_finite();
        return is_finite.then(|| descend(target, point, SHORT_SEARCH_STOP, optimiser, watch)).transpose();
    }
    let at = target.linearise(start)?;
    let clamp = |k, z| target.clamp(k, z);
    let is_finite = at.cost.is_finite();
    is_finite
        .then(|| levenberg::minimise_from(target, point, at, clamp, SHORT_SEARCH_STOP, watch))
        .transpose()
}

/// Ends of short searches from `starts`, best first. Starts with an infinite cost are dropped.
fn search_ends(
    continuation: &[Target<'_>],
    starts: Vec<Vec<f64>>,
    optimiser: Optimiser,
    watch: &dyn Watch,
) -> Result<Vec<End>, InferError> {
    let (count, done) = (starts.len(), AtomicUsize::new(0));
    let one = |start: Vec<f64>, watch: &dyn Watch| {
        let mut end = (f64::INFINITY, start);
        for target in continuation {
            end = match short_search(target, &end.1, optimiser, watch)? {
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
fn search_symmetric(
    continuation: &[Target<'_>],
    mut found: Vec<End>,
    optimiser: Optimiser,
    watch: &dyn Watch,
) -> Result<Vec<End>, InferError> {
    for _ in 0..MAX_HOPS {
        let Some((cost, best)) = found.first().cloned() else { break };
        let others = continuation.last().map_or_else(Vec::new, |target| symmetric_points(target, &best));
        if others.is_empty() {
            break;
        }
        found.extend(search_ends(continuation, others, optimiser, watch)?);
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        if found[0].0 > cost - 1.0 {
            break;
        }
    }
    Ok(found)
}

/// Maximum number of rounds of [`search_symmetric`].
const MAX_HOPS: usize = 3;

/// Candidates for other optima: a place mirrored about the middle of the body, an angle turned by half its
/// period (a wheel across instead of along), and diverged parameters reset to the prior centre.
fn symmetric_points(target: &Target<'_>, z: &[f64]) -> Vec<Vec<f64>> {
    let turned = |k: usize, z: f64, along: [bool; 2], turn: f64| match target.slot(k).prior {
        Prior::OnBody(axis) if along[axis.min(1)] => -z,
        Prior::Angle(period) => z + turn * period,
        _ if z.abs() > MAX_PLAUSIBLE_Z => 0.0,
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
pub(crate) fn refine(
    target: &Target<'_>,
    points: Vec<Vec<f64>>,
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let stop = Stop { measure_gradient: options.measure_gradient, ..REFINEMENT_STOP };
    let starts = points.len();
    let one = |point, watch: &dyn Watch| converge(target, point, stop, options.optimiser, watch);
    let optima = on_all_cores(watch, |watch| {
        points.into_par_iter().map(|point| one(point, watch)).collect::<Result<Vec<_>, InferError>>()
    })?;
    let best = optima.into_iter().min_by(|a, b| a.at.cost.total_cmp(&b.at.cost));
    best.ok_or_else(|| InferError::NoStart { recording: "the recording".to_owned(), starts })
}

/// A search is repeated under a smaller misfit if that has fallen to less than this share while it ran.
const REPEATED_MISFIT_SHARE: f64 = 0.5;

/// Searches until the decrease of the cost is negligible in relation to the misfit that remains: residuals of `f` times
/// the variance of the noise make an optimum `f` times as uncertain, in variance, and a decrease of the cost count for
/// `1/f` of its nats (quasi-likelihood; Wedderburn 1974).
fn converge(
    target: &Target<'_>,
    start: Vec<f64>,
    stop: Stop,
    optimiser: Optimiser,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let until = |factor: f64, start| descend(target, start, stop.scaled(factor), optimiser, watch);
    let mut factor = target.misfit_factor(&start)?;
    let mut found = until(factor, start)?;
    loop {
        let remaining = target.misfit_factor(&found.point)?;
        if remaining > REPEATED_MISFIT_SHARE * factor {
            return Ok(found);
        }
        factor = remaining;
        found = until(factor, found.point)?;
    }
}

/// From starts near an optimum: a few steps from the two best starts, then at most `steps` steps in all from
/// the better one.
pub(crate) fn refine_near(
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
    let stop = Stop { iterations: COMPARISON_STOP.iterations.min(steps), ..COMPARISON_STOP };
    let compare = |(_, point)| levenberg::minimise(target, point, clamp, stop, watch);
    let compared = ranked.into_iter().take(2).map(compare).collect::<Result<Vec<_>, _>>()?;
    let Some(best) = compared.into_iter().min_by(|a, b| a.at.cost.total_cmp(&b.at.cost)) else {
        return Err(InferError::NoStart { recording: "the recording".to_owned(), starts: count });
    };
    let remaining = Stop {
        iterations: steps.saturating_sub(stop.iterations),
        decrease: MIN_DECREASE_NATS,
        measure_gradient: false,
    };
    let remaining = remaining.scaled(target.misfit_factor(&best.point)?);
    if remaining.iterations == 0 || best.converged && best.last_decrease < remaining.decrease {
        return Ok(best);
    }
    levenberg::minimise_from(target, best.point, best.at, clamp, remaining, watch)
}
