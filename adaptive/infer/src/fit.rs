//! Maximum a posteriori estimate, from several seeded starts.

use crate::coordinates::Strain;
use crate::search::{Agreement, Optimum, follow, polish, scout};
use crate::{Channels, Density, InferError, Likelihood, Target, Watch};
use nalgebra::DMatrix;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, TAU};
use trundle_model::{Kind, Model, Posterior, Prior, Slot};

/// How a fit is searched.
#[derive(Clone, Debug)]
pub struct FitOptions {
    /// Random starts, beside those given.
    pub starts: usize,
    /// Seed of the random starts.
    pub seed: u64,
    /// How each start is followed.
    pub optimiser: Optimiser,
    /// Whether starts may lie far from the optimum; not where they come from the fit of a simpler model.
    pub from_afar: bool,
    /// Where given starts lie near their optima: how many steps the best of them is followed at most.
    pub near: Option<usize>,
    /// How often noise that the recording does not state is estimated at most, each time with a search under it.
    pub noise_rounds: usize,
    /// Whether the last search measures the gradient by differences where the given one leads no further down.
    /// It has no effect with [`FitOptions::near`].
    pub measure_gradient: bool,
    /// Names of parameters that each episode has its own of.
    pub per_episode: BTreeSet<String>,
}

/// Methods on exact gradients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Optimiser {
    /// Levenberg–Marquardt on the Gauss-Newton curvature.
    #[default]
    LevenbergMarquardt,
    /// L-BFGS within bounds, as in the paper; on the gradient alone.
    Lbfgs,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            starts: 6,
            seed: 0,
            optimiser: Optimiser::default(),
            from_afar: true,
            near: None,
            noise_rounds: 2,
            measure_gradient: false,
            per_episode: BTreeSet::new(),
        }
    }
}

/// One parameter as the data hold it.
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
    /// Whether the data hold it, and the prior does not exclude them; if not, the number means nothing.
    pub identified: bool,
}

/// What a fit found.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model with every value filled in.
    pub model: Model,
    /// Values of all slots; of a parameter that is per episode, the first episode's.
    pub values: Vec<f64>,
    /// The mode in the coordinates of the [`Target`].
    pub point: Vec<f64>,
    /// Gauss-Newton curvature there of the likelihood alone: how often more than the prior (one) the data know.
    pub information: DMatrix<f64>,
    /// Posterior covariance in the same coordinates (Laplace).
    pub spread: DMatrix<f64>,
    /// What each of those coordinates is.
    pub slots: Vec<Slot>,
    /// The free parameters.
    pub estimates: Vec<Estimate>,
    /// Those whose prior excludes the data; their numbers are the prior's, not the data's.
    pub strained: Vec<Strain>,
    /// Covariance of the free parameters, in their units.
    pub covariance: DMatrix<f64>,
    /// −log p(data | values).
    pub cost: f64,
    /// log p(data | model), Laplace's approximation.
    pub log_evidence: f64,
    /// The noise that was stated, or found.
    pub channels: Channels,
    /// Whether the search came to rest.
    pub converged: bool,
    /// By how much its last step lowered the cost.
    pub falling: f64,
    /// How many of how many starts came within one unit of log density of the best, as far as short searches go.
    pub agreement: (usize, usize),
}

impl Fit {
    /// The posterior for `model.toml`: what the data do not hold is left out.
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

    /// The estimate of a slot, by name.
    pub fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.name == name)
    }
}

/// Points followed to the end.
const POLISHED: usize = 2;

