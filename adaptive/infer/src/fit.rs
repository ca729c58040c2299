//! Maximum a posteriori estimate, from several seeded starts.

use crate::coordinates::within_reach;
use crate::levenberg::{self, Optimum, Stop};
use crate::{Channels, Coordinates, InferError, Likelihood, Linearised, Watch};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, TAU};
use trundle_model::{Kind, Model, Posterior, Prior};

/// How a fit is searched.
#[derive(Clone, Debug)]
pub struct FitOptions {
    /// Random starts, beside those given.
    pub starts: usize,
    /// Seed of the random starts.
    pub seed: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { starts: 6, seed: 0 }
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
    /// Whether the data hold it; if not, the number means nothing.
    pub identified: bool,
}

/// What a fit found.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model with every value filled in.
    pub model: Model,
    /// Values of all slots.
    pub values: Vec<f64>,
    /// The free parameters.
    pub estimates: Vec<Estimate>,
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
    /// How many of how many starts came within one unit of log density of the best.
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

/// Short searches sort the starts; the best are followed to the end.
const SCOUT: Stop = Stop { iterations: 14, decrease: 0.05 };
const POLISH: Stop = Stop { iterations: 60, decrease: 1e-5 };
const POLISHED: usize = 2;

/// Fit the free parameters of `model`, from `warm` starts (values of all slots) and random ones.
///
/// # Errors
/// When no start has a finite density, or the user interrupts.
pub fn fit(
    likelihood: &dyn Likelihood,
    model: &Model,
    warm: &[Vec<f64>],
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Fit, InferError> {
    let coordinates = Coordinates::new(model);
    if coordinates.free().is_empty() {
        let search = Search { likelihood, model, coordinates: &coordinates, watch };
        let at = search.linearise(&[])?;
        return finish(&search, Optimum { point: vec![], at, converged: true }, (1, 1));
    }
    let cheap = likelihood.coarse().unwrap_or(likelihood);
    let mut found = scout(cheap, model, &coordinates, warm, options, watch)?;
    found.truncate(POLISHED);
    let starts = warm.len() + options.starts;
    let first = polish(likelihood, model, &coordinates, found, watch, starts)?;
    // Where the noise is not stated it is estimated, and the fit repeated under it.
    match likelihood.tuned(model, &first.values)? {
        None => Ok(first),
        Some(tuned) => {
            let points = vec![coordinates.point(&first.values)];
            let second = polish(&*tuned, model, &coordinates, points, watch, starts)?;
            let tuned = tuned.tuned(model, &second.values)?;
            let points = vec![coordinates.point(&second.values)];
            match &tuned {
                Some(tuned) => polish(&**tuned, model, &coordinates, points, watch, starts),
                None => Ok(second),
            }
        }
    }
}

struct Search<'a> {
    likelihood: &'a dyn Likelihood,
    model: &'a Model,
    coordinates: &'a Coordinates,
    watch: &'a dyn Watch,
}

impl Search<'_> {
    fn cost(&self, z: &[f64]) -> Result<f64, InferError> {
        let cost = self.likelihood.cost(self.model, &self.coordinates.values(z).0)?;
        let cost = cost + self.coordinates.prior_cost(z);
        Ok(if cost.is_nan() { f64::INFINITY } else { cost })
    }

    fn linearise(&self, z: &[f64]) -> Result<Linearised, InferError> {
        let (values, slopes) = self.coordinates.values(z);
        let mut at = self.likelihood.linearise(self.model, &values, self.coordinates.free())?;
        at.cost += self.coordinates.prior_cost(z);
        for i in 0..z.len() {
            at.gradient[i] *= slopes[i];
            for j in 0..z.len() {
                at.curvature[(i, j)] *= slopes[i] * slopes[j];
            }
            let precision = self.coordinates.prior_precision(i);
            at.gradient[i] += precision * z[i];
            at.curvature[(i, i)] += precision;
        }
        Ok(at)
    }

    fn from(&self, start: Vec<f64>, stop: Stop) -> Result<Optimum, InferError> {
        levenberg::minimise(
            start,
            |z| self.linearise(z),
            |z| self.cost(z),
            |k, z| within_reach(z, self.coordinates.slot(k)),
            stop,
            self.watch,
        )
    }
}

