//! The coordinates in which parameters are searched: each is standard normal under its prior.
//!
//! | prior | value |
//! | --- | --- |
//! | normal | `mean + sd·T(z)` |
//! | log-normal | `median·exp(sd·T(z))` |
//! | uniform, on the body | `lower + (upper − lower)·Φ(z)` |
//! | angle | `z` itself; uniform on its circle, so without a prior |
//!
//! `T(z)` is `z` where the slot's bounds are out of reach, and elsewhere maps the normal
//! distribution onto the one that is cut off at them: no value is ever illegal. All are of order
//! one, none has a bound to run into, and the prior's part of the cost is `z²/2`. The two
//! coordinates of a place have one more part, the footprint's ([`Footing`]).

use crate::footing::{Footing, Pull};
use crate::truncated::{Truncated, below, density, quantile};
use rand::RngExt;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;
use trundle_model::{Model, Prior, Slot};

/// Values beyond this many prior standard deviations are not searched.
const REACH: f64 = 8.0;

/// A parameter beyond this many prior standard deviations is where the prior all but excludes it:
/// one draw of 16 000. Also how far, in the data's standard deviations, they must want to go
/// beyond an end of a prior.
const STRAINED: f64 = 4.0;

/// An estimate within this many prior standard deviations is not at an end of it.
const INSIDE: f64 = 2.0;

/// A value at an end of a uniform prior, or beyond it, is taken to have this share beyond it.
const EDGE: f64 = 1e-9;

/// Draws until all places are under the footprint.
const REDRAWS: usize = 100;

/// The free parameters of a model, as points `z`.
#[derive(Clone, Debug)]
pub struct Coordinates {
    slots: Vec<Slot>,
    free: Vec<usize>,
    footings: Vec<Footing>,
}

/// A parameter whose estimate the prior all but excludes.
#[derive(Clone, Debug, PartialEq)]
pub struct Strain {
    /// Name as in [`Slot::name`].
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// The estimate.
    pub value: f64,
    /// Its coordinate: how many prior standard deviations it is out; for a distribution with ends,
    /// as many as leave the same probability beyond.
    pub z: f64,
    /// What the prior allows within that many standard deviations at most.
    pub range: [f64; 2],
}

impl std::fmt::Display for Strain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, unit, range: [low, high], .. } = self;
        let side = if self.z > 0.0 { "above" } else { "below" };
        let (low, high, value) = (four_digits(*low), four_digits(*high), four_digits(self.value));
        write!(
            f,
            "the prior excludes the data: {name} wants to leave [{low}, {high}] {unit} {side} and is held \
             at {value}; widen its prior, or ask whether the model lacks an effect"
        )
    }
}

/// Rounded to four digits.
fn four_digits(x: f64) -> f64 {
    let unit = 10f64.powf(3.0 - x.abs().log10().floor());
    if x == 0.0 || !unit.is_finite() { x } else { (x * unit).round() / unit }
}

impl Coordinates {
    /// The free parameters of a model, places of effects restricted to its footprint.
    pub fn new(model: &Model) -> Self {
        Self::of(model.slots()).under(model)
    }

    /// The free ones among `slots`.
    pub fn of(slots: Vec<Slot>) -> Self {
        let free = (0..slots.len()).filter(|&k| slots[k].value.is_none()).collect();
        Self { slots, free, footings: vec![] }
    }

    /// The same with places restricted to the model's footprint; its slots are the first here.
    #[must_use]
    pub fn under(mut self, model: &Model) -> Self {
        let value =
            |k: usize, z: f64| self.slots[k].value.unwrap_or_else(|| from_normal(&self.slots[k], z).0);
        self.footings = Footing::all(model, &value);
        self
    }

    /// The places that the footprint restricts.
    pub fn footings(&self) -> &[Footing] {
        &self.footings
    }

    /// The free parameters that are a place's coordinates; `None` where one is given.
    pub fn coordinates_of(&self, footing: &Footing) -> [Option<usize>; 2] {
        footing.slots.map(|slot| self.free.iter().position(|&k| k == slot))
    }

    /// A place's part of the prior at its coordinates `z` (any number for one that is given), its
    /// slopes by `z`: to the cost it adds `cost`, to the gradient `residual·slopes`, to the
    /// curvature `slopes·slopesᵀ`.
    pub fn pull(&self, footing: &Footing, z: [f64; 2]) -> Pull {
        let at = [0, 1].map(|k| {
            let slot = &self.slots[footing.slots[k]];
            slot.value.map_or_else(|| from_normal(slot, z[k]), |value| (value, 0.0))
        });
        let pull = footing.pull(at.map(|(value, _)| value));
        Pull { slopes: [pull.slopes[0] * at[0].1, pull.slopes[1] * at[1].1], ..pull }
    }

    /// The free parameter `k`, if its estimate, a posterior mode with the coordinate `z`, is one
    /// that the prior all but excludes; `information` is the curvature of the likelihood's cost
    /// there by that coordinate.
    ///
    /// It is, where `z` is more than four prior standard deviations out; or, at an end of a
    /// prior (more than two out), where the data want to go on by more than four of their own
    /// standard deviations: at a mode their cost falls by `z` for each unit of `z`, so that is
    /// `|z|/√information > 4`, a likelihood e⁸ times higher. Angles have no prior to contradict.
    pub fn strain(&self, k: usize, z: f64, information: f64) -> Option<Strain> {
        let slot = self.slot(k);
        let beyond = z.abs() > INSIDE && z * z > STRAINED * STRAINED * information.max(0.0);
        if matches!(slot.prior, Prior::Angle(_)) || !(z.abs() > STRAINED || beyond) {
            return None;
        }
        let value = |z| from_normal(slot, z).0;
        let (name, unit) = (slot.name.clone(), slot.unit);
        Some(Strain { name, unit, value: value(z), z, range: [value(-STRAINED), value(STRAINED)] })
    }