/// Fit the free parameters of `model`, from `warm` starts (values of all slots) and random ones.
///
/// # Errors
/// When no start has a finite density, a name in [`FitOptions::per_episode`] is unknown, or the user interrupts.
pub fn fit(
    likelihood: &dyn Likelihood,
    model: &Model,
    warm: &[Vec<f64>],
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Fit, InferError> {
    let target = Target::new(likelihood, model, &options.per_episode)?;
    if target.dimension() == 0 {
        let optimum = Optimum { point: vec![], at: target.linearise(&[])?, converged: true, falling: 0.0 };
        return finish(&target, likelihood.channels(), optimum, (1, 1));
    }
    let (best, agreement) = match options.near {
        Some(steps) => {
            let starts = warm.iter().map(|values| target.point(values)).collect();
            (followed(&target, starts, steps, watch)?, (1, warm.len()))
        }
        None => {
            let (points, agreement) = scout(&rungs(&target, likelihood, options)?, warm, options, watch)?;
            let named = |z: Vec<f64>| canonical(&target, &z).unwrap_or(z);
            let mut points: Vec<_> = points.into_iter().take(POLISHED).map(named).collect();
            points.extend(lower(&target, warm, &points)?);
            (settled(&target, points, options, watch)?, agreement)
        }
    };
    under_tuned(likelihood, &target, (best, agreement), options, options.noise_rounds, watch)
}

/// The lowest of some starts, if it lies below all the points to which cheaper densities led: these may lead uphill, as
/// away from the moment of an event.
fn lower(
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

/// Decrease of the cost, nats, below which estimating the noise once more is not worth it.
const NOISE_SETTLED: f64 = 0.1;

/// Where the noise is not stated it is estimated, and the fit repeated under it, in at most so many rounds.
fn under_tuned(
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
    let again = target.over(&*tuned, &options.per_episode)?;
    let before = best.at.cost;
    let best = match options.near {
        Some(steps) => followed(&again, vec![best.point], steps, watch)?,
        None => settled(&again, vec![best.point], options, watch)?,
    };
    let rounds = if before - best.at.cost < NOISE_SETTLED { 0 } else { rounds - 1 };
    under_tuned(&*tuned, &again, (best, agreement), options, rounds, watch)
}

/// Where the better of some near starts leads, by its usual name.
fn followed(
    target: &Target<'_>,
    starts: Vec<Vec<f64>>,
    steps: usize,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let best = follow(target, starts, steps, watch)?;
    match canonical(target, &best.point) {
        Some(point) => Ok(Optimum { at: target.linearise(&point)?, point, ..best }),
        None => Ok(best),
    }
}

/// The best optimum from some points, by its usual name.
fn settled(
    target: &Target<'_>,
    points: Vec<Vec<f64>>,
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Optimum, InferError> {
    let best = polish(target, points, options, watch)?;
    match canonical(target, &best.point) {
        Some(turned) => polish(target, vec![turned], options, watch),
        None => Ok(best),
    }
}

/// The densities that a start is led through, the one that sorts the starts last: cheaper ones over the same
/// coordinates where there are such.
pub(crate) fn ladder<'a>(
    likelihood: &'a dyn Likelihood,
    model: &'a Model,
    options: &FitOptions,
) -> Result<Vec<Target<'a>>, InferError> {
    rungs(&Target::new(likelihood, model, &options.per_episode)?, likelihood, options)
}

/// The same for a target, which is that of the likelihood.
fn rungs<'a>(
    full: &Target<'a>,
    likelihood: &'a dyn Likelihood,
    options: &FitOptions,
) -> Result<Vec<Target<'a>>, InferError> {
    // Thinned recordings may lack an episode whose own parameters are asked for.
    let fits = |cheaper: &Target<'_>| cheaper.dimension() == full.dimension();
    let cheaper = |l| full.over(l, &options.per_episode).ok().filter(fits);
    let whole = || Ok(vec![full.over(likelihood, &options.per_episode)?]);
    let Some(coarse) = likelihood.coarse() else { return whole() };
    let Some(sorting) = cheaper(coarse) else { return whole() };
    let afar = if options.from_afar { coarse.coarse().and_then(cheaper) } else { None };
    Ok(afar.into_iter().chain([sorting]).collect())
}

