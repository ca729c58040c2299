//! Footprint prior: restricts places on the body to the footprint. A wheel lies under the footprint, and a
//! mass centre lies within its convex hull.
//!
//! The two coordinates of a place have independent priors, uniform over the bounding box of the footprint.
//! Where the footprint is not that rectangle, the prior density of the place is multiplied by
//! `exp(−d²/2s²)/S`. Here `d` is the distance outside the shape, `s` is [`EDGE_SCALE`] times the longer side
//! of the bounding box, and `S` is the mean of the factor under the coordinates' priors, so that the density
//! stays normalised. The smooth edge gives a search a gradient back into the shape.

use crate::truncated_normal::quantile;
use trundle_model::{Body, Fixture, Kind, Model, Prior};

/// Scale on which the density decays outside the footprint, as a share of the longer side of the bounding
/// box.
const EDGE_SCALE: f64 = 0.005;

/// Grid points along each side for the average of the factor.
const GRID_POINTS: usize = 96;

/// Prior of one place on the body.
#[derive(Clone, Debug)]
pub struct FootprintPrior {
    /// Slots of the coordinates x and y.
    pub(crate) slots: [usize; 2],
    body: Body,
    edge: f64,
    log_normaliser: f64,
}

/// Contribution of a footprint prior to the cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootprintPenalty {
    /// `d²/2s² + ln S`.
    pub cost: f64,
    /// The residual `d/s`.
    pub residual: f64,
    /// Derivatives of the residual by the place's coordinates, 1/m.
    pub slopes: [f64; 2],
}

impl FootprintPrior {
    /// Penalty at `point`, m, object frame.
    pub(crate) fn penalty(&self, point: [f64; 2]) -> FootprintPenalty {
        let (distance, slopes) = self.body.outside(point);
        let residual = distance / self.edge;
        let cost = 0.5 * residual * residual + self.log_normaliser;
        FootprintPenalty { cost, residual, slopes: slopes.map(|s| s / self.edge) }
    }

    /// Footprint priors of a model: one for each place with a free coordinate, if the shape does not fill its
    /// bounding box.
    ///
    /// `value(slot, z)` returns the value of a slot at `z`, or its fixed value.
    pub(crate) fn all(model: &Model, value: &dyn Fn(usize, f64) -> f64) -> Vec<Self> {
        let [low, high] = model.body.bounds();
        let edge = EDGE_SCALE * (high[0] - low[0]).max(high[1] - low[1]);
        let one = |(kind, slots): (Kind, [usize; 2])| {
            let body = if kind.is_mass_centre() { model.body.with_convex_hull() } else { model.body.clone() };
            let prior = Self { slots, body, edge, log_normaliser: 0.0 };
            let share = prior.mean_factor(value);
            // A share of one means that the shape covers the prior. A share of zero means that a fixed
            // coordinate lies outside the footprint, so that the footprint does not restrict the place.
            let restricts = share < 1.0 && share > 1e-12;
            restricts.then(|| Self { log_normaliser: share.ln(), ..prior })
        };
        places(model).into_iter().filter_map(one).collect()
    }

    /// Mean of the factor `exp(−d²/2s²)` under the coordinates' priors.
    fn mean_factor(&self, value: &dyn Fn(usize, f64) -> f64) -> f64 {
        if fills_bounding_box(&self.body) {
            return 1.0;
        }
        let along = |slot| {
            (0..GRID_POINTS).map(move |k| value(slot, quantile((k as f64 + 0.5) / GRID_POINTS as f64)))
        };
        let ys: Vec<f64> = along(self.slots[1]).collect();
        let factor = |x, y| (-self.penalty([x, y]).cost).exp();
        let sum: f64 = along(self.slots[0]).map(|x| ys.iter().map(|&y| factor(x, y)).sum::<f64>()).sum();
        sum / (GRID_POINTS * GRID_POINTS) as f64
    }
}

/// Whether a shape fills its bounding box: an axis-aligned rectangle or a point.
fn fills_bounding_box(body: &Body) -> bool {
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

/// Places with a free coordinate: the kind of the effect, and the slots of the coordinates.
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
