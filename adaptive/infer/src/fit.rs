//! Maximum a posteriori estimation from several seeded starts.

use crate::coordinates::PriorConflict;
use crate::fit_options::FitOptions;
use crate::optimum::Optimum;
use crate::search::{Agreement, refine, refine_near, search_starts};
use crate::{Channels, Density, InferError, Likelihood, Target, Watch};
use nalgebra::DMatrix;
use std::f64::consts::{FRAC_PI_2, TAU};
use trundle_model::{Kind, Model, Posterior, Prior, Slot};

/// Estimate of one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Name as in [`trundle_model::Slot`].
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Posterior mode.
    pub mean: f64,
    /// Posterior standard deviation (Laplace).
    pub sd: f64,
    /// Whether the data determine the parameter and the prior does not conflict with them. Otherwise the mean
    /// has no meaning.
    pub identified: bool,
}

/// Result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model with all values filled in.
    pub model: Model,
    /// Values of all slots; for a per-episode parameter, the value of the first episode.
    pub values: Vec<f64>,
    /// The mode in the coordinates of the [`Target`].
    pub point: Vec<f64>,
    /// Gauss-Newton curvature of the −log likelihood alone at the mode, in the same coordinates: the
    /// information of the data relative to the prior, whose precision is one.
    pub information: DMatrix<f64>,
    /// Posterior covariance in the same coordinates (Laplace).
    pub spread: DMatrix<f64>,
    /// Slots of these coordinates.
    pub slots: Vec<Slot>,
    /// The free parameters.
    pub estimates: Vec<Estimate>,
    /// Parameters with a prior-data conflict. Their estimates are determined by the prior.
    pub prior_conflicts: Vec<PriorConflict>,
    /// Covariance of the free parameters, in their units.
    pub covariance: DMatrix<f64>,
    /// −log p(data | values).
    pub cost: f64,
    /// log p(data | model) by Laplace's approximation.
    pub log_evidence: f64,
    /// The stated or estimated noise.
    pub channels: Channels,
    /// Whether the search converged.
    pub converged: bool,
    /// Decrease of the cost in the last step.
    pub last_decrease: f64,
    /// Number of starts whose short search ended within one unit of log density of the best, and number of
    /// starts.
    pub agreement: (usize, usize),
}

impl Fit {
    /// The posterior for `model.toml`, restricted to the identified parameters.
    pub fn posterior(&self) -> Option<Posterior> {
        let kept: Vec<usize> = (0..self.estimates.len()).filter(|&k| self.estimates[k].identified).collect();
        (!kept.is_empty()).then(|| Posterior {
            names: kept.iter().map(|&k| self.estimates[k].name.clone()).collect(),
            mean: kept.iter().map(|&k| self.estimates[k].mean).collect(),
            covariance: kept
                .iter()
                .map(|&i| kept.iter().map(|&j| self.covariance[(i, j)]).collect())
                .collect(),
        })
    }

    /// The estimate of the slot `name`.
    pub fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.name == name)
    }
}

/// Number of points that are refined to convergence.
const MAX_REFINED_POINTS: usize = 2;

