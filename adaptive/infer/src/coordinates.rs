//! Coordinates of the search: each parameter is standard normal under its prior.
//!
//! | prior | value |
//! | --- | --- |
//! | normal | `mean + sd·T(z)` |
//! | log-normal | `median·exp(sd·T(z))` |
//! | uniform, on the body | `lower + (upper − lower)·Φ(z)` |
//! | angle | `z` itself; uniform on its circle, so without a prior |
//!
//! `T(z)` is `z` where the slot's bounds are more than [`MAX_PRIOR_SD`] away. Otherwise it maps the normal
//! distribution onto the truncated one, so that every value is within bounds. All coordinates are unbounded
//! and of order one, and the prior contributes `z²/2` to the cost. The coordinates of a place on the body
//! have an additional footprint prior ([`FootprintPrior`]).

use crate::footprint_prior::{FootprintPenalty, FootprintPrior};
use crate::truncated_normal::{TruncatedNormal, cdf, pdf, quantile};
use rand::RngExt;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;
use trundle_model::{Model, Prior, Slot};

/// Largest distance from the prior centre that is searched, in prior standard deviations.
const MAX_PRIOR_SD: f64 = 8.0;

/// Distance from the prior centre, in prior standard deviations, that counts as a prior-data conflict: one
/// draw in 16 000. The same number, in standard deviations of the likelihood, is the shift beyond the end of
/// a prior that counts as a conflict.
const CONFLICT_SD: f64 = 4.0;

/// Distance from the prior centre, in prior standard deviations, within which an estimate is not at the end
/// of its prior.
const BOUNDARY_SD: f64 = 2.0;

/// Tail probability assigned to a value at or beyond an end of a uniform prior.
const BOUND_PROBABILITY: f64 = 1e-9;

/// Maximum number of draws until all places lie under the footprint.
const MAX_REDRAWS: usize = 100;

/// The free parameters of a model as points `z`.
#[derive(Clone, Debug)]
pub struct Coordinates {
    slots: Vec<Slot>,
    free: Vec<usize>,
    footprint_priors: Vec<FootprintPrior>,
}

/// A prior-data conflict: the prior practically excludes the value that the data require.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorConflict {
    /// Name as in [`Slot::name`].
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// The estimate.
    pub value: f64,
    /// Coordinate of the estimate: its distance from the prior centre in standard deviations, or for a
    /// bounded distribution the normal quantile of its tail probability.
    pub z: f64,
    /// Values that the prior allows within four standard deviations.
    pub range: [f64; 2],
}

impl std::fmt::Display for PriorConflict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, unit, range: [low, high], .. } = self;
        let side = if self.z > 0.0 { "above" } else { "below" };
        let (low, high, value) = (rounded(*low), rounded(*high), rounded(self.value));
        write!(
            f,
            "the prior excludes the data: they pull {name} {side} its prior range [{low}, {high}] {unit}, and the \
             estimate stays at {value}; widen its prior, or check whether the model misses an effect"
        )
    }
}

/// A number rounded to four significant digits.
fn rounded(x: f64) -> f64 {
    let unit = 10f64.powf(3.0 - x.abs().log10().floor());
    if x == 0.0 || !unit.is_finite() { x } else { (x * unit).round() / unit }
}

impl Coordinates {
    /// Coordinates of the free parameters of a model, with places on the body restricted to its footprint.
    pub fn new(model: &Model) -> Self {
        Self::of(model.slots()).with_footprint(model)
    }

    /// Coordinates of the free slots among `slots`.
    pub fn of(slots: Vec<Slot>) -> Self {
        let free = (0..slots.len()).filter(|&k| slots[k].value.is_none()).collect();
        Self { slots, free, footprint_priors: vec![] }
    }

    /// The same with places restricted to the model's footprint. The model's slots must come first.
    #[must_use]
    pub fn with_footprint(mut self, model: &Model) -> Self {
        let value =
            |k: usize, z: f64| self.slots[k].value.unwrap_or_else(|| from_normal(&self.slots[k], z).0);
        self.footprint_priors = FootprintPrior::all(model, &value);
        self
    }

    /// Footprint priors of the places.
    pub fn footprint_priors(&self) -> &[FootprintPrior] {
        &self.footprint_priors
    }

    /// Free parameters that are the coordinates of a place; `None` for a fixed one.
    pub fn coordinates_of(&self, footprint_prior: &FootprintPrior) -> [Option<usize>; 2] {
        footprint_prior.slots.map(|slot| self.free.iter().position(|&k| k == slot))
    }