    /// Indices of the free ones among [`Model::slots`].
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

    /// Values of all slots at `z`, and the slope of each free value by its `z`.
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

    /// The point `z` of given values of all slots.
    pub fn point(&self, values: &[f64]) -> Vec<f64> {
        self.free.iter().map(|&k| to_normal(&self.slots[k], values[k])).collect()
    }

    /// A draw from the prior; places under the footprint.
    pub fn draw(&self, rng: &mut impl RngExt) -> Vec<f64> {
        let mut z = self.draw_apart(rng);
        // A footprint that fills so little of its extent that this fails takes what it gets.
        for _ in 0..REDRAWS {
            if self.footings.iter().all(|footing| self.pull_at(footing, &z).residual <= 0.0) {
                break;
            }
            z = self.draw_apart(rng);
        }
        z
    }

    fn draw_apart(&self, rng: &mut impl RngExt) -> Vec<f64> {
        let one = |&k: &usize| match self.slots[k].prior {
            Prior::Angle(period) => period * (rng.random::<f64>() - 0.5),
            _ => rng.sample::<f64, _>(StandardNormal),
        };
        self.free.iter().map(one).collect()
    }

    fn pull_at(&self, footing: &Footing, z: &[f64]) -> Pull {
        let [x, y] = self.coordinates_of(footing).map(|k| k.map_or(0.0, |k| z[k]));
        self.pull(footing, [x, y])
    }

    /// Minus the logarithm of the prior density at `z`, in the coordinates `z`.
    pub fn prior_cost(&self, z: &[f64]) -> f64 {
        let apart: f64 = z.iter().enumerate().map(|(k, &z)| self.prior_cost_of(k, z)).sum();
        apart + self.footings.iter().map(|footing| self.pull_at(footing, z).cost).sum::<f64>()
    }

    /// The share of the free parameter `k` in [`Coordinates::prior_cost`]; the footprint's is not in it.
    pub fn prior_cost_of(&self, k: usize, z: f64) -> f64 {
        match self.slot(k).prior {
            Prior::Angle(period) => period.ln(),
            _ => 0.5 * (z * z + TAU.ln()),
        }
    }

    /// Precision of the prior of the free parameter `k`, in the coordinates `z`.
    pub fn prior_precision(&self, k: usize) -> f64 {
        if matches!(self.slot(k).prior, Prior::Angle(_)) { 0.0 } else { 1.0 }
    }

    /// Precision that a posterior has at least: for an angle that the data do not hold, such that
    /// its Laplace integral is its circle.
    pub fn least_precision(&self, k: usize) -> f64 {
        match self.slot(k).prior {
            Prior::Angle(period) => TAU / (period * period),
            _ => 1.0,
        }
    }

    /// Whether a posterior standard deviation of `z` means that the data hold this parameter:
    /// three times narrower than the prior, and a positive one within a factor of e^½, an angle
    /// within 0.3 rad.
    pub fn identified(&self, k: usize, sd: f64) -> bool {
        match self.slot(k).prior {
            Prior::Angle(_) => sd < 0.3,
            Prior::LogNormal { sd: spread, .. } => sd < 0.3 && sd * spread < 0.5,
            _ => sd < 0.3,
        }
    }
}

/// Keep a search from leaving the range where numbers mean something.
pub(crate) fn within_reach(z: f64, slot: &Slot) -> f64 {
    if matches!(slot.prior, Prior::Angle(_)) { z } else { z.clamp(-REACH, REACH) }
}

/// The slot's bounds in prior standard deviations, where they are within reach.
fn cut(low: f64, high: f64) -> Option<Truncated> {
    (low > -REACH || high < REACH).then_some(Truncated { low, high })
}

fn normal(mean: f64, sd: f64, slot: &Slot) -> Option<Truncated> {
    cut((slot.lower - mean) / sd, (slot.upper - mean) / sd)
}

fn log_normal(median: f64, sd: f64, slot: &Slot) -> Option<Truncated> {
    cut((slot.lower.max(0.0) / median).ln() / sd, (slot.upper / median).ln() / sd)
}

fn from_normal(slot: &Slot, z: f64) -> (f64, f64) {
    let within = |cut: Option<Truncated>| cut.map_or((z, 1.0), |cut| cut.value(z));
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
            // From the nearer end, so that neither loses digits.
            let value =
                if z < 0.0 { slot.lower + extent * below(z) } else { slot.upper - extent * below(-z) };
            (value, extent * density(z))
        }
        Prior::Angle(_) => (z, 1.0),
    }
}

fn to_normal(slot: &Slot, value: f64) -> f64 {
    let within = |cut: Option<Truncated>, t| cut.map_or(t, |cut| cut.point(t));
    let z = match slot.prior {
        Prior::Normal { mean, sd } => within(normal(mean, sd, slot), (value - mean) / sd),
        Prior::LogNormal { median, sd } => {
            let t = (value.max(f64::MIN_POSITIVE) / median).ln() / sd;
            within(log_normal(median, sd, slot), t)
        }
        Prior::Uniform | Prior::OnBody(_) => {
            let extent = slot.upper - slot.lower;
            let (under, over) = ((value - slot.lower) / extent, (slot.upper - value) / extent);
            if under < over { quantile(under.max(EDGE)) } else { -quantile(over.max(EDGE)) }
        }
        Prior::Angle(_) => value,
    };
    if z.is_nan() { 0.0 } else { within_reach(z, slot) }
}