/// Fit the free parameters of `model` from `warm` starts (values of all slots) and random starts.
///
/// # Errors
/// When no start has a finite density, a name in [`FitOptions::per_episode`] is unknown, or the user
/// interrupts.
pub fn fit(
    likelihood: &dyn Likelihood,
    model: &Model,
    warm: &[Vec<f64>],
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Fit, InferError> {
    let target = Target::new(likelihood, model, &options.per_episode)?;
    if target.dimension() == 0 {
        let optimum =
            Optimum { point: vec![], at: target.linearise(&[])?, converged: true, last_decrease: 0.0 };
        return finish(&target, likelihood.channels(), optimum, (1, 1));
    }
    let (best, agreement) = match options.local_steps {
        Some(steps) => {
            let starts = warm.iter().map(|values| target.point(values)).collect();
            (refined_nearby(&target, starts, steps, watch)?, (1, warm.len()))
        }
        None => {
            let (points, agreement) =
                search_starts(&continuation_over(&target, likelihood, options)?, warm, options, watch)?;
            let canonicalised = |z: Vec<f64>| canonical(&target, &z).unwrap_or(z);
            let mut points: Vec<_> = points.into_iter().take(MAX_REFINED_POINTS).map(canonicalised).collect();
            points.extend(lowest_start(&target, warm, &points)?);
            (refined(&target, points, options, watch)?, agreement)
        }
    };
    fit_with_noise(likelihood, &target, (best, agreement), options, options.noise_rounds, watch)
}

/// The start with the lowest cost, if it lies below all of the `points`. Searches on a cheaper density can
/// increase the cost, for example near the time of an event.
fn lowest_start(
    target: &Target<'_>,
    starts: &[Vec<f64>],
    points: &[Vec<f64>],
) -> Result<Option<Vec<f64>>, InferError> {
    let ranked = |points: &mut dyn Iterator<Item = Vec<f64>>| -> Result<Vec<(f64, Vec<f64>)>, InferError> {
        points.map(|point| Ok((target.cost(&point)?, point))).collect()
    };
    let least = |a: &(f64, Vec<f64>), b: &(f64, Vec<f64>)| a.0.total_cmp(&b.0);
    let best = ranked(&mut starts.iter().map(|values| target.point(values)))?.into_iter().min_by(least);
    let found = ranked(&mut points.iter().cloned())?.into_iter().min_by(least);
    Ok(best.filter(|best| found.is_none_or(|found| best.0 < found.0)).map(|(_, point)| point))
}

/// Decrease of the cost, nats, below which the noise is not estimated again.
const MIN_NOISE_DECREASE_NATS: f64 = 0.1;

/// Estimates unstated noise and repeats the fit under it, for at most `rounds` rounds.
fn fit_with_noise(
    likelihood: &dyn Likelihood,
    target: &Target<'_>,
    (best, agreement): (Optimum, Agreement),
    options: &FitOptions,
    rounds: usize,
    watch: &dyn Watch,
) -> Result<Fit, InferError> {
    let model = target.model();
    let tuned = match rounds {
        0 => None,
        _ => likelihood.tuned(model, &target.shared_values(&best.point).0)?,
    };
    let Some(tuned) = tuned else { return finish(target, likelihood.channels(), best, agreement) };
    let retuned = target.with_likelihood(&*tuned, &options.per_episode)?;
    let before = best.at.cost;
    let best = match options.local_steps {
        Some(steps) => refined_nearby(&retuned, vec![best.point], steps, watch)?,
        None => refined(&retuned, vec![best.point], options, watch)?,
    };
    let rounds = if before - best.at.cost < MIN_NOISE_DECREASE_NATS { 0 } else { rounds - 1 };
    fit_with_noise(&*tuned, &retuned, (best, agreement), options, rounds, watch)
}

/// Refines the better of some nearby starts and brings it to canonical form.
fn refined_nearby(
    target: &Target<'_>,
    starts: Vec<Vec<f64>>,
    steps: usize,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let best = refine_near(target, starts, steps, watch)?;
    match canonical(target, &best.point) {
        Some(point) => Ok(Optimum { at: target.linearise(&point)?, point, ..best }),
        None => Ok(best),
    }
}

/// Refines some points, returns the best optimum and brings it to canonical form.
fn refined(
    target: &Target<'_>,
    points: Vec<Vec<f64>>,
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let best = refine(target, points, options, watch)?;
    match canonical(target, &best.point) {
        Some(turned) => refine(target, vec![turned], options, watch),
        None => Ok(best),
    }
}

/// Densities through which each start passes: cheaper ones over the same coordinates first, if available. The
/// last one ranks the starts.
pub(crate) fn continuation<'a>(
    likelihood: &'a dyn Likelihood,
    model: &'a Model,
    options: &FitOptions,
) -> Result<Vec<Target<'a>>, InferError> {
    continuation_over(&Target::new(likelihood, model, &options.per_episode)?, likelihood, options)
}

/// The same for an existing target of the likelihood.
fn continuation_over<'a>(
    full: &Target<'a>,
    likelihood: &'a dyn Likelihood,
    options: &FitOptions,
) -> Result<Vec<Target<'a>>, InferError> {
    // A thinned recording may omit an episode that has its own parameters.
    let fits = |cheaper: &Target<'_>| cheaper.dimension() == full.dimension();
    let cheaper = |l| full.with_likelihood(l, &options.per_episode).ok().filter(fits);
    let whole = || Ok(vec![full.with_likelihood(likelihood, &options.per_episode)?]);
    let Some(coarse) = likelihood.coarse() else { return whole() };
    let Some(ranking) = cheaper(coarse) else { return whole() };
    let distant = if options.distant_starts { coarse.coarse().and_then(cheaper) } else { None };
    Ok(distant.into_iter().chain([ranking]).collect())
}