    /// Footprint penalty at the coordinates `z` of a place (a fixed coordinate is ignored), with derivatives
    /// by `z`. It adds `cost` to the cost, `residual·slopes` to the gradient and `slopes·slopesᵀ` to the
    /// curvature.
    pub fn footprint_penalty(&self, footprint_prior: &FootprintPrior, z: [f64; 2]) -> FootprintPenalty {
        let at = [0, 1].map(|k| {
            let slot = &self.slots[footprint_prior.slots[k]];
            slot.value.map_or_else(|| from_normal(slot, z[k]), |value| (value, 0.0))
        });
        let penalty = footprint_prior.penalty(at.map(|(value, _)| value));
        FootprintPenalty { slopes: [penalty.slopes[0] * at[0].1, penalty.slopes[1] * at[1].1], ..penalty }
    }

    /// Prior-data conflict of the free parameter `k` at its posterior mode `z`, if there is one.
    /// `information` is the curvature of the −log likelihood by that coordinate.
    ///
    /// There is a conflict if `z` is more than four prior standard deviations from the centre. There is also
    /// one if `z` is at an end of the prior (more than two) and the likelihood pulls beyond it by more than
    /// four of its own standard deviations. At a mode the gradient of the likelihood is `−z`, so the
    /// condition is `|z|/√information > 4`: a likelihood e⁸ times higher. Angles have no prior.
    pub fn prior_conflict(&self, k: usize, z: f64, information: f64) -> Option<PriorConflict> {
        let slot = self.slot(k);
        let beyond = z.abs() > BOUNDARY_SD && z * z > CONFLICT_SD * CONFLICT_SD * information.max(0.0);
        if matches!(slot.prior, Prior::Angle(_)) || !(z.abs() > CONFLICT_SD || beyond) {
            return None;
        }
        let value = |z| from_normal(slot, z).0;
        let (name, unit) = (slot.name.clone(), slot.unit);
        Some(PriorConflict {
            name,
            unit,
            value: value(z),
            z,
            range: [value(-CONFLICT_SD), value(CONFLICT_SD)],
        })
    }

    /// Indices of the free slots among [`Model::slots`].
    pub fn free(&self) -> &[usize] {
        &self.free
    }

    /// All slots of the model.
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// Slot of the free parameter `k`.
    pub fn slot(&self, k: usize) -> &Slot {
        &self.slots[self.free[k]]
    }

    /// Values of all slots at `z`, and the derivative of each free value by its coordinate.
    pub fn values(&self, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut values: Vec<f64> = self.slots.iter().map(|s| s.value.unwrap_or(0.0)).collect();
        let mut slopes = Vec::with_capacity(z.len());
        for (&k, &z) in self.free.iter().zip(z) {
            let (value, slope) = from_normal(&self.slots[k], z);
            values[k] = value;
            slopes.push(slope);
        }
        (values, slopes)
    }

    /// Point `z` of given values of all slots.
    pub fn point(&self, values: &[f64]) -> Vec<f64> {
        self.free.iter().map(|&k| to_normal(&self.slots[k], values[k])).collect()
    }

    /// A draw from the prior, with places under the footprint.
    pub fn draw(&self, rng: &mut impl RngExt) -> Vec<f64> {
        let mut z = self.draw_independent(rng);
        // If all redraws fail, the last draw is used.
        for _ in 0..MAX_REDRAWS {
            if self
                .footprint_priors
                .iter()
                .all(|footprint_prior| self.penalty_at(footprint_prior, &z).residual <= 0.0)
            {
                break;
            }
            z = self.draw_independent(rng);
        }
        z
    }

    fn draw_independent(&self, rng: &mut impl RngExt) -> Vec<f64> {
        let one = |&k: &usize| match self.slots[k].prior {
            Prior::Angle(period) => period * (rng.random::<f64>() - 0.5),
            _ => rng.sample::<f64, _>(StandardNormal),
        };
        self.free.iter().map(one).collect()
    }

    fn penalty_at(&self, footprint_prior: &FootprintPrior, z: &[f64]) -> FootprintPenalty {
        let [x, y] = self.coordinates_of(footprint_prior).map(|k| k.map_or(0.0, |k| z[k]));
        self.footprint_penalty(footprint_prior, [x, y])
    }

    /// −log prior density at `z`.
    pub fn prior_cost(&self, z: &[f64]) -> f64 {
        let independent: f64 = z.iter().enumerate().map(|(k, &z)| self.prior_cost_of(k, z)).sum();
        independent
            + self
                .footprint_priors
                .iter()
                .map(|footprint_prior| self.penalty_at(footprint_prior, z).cost)
                .sum::<f64>()
    }