/// Points found by short searches, best first.
fn scout(
    likelihood: &dyn Likelihood,
    model: &Model,
    coordinates: &Coordinates,
    warm: &[Vec<f64>],
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Vec<Vec<f64>>, InferError> {
    let search = Search { likelihood, model, coordinates, watch };
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let given = warm.iter().map(|values| coordinates.point(values));
    let drawn = (0..options.starts).map(|_| coordinates.draw(&mut rng));
    let starts: Vec<_> = given.chain(drawn).collect();
    let count = starts.len();
    let mut found = Vec::with_capacity(count);
    for (k, start) in starts.into_iter().enumerate() {
        watch.progress("fit", k as f64 / count as f64);
        if search.cost(&start)?.is_finite() {
            let optimum = search.from(start, SCOUT)?;
            found.push((optimum.at.cost, optimum.point));
        }
    }
    if found.is_empty() {
        return Err(InferError::NoStart { recording: "the recording".to_owned(), starts: count });
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(found.into_iter().map(|(_, point)| point).collect())
}

fn polish(
    likelihood: &dyn Likelihood,
    model: &Model,
    coordinates: &Coordinates,
    points: Vec<Vec<f64>>,
    watch: &dyn Watch,
    starts: usize,
) -> Result<Fit, InferError> {
    let search = Search { likelihood, model, coordinates, watch };
    let mut best: Option<Optimum> = None;
    let mut costs = Vec::with_capacity(points.len());
    for point in points {
        let optimum = search.from(point, POLISH)?;
        costs.push(optimum.at.cost);
        if best.as_ref().is_none_or(|b| optimum.at.cost < b.at.cost) {
            best = Some(optimum);
        }
    }
    let Some(best) = best else {
        return Err(InferError::NoStart { recording: "the recording".to_owned(), starts });
    };
    let agree = costs.iter().filter(|&&c| c < best.at.cost + 1.0).count();
    finish(&search, best, (agree, costs.len()))
}

fn finish(search: &Search<'_>, optimum: Optimum, agreement: (usize, usize)) -> Result<Fit, InferError> {
    let Search { likelihood, model, coordinates, .. } = search;
    let n = optimum.point.len();
    let (mut values, slopes) = coordinates.values(&optimum.point);
    let precision = precision(&optimum.at.curvature, coordinates);
    let (spread, log_determinant) = invert(&precision);
    let log_evidence = -optimum.at.cost + 0.5 * (n as f64 * TAU.ln() - log_determinant);
    let mut covariance = DMatrix::from_fn(n, n, |i, j| spread[(i, j)] * slopes[i] * slopes[j]);
    canonical(model, coordinates, &mut values, &mut covariance);
    let estimates = (0..n).map(|k| {
        let slot = coordinates.slot(k);
        Estimate {
            name: slot.name.clone(),
            unit: slot.unit,
            mean: values[coordinates.free()[k]],
            sd: covariance[(k, k)].max(0.0).sqrt(),
            identified: coordinates.identified(k, spread[(k, k)].max(0.0).sqrt()),
        }
    });
    let prior = coordinates.prior_cost(&optimum.point);
    Ok(Fit {
        model: model.filled(&values)?,
        estimates: estimates.collect(),
        values,
        covariance,
        cost: optimum.at.cost - prior,
        log_evidence,
        channels: likelihood.channels(),
        converged: optimum.converged,
        agreement,
    })
}

/// Posterior precision in `z`, no flatter than a circle or a prior allows.
fn precision(curvature: &DMatrix<f64>, coordinates: &Coordinates) -> DMatrix<f64> {
    let mut precision = curvature.clone();
    for k in 0..precision.nrows() {
        let missing = coordinates.least_precision(k) - coordinates.prior_precision(k);
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

/// A wheel turned by a quarter with its coefficients swapped is the same wheel: name the direction
/// of least friction "along". Angles are taken from the middle of their circle.
fn canonical(model: &Model, coordinates: &Coordinates, values: &mut [f64], covariance: &mut DMatrix<f64>) {
    let mut slot = 1;
    for effect in &model.effects {
        let (angle, along, across) = (slot + 2, slot + 3, slot + 4);
        slot += effect.values.len();
        let place = |s: usize| coordinates.free().iter().position(|&f| f == s);
        let (Kind::ViscousWheel, Some(_), Some(i), Some(j)) =
            (effect.kind, place(angle), place(along), place(across))
        else {
            continue;
        };
        if values[along] > values[across] {
            values.swap(along, across);
            values[angle] += FRAC_PI_2;
            covariance.swap_rows(i, j);
            covariance.swap_columns(i, j);
        }
    }
    for &slot in coordinates.free() {
        if let Prior::Angle(period) = coordinates.slots()[slot].prior {
            values[slot] -= period * (values[slot] / period - 0.5).ceil();
        }
    }
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
