//! The coordinates in which parameters are searched: each is standard normal under its prior.
//!
//! | prior | value |
//! | --- | --- |
//! | normal | `mean + sd·z` |
//! | log-normal | `median·exp(sd·z)` |
//! | on the body | `low + (high − low)·Φ(z)`: uniform |
//! | angle | `z` itself; uniform on its circle, so without a prior |
//!
//! All are of order one, none has a bound to run into, and the prior's part of the cost is `z²/2`.

use rand::RngExt;
use rand_distr::StandardNormal;
use statrs::function::erf::{erf, erf_inv};
use std::f64::consts::{PI, SQRT_2, TAU};
use trundle_model::{Model, Prior, Slot};

/// Values beyond this many prior standard deviations are not searched.
const REACH: f64 = 8.0;

/// Part of the footprint's extent that a wheel may stand outside of it.
const MARGIN: f64 = 0.05;

/// The free parameters of a model, as points `z`.
#[derive(Clone, Debug)]
pub struct Coordinates {
    slots: Vec<Slot>,
    free: Vec<usize>,
}

impl Coordinates {
    /// The free parameters of a model.
    pub fn new(model: &Model) -> Self {
        Self::of(model.slots())
    }

    /// The free ones among `slots`.
    pub fn of(slots: Vec<Slot>) -> Self {
        let free = (0..slots.len()).filter(|&k| slots[k].value.is_none()).collect();
        Self { slots, free }
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

    /// A draw from the prior.
    pub fn draw(&self, rng: &mut impl RngExt) -> Vec<f64> {
        let one = |&k: &usize| match self.slots[k].prior {
            Prior::Angle(period) => period * (rng.random::<f64>() - 0.5),
            _ => rng.sample::<f64, _>(StandardNormal),
        };
        self.free.iter().map(one).collect()
    }

    /// Minus the logarithm of the prior density at `z`, in the coordinates `z`.
    pub fn prior_cost(&self, z: &[f64]) -> f64 {
        z.iter().enumerate().map(|(k, &z)| self.prior_cost_of(k, z)).sum()
    }

    /// The share of the free parameter `k` in [`Coordinates::prior_cost`].
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

fn span(slot: &Slot) -> (f64, f64) {
    let margin = MARGIN * (slot.upper - slot.lower);
    (slot.lower - margin, slot.upper + margin)
}

fn from_normal(slot: &Slot, z: f64) -> (f64, f64) {
    match slot.prior {
        Prior::Normal { mean, sd } => (mean + sd * z, sd),
        Prior::LogNormal { median, sd } => {
            let value = median * (sd * z).exp();
            (value, sd * value)
        }
        Prior::Uniform | Prior::OnBody(_) => {
            let (low, high) = span(slot);
            let share = 0.5 * (1.0 + erf(z / SQRT_2));
            (low + (high - low) * share, (high - low) * (-0.5 * z * z).exp() / (2.0 * PI).sqrt())
        }
        Prior::Angle(_) => (z, 1.0),
    }
}

fn to_normal(slot: &Slot, value: f64) -> f64 {
    let z = match slot.prior {
        Prior::Normal { mean, sd } => (value - mean) / sd,
        Prior::LogNormal { median, sd } => (value.max(f64::MIN_POSITIVE) / median).ln() / sd,
        Prior::Uniform | Prior::OnBody(_) => {
            let (low, high) = span(slot);
            let share = ((value - low) / (high - low)).clamp(1e-9, 1.0 - 1e-9);
            SQRT_2 * erf_inv(2.0 * share - 1.0)
        }
        Prior::Angle(_) => value,
    };
    within_reach(z, slot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_model::{Body, Effect, Kind};

    #[test]
    fn values_and_points_invert_each_other_and_slopes_are_right() {
        let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0).unwrap();
        let model = Model::nominal(body, None, [true; 3]).with(Effect::free(Kind::ForceBias));
        let coordinates = Coordinates::new(&model);
        let z: Vec<f64> = (0..coordinates.free().len()).map(|k| 0.3 * k as f64 - 1.0).collect();
        let (values, slopes) = coordinates.values(&z);
        for (a, b) in coordinates.point(&values).iter().zip(&z) {
            assert!((a - b).abs() < 1e-9);
        }
        for (k, &slope) in slopes.iter().enumerate() {
            let mut moved = z.clone();
            moved[k] += 1e-6;
            let slot = coordinates.free()[k];
            let numeric = (coordinates.values(&moved).0[slot] - values[slot]) / 1e-6;
            assert!((numeric - slope).abs() < 1e-4 * (1.0 + slope.abs()), "{k}: {numeric} {slope}");
        }
    }
}