fn finish(
    target: &Target<'_>,
    channels: Channels,
    mut optimum: Optimum,
    agreement: Agreement,
) -> Result<Fit, InferError> {
    // Where the data do not hold an angle the search may go round and round.
    for (k, z) in optimum.point.iter_mut().enumerate() {
        *z = on_circle(&target.slot(k).prior, *z);
    }
    let (n, z) = (optimum.point.len(), &optimum.point);
    let (spread, log_determinant) = invert(&precision(&optimum.at.curvature, target));
    let information = &optimum.at.curvature - target.prior(z).curvature;
    let scales: Vec<(f64, f64)> = (0..n).map(|k| target.value(k, z[k])).collect();
    let strain = |k: usize| {
        let strain = target.coordinates().strain(target.parameter(k), z[k], information[(k, k)])?;
        Some(Strain { name: target.slot(k).name, ..strain })
    };
    let estimate = |k: usize| {
        let (slot, sd) = (target.slot(k), spread[(k, k)].max(0.0).sqrt());
        Estimate {
            name: slot.name,
            unit: slot.unit,
            mean: scales[k].0,
            sd: sd * scales[k].1.abs(),
            identified: target.coordinates().identified(target.parameter(k), sd) && strain(k).is_none(),
        }
    };
    let values = target.shared_values(z).0[..target.model().slots().len()].to_vec();
    Ok(Fit {
        model: target.model().with_values(&values)?,
        estimates: (0..n).map(estimate).collect(),
        strained: (0..n).filter_map(strain).collect(),
        slots: (0..n).map(|k| target.slot(k)).collect(),
        values,
        covariance: DMatrix::from_fn(n, n, |i, j| spread[(i, j)] * scales[i].1 * scales[j].1),
        cost: optimum.at.cost - target.prior_cost(z),
        log_evidence: -optimum.at.cost + 0.5 * (n as f64 * TAU.ln() - log_determinant),
        channels,
        converged: optimum.converged,
        falling: optimum.falling,
        agreement,
        information,
        spread,
        point: optimum.point,
    })
}

/// Posterior precision in `z`, no flatter than a circle or a prior allows.
fn precision(curvature: &DMatrix<f64>, target: &Target<'_>) -> DMatrix<f64> {
    let mut precision = curvature.clone();
    for k in 0..precision.nrows() {
        let (coordinates, parameter) = (target.coordinates(), target.parameter(k));
        let missing = coordinates.least_precision(parameter) - coordinates.prior_precision(parameter);
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

/// An angle, which is its own coordinate, taken from the middle of its circle; anything else as it is.
pub(crate) fn on_circle(prior: &Prior, value: f64) -> f64 {
    match prior {
        Prior::Angle(period) => value - period * (value / period - 0.5).ceil(),
        _ => value,
    }
}

/// A wheel turned by a quarter with its coefficients swapped is the same wheel: name the direction of least
/// friction "along". Angles are taken from the middle of their circle. `None` where all is well.
pub(crate) fn canonical(target: &Target<'_>, point: &[f64]) -> Option<Vec<f64>> {
    if target.has_own() {
        return None;
    }
    let mut values = target.shared_values(point).0;
    let before = values.clone();
    let (slots, mut first) = (target.coordinates().slots(), 1);
    for effect in &target.model().effects {
        let [angle, along, across] = [2, 3, 4].map(|k| first + k);
        first += effect.values.len();
        let free = |s: usize| slots[s].value.is_none();
        // Only a prior that is itself the same after a quarter turn leaves the density as it was.
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

/// Values of a richer model's slots, taken by name from a fit of a simpler one; the rest from `fill`.
pub fn carried(from: &Fit, to: &Model, fill: &[f64]) -> Vec<f64> {
    let known: std::collections::BTreeMap<String, f64> =
        from.model.slots().into_iter().filter_map(|s| s.value.map(|v| (s.name, v))).collect();
    to.slots()
        .iter()
        .zip(fill)
        .map(|(slot, &fill)| slot.value.unwrap_or_else(|| known.get(&slot.name).copied().unwrap_or(fill)))
        .collect()
}
