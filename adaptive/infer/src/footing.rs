//! Places on the body: a wheel stands under the footprint, not merely within its extent; a mass centre lies within its hull.
//!
//! The coordinates of a place are searched one by one, uniform over the footprint's extent. Where
//! the footprint is not that rectangle, the prior density of the place is multiplied by
//! `exp(−d²/2s²)/S`, with `d` the distance outside of the shape, `s` [`SKIRT`] of its longer
//! extent, and `S` the mean of that factor under the coordinates' own priors, so that the density
//! stays normalised. A hard edge would leave a search nothing to follow back inside; an outline is
//! not known much better than `s` either.

use crate::truncated::quantile;
use trundle_model::{Body, Fixture, Kind, Model, Prior};

/// Scale on which the density vanishes outside of the footprint, as part of its longer extent.
const SKIRT: f64 = 0.005;

/// Points along a side of the grid over which the factor is averaged.
const GRID: usize = 96;

/// One place on the body.
#[derive(Clone, Debug)]
pub struct Footing {
    /// Slots of its coordinates x and y.
    pub(crate) slots: [usize; 2],
    body: Body,
    skirt: f64,
    log_share: f64,
}

/// A place's part in the cost of the prior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// `d²/2s² + ln S`.
    pub cost: f64,
    /// The residual `d/s`.
    pub residual: f64,
    /// Its slopes by the place's coordinates, 1/m.
    pub slopes: [f64; 2],
}

impl Footing {
    /// The place's part in the cost at `point`, m, object frame.
    pub(crate) fn pull(&self, point: [f64; 2]) -> Pull {
        let (distance, slopes) = self.body.outside(point);
        let residual = distance / self.skirt;
        let cost = 0.5 * residual * residual + self.log_share;
        Pull { cost, residual, slopes: slopes.map(|s| s / self.skirt) }
    }

    /// The places of a model that its footprint restricts: those of which a coordinate is free,
    /// under a shape that does not fill its extent.
    ///
    /// `value(slot, z)` is a slot's value at `z`, or its given one.
    pub(crate) fn all(model: &Model, value: &dyn Fn(usize, f64) -> f64) -> Vec<Self> {
        let [low, high] = model.body.bounds();
        let skirt = SKIRT * (high[0] - low[0]).max(high[1] - low[1]);
        let one = |(kind, slots): (Kind, [usize; 2])| {
            let body = if kind.is_mass_centre() { model.body.with_convex_hull() } else { model.body.clone() };
            let footing = Self { slots, body, skirt, log_share: 0.0 };
            let share = footing.share(value);
            // All inside; or given outside of it, where the footprint says nothing.
            let restricts = share < 1.0 && share > 1e-12;
            restricts.then(|| Self { log_share: share.ln(), ..footing })
        };
        places(model).into_iter().filter_map(one).collect()
    }

    /// Mean of the factor `exp(−d²/2s²)` under the coordinates' own priors.
    fn share(&self, value: &dyn Fn(usize, f64) -> f64) -> f64 {
        if fills_extent(&self.body) {
            return 1.0;
        }
        let along = |slot| (0..GRID).map(move |k| value(slot, quantile((k as f64 + 0.5) / GRID as f64)));
        let ys: Vec<f64> = along(self.slots[1]).collect();
        let factor = |x, y| (-self.pull([x, y]).cost).exp();
        let sum: f64 = along(self.slots[0]).map(|x| ys.iter().map(|&y| factor(x, y)).sum::<f64>()).sum();
        sum / (GRID * GRID) as f64
    }
}

/// Whether a shape is its own extent: a rectangle along the axes, or a point.
fn fills_extent(body: &Body) -> bool {
    let [low, high] = body.bounds();
    let at_corner = |p: &[f64; 2]| (0..2).all(|k| p[k] == low[k] || p[k] == high[k]);
    let turns = |a: &[f64; 2], b: &[f64; 2]| (a[0] == b[0]) != (a[1] == b[1]);
    match &body.fixtures[..] {
        [] => true,
        [Fixture::Polygon { vertices, .. }] => {
            let next = vertices.iter().cycle().skip(1);
            vertices.len() == 4
                && vertices.iter().all(at_corner)
                && vertices.iter().zip(next).all(|(a, b)| turns(a, b))
        }
        _ => false,
    }
}

/// Slots of the coordinates of every place of which one is free, and the kind that acts there.
fn places(model: &Model) -> Vec<(Kind, [usize; 2])> {
    let slots = model.slots();
    let (mut found, mut first) = (vec![], 1);
    for effect in &model.effects {
        let params = effect.kind.spec().params;
        let axis = |axis| params.iter().position(|p| p.prior == Prior::OnBody(axis)).map(|k| first + k);
        if let (Some(x), Some(y)) = (axis(0), axis(1)) {
            let free = |k: usize| slots.get(k).is_some_and(|slot| slot.value.is_none());
            if free(x) || free(y) {
                found.push((effect.kind, [x, y]));
            }
        }
        first += effect.values.len();
    }
    found
}