    /// Contribution of the free parameter `k` to [`Coordinates::prior_cost`], without footprint priors.
    pub fn prior_cost_of(&self, k: usize, z: f64) -> f64 {
        match self.slot(k).prior {
            Prior::Angle(period) => period.ln(),
            _ => 0.5 * (z * z + TAU.ln()),
        }
    }

    /// Prior precision of the free parameter `k`.
    pub fn prior_precision(&self, k: usize) -> f64 {
        if matches!(self.slot(k).prior, Prior::Angle(_)) { 0.0 } else { 1.0 }
    }

    /// Minimum posterior precision of the free parameter `k`. For an angle, a Laplace integral with this
    /// precision gives the period.
    pub fn min_precision(&self, k: usize) -> f64 {
        match self.slot(k).prior {
            Prior::Angle(period) => TAU / (period * period),
            _ => 1.0,
        }
    }

    /// Whether a posterior standard deviation of `sd` in `z` counts as identified: less than [`IDENTIFIED_SD`] of the
    /// prior or rad, for a log-normal parameter also within a factor of e^½.
    pub fn identified(&self, k: usize, sd: f64) -> bool {
        match self.slot(k).prior {
            Prior::LogNormal { sd: spread, .. } => sd < IDENTIFIED_SD && sd * spread < 0.5,
            _ => sd < IDENTIFIED_SD,
        }
    }
}

/// Largest posterior standard deviation of an identified parameter, as a share of the prior's or in rad.
pub const IDENTIFIED_SD: f64 = 0.3;

/// Limits a coordinate to the searched range.
pub(crate) fn clamp_to_prior(z: f64, slot: &Slot) -> f64 {
    if matches!(slot.prior, Prior::Angle(_)) { z } else { z.clamp(-MAX_PRIOR_SD, MAX_PRIOR_SD) }
}

/// Truncation at a slot's bounds in prior standard deviations; `None` if they are outside the searched range.
fn truncation(low: f64, high: f64) -> Option<TruncatedNormal> {
    (low > -MAX_PRIOR_SD || high < MAX_PRIOR_SD).then_some(TruncatedNormal { low, high })
}

fn normal(mean: f64, sd: f64, slot: &Slot) -> Option<TruncatedNormal> {
    truncation((slot.lower - mean) / sd, (slot.upper - mean) / sd)
}

fn log_normal(median: f64, sd: f64, slot: &Slot) -> Option<TruncatedNormal> {
    truncation((slot.lower.max(0.0) / median).ln() / sd, (slot.upper / median).ln() / sd)
}

fn from_normal(slot: &Slot, z: f64) -> (f64, f64) {
    let within =
        |truncated: Option<TruncatedNormal>| truncated.map_or((z, 1.0), |truncated| truncated.value(z));
    match slot.prior {
        Prior::Normal { mean, sd } => {
            let (t, slope) = within(normal(mean, sd, slot));
            (mean + sd * t, sd * slope)
        }
        Prior::LogNormal { median, sd } => {
            let (t, slope) = within(log_normal(median, sd, slot));
            let value = median * (sd * t).exp();
            (value, sd * value * slope)
        }
        Prior::Uniform | Prior::OnBody(_) => {
            let extent = slot.upper - slot.lower;
            // Computed from the nearer end to keep all digits.
            let value = if z < 0.0 { slot.lower + extent * cdf(z) } else { slot.upper - extent * cdf(-z) };
            (value, extent * pdf(z))
        }
        Prior::Angle(_) => (z, 1.0),
    }
}

fn to_normal(slot: &Slot, value: f64) -> f64 {
    let within = |truncated: Option<TruncatedNormal>, t| truncated.map_or(t, |truncated| truncated.point(t));
    let z = match slot.prior {
        Prior::Normal { mean, sd } => within(normal(mean, sd, slot), (value - mean) / sd),
        Prior::LogNormal { median, sd } => {
            let t = (value.max(f64::MIN_POSITIVE) / median).ln() / sd;
            within(log_normal(median, sd, slot), t)
        }
        Prior::Uniform | Prior::OnBody(_) => {
            let extent = slot.upper - slot.lower;
            let (under, over) = ((value - slot.lower) / extent, (slot.upper - value) / extent);
            if under < over {
                quantile(under.max(BOUND_PROBABILITY))
            } else {
                -quantile(over.max(BOUND_PROBABILITY))
            }
        }
        Prior::Angle(_) => value,
    };
    if z.is_nan() { 0.0 } else { clamp_to_prior(z, slot) }
}