fn finish(
    target: &Target<'_>,
    channels: Channels,
    mut optimum: Optimum,
    agreement: Agreement,
) -> Result<Fit, InferError> {
    // A search can go round the circle of an angle that the data do not determine.
    for (k, z) in optimum.point.iter_mut().enumerate() {
        *z = on_circle(&target.slot(k).prior, *z);
    }
    let (n, z) = (optimum.point.len(), &optimum.point);
    let (spread, log_determinant) = invert(&precision(&optimum.at.curvature, target));
    let information = &optimum.at.curvature - target.prior(z).curvature;
    let scales: Vec<(f64, f64)> = (0..n).map(|k| target.value(k, z[k])).collect();
    let conflict = |k: usize| {
        let conflict = target.coordinates().prior_conflict(target.parameter(k), z[k], information[(k, k)])?;
        Some(PriorConflict { name: target.slot(k).name, ..conflict })
    };
    let estimate = |k: usize| {
        let (slot, sd) = (target.slot(k), spread[(k, k)].max(0.0).sqrt());
        Estimate {
            name: slot.name,
            unit: slot.unit,
            mean: scales[k].0,
            sd: sd * scales[k].1.abs(),
            identified: target.coordinates().identified(target.parameter(k), sd) && conflict(k).is_none(),
        }
    };
    let values = target.shared_values(z).0[..target.model().slots().len()].to_vec();
    Ok(Fit {
        model: target.model().with_values(&values)?,
        estimates: (0..n).map(estimate).collect(),
        prior_conflicts: (0..n).filter_map(conflict).collect(),
        slots: (0..n).map(|k| target.slot(k)).collect(),
        values,
        covariance: DMatrix::from_fn(n, n, |i, j| spread[(i, j)] * scales[i].1 * scales[j].1),
        cost: optimum.at.cost - target.prior_cost(z),
        log_evidence: -optimum.at.cost + 0.5 * (n as f64 * TAU.ln() - log_determinant),
        channels,
        converged: optimum.converged,
        last_decrease: optimum.last_decrease,
        agreement,
        information,
        spread,
        point: optimum.point,
    })
}

/// Posterior precision in `z`, at least that of the prior or of the circle of an angle.
fn precision(curvature: &DMatrix<f64>, target: &Target<'_>) -> DMatrix<f64> {
    let mut precision = curvature.clone();
    for k in 0..precision.nrows() {
        let (coordinates, parameter) = (target.coordinates(), target.parameter(k));
        let missing = coordinates.min_precision(parameter) - coordinates.prior_precision(parameter);
        precision[(k, k)] += missing.max(0.0);
    }
    precision
}

/// Inverse and log determinant of a positive definite matrix.
fn invert(precision: &DMatrix<f64>) -> (DMatrix<f64>, f64) {
    match precision.clone().cholesky() {
        Some(factor) => {
            let log_determinant = 2.0 * factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
            (factor.inverse(), log_determinant)
        }
        None => (DMatrix::identity(precision.nrows(), precision.nrows()) * 1e6, 0.0),
    }
}

/// An angle wrapped to the period around zero; any other value unchanged.
pub(crate) fn on_circle(prior: &Prior, value: f64) -> f64 {
    match prior {
        Prior::Angle(period) => value - period * (value / period - 0.5).ceil(),
        _ => value,
    }
}

/// Canonical form of a point, or `None` if it already has it. A wheel turned by a quarter with exchanged
/// coefficients is the same wheel: "along" is the direction of lower friction. Angles are wrapped around
/// zero.
pub(crate) fn canonical(target: &Target<'_>, point: &[f64]) -> Option<Vec<f64>> {
    if target.has_per_episode() {
        return None;
    }
    let mut values = target.shared_values(point).0;
    let before = values.clone();
    let (slots, mut first) = (target.coordinates().slots(), 1);
    for effect in &target.model().effects {
        let [angle, along, across] = [2, 3, 4].map(|k| first + k);
        first += effect.values.len();
        let free = |s: usize| slots[s].value.is_none();
        // A quarter turn leaves the density unchanged only if the prior is symmetric too.
        let turns = effect.kind == Kind::ViscousWheel
            && free(angle)
            && free(along)
            && free(across)
            && matches!(slots[angle].prior, Prior::Angle(_))
            && slots[along].prior == slots[across].prior;
        if turns && values[along] > values[across] {
            values.swap(along, across);
            values[angle] += FRAC_PI_2;
        }
    }
    for &slot in target.coordinates().free() {
        values[slot] = on_circle(&slots[slot].prior, values[slot]);
    }
    (values != before).then(|| target.point(&values))
}

/// Values for the slots of a richer model, taken by name from the fit of a simpler one; `fill` supplies the
/// remaining ones.
pub fn transferred_values(from: &Fit, to: &Model, fill: &[f64]) -> Vec<f64> {
    let known: std::collections::BTreeMap<String, f64> =
        from.model.slots().into_iter().filter_map(|s| s.value.map(|v| (s.name, v))).collect();
    to.slots()
        .iter()
        .zip(fill)
        .map(|(slot, &fill)| slot.value.unwrap_or_else(|| known.get(&slot.name).copied().unwrap_or(fill)))
        .collect()
}
