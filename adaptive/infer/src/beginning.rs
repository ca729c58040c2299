//! Where the laws' own states begin, when a simulation from the first pose on does not know: a caster may stand any way.

use crate::rollout::simulated;
use crate::tally::wrap;
use trundle_model::{InnerState, MAX_INNER_STATES, Model, Plant};
use trundle_record::Prepared;

/// Time after contact by which they are found, and which is then not judged, s.
pub const SETTLING: f64 = 1.0;

/// Refinements of each state: the bracket shrinks to a thousandth.
const SECTIONS: usize = 16;

/// Places tried around each start, in standard deviations: a caster that stands against the motion swivels one way or
/// the other, so that the misfit has cliffs.
const AROUND: [f64; 9] = [-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0];

/// How long after contact a model's simulations are not judged, s: some where a law's state has several possible starts,
/// which the data must tell.
pub fn unjudged(model: &Model) -> f64 {
    if model.inner().iter().any(is_unknown) { SETTLING } else { 0.0 }
}

fn is_unknown(inner: &InnerState) -> bool {
    inner.starts.len() > 1
}

/// The starting states by which the simulated motion is nearest to the recorded one in the first second after contact:
/// the best of those on offer, then one state after the other, around every start and by golden sections about the best.
pub(crate) fn beginning(plant: &Plant<f64>, episode: &Prepared) -> [f64; MAX_INNER_STATES] {
    let own: Vec<InnerState> = plant.laws.iter().flat_map(|law| law.spec().inner_states).copied().collect();
    let offers = offers(&own);
    let first = offers.first().copied().unwrap_or_default();
    if offers.len() < 2 {
        return first;
    }
    let costs: Vec<f64> = offers.iter().map(|&offer| misfit(plant, episode, offer)).collect();
    let best = (0..offers.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b]));
    let mut best = best.map_or(first, |k| offers[k]);
    for (k, inner) in own.iter().enumerate().filter(|(_, inner)| is_unknown(inner)) {
        let cost = |value: f64| {
            let mut trial = best;
            trial[k] = value;
            misfit(plant, episode, trial)
        };
        let tried = inner.starts.iter().flat_map(|start| AROUND.map(|share| start + share * inner.sd));
        let center = tried.map(|v| (v, cost(v))).min_by(|a, b| a.1.total_cmp(&b.1)).map_or(best[k], |v| v.0);
        let found = golden(center - 0.25 * inner.sd, center + 0.25 * inner.sd, cost);
        best[k] = found;
    }
    best
}

/// Every combination of starts.
fn offers(own: &[InnerState]) -> Vec<[f64; MAX_INNER_STATES]> {
    let mut offers = vec![[0.0; MAX_INNER_STATES]];
    for (k, inner) in own.iter().enumerate().take(MAX_INNER_STATES) {
        let with = |offer: &[f64; MAX_INNER_STATES], start: f64| {
            let mut offer = *offer;
            offer[k] = start;
            offer
        };
        offers = offers.iter().flat_map(|o| inner.starts.iter().map(move |&s| with(o, s))).collect();
    }
    offers
}

/// Squared distance from the recorded motion, up to the end of settling; a turn counts at the radius of gyration.
fn misfit(plant: &Plant<f64>, episode: &Prepared, inner: [f64; MAX_INNER_STATES]) -> f64 {
    let square = plant.inertia / plant.mass;
    let poses = simulated(plant, episode, inner, episode.contact + SETTLING);
    let one = |(seen, [x, y, heading]): (&[f64; 3], &[f64; 3])| {
        (seen[0] - x).powi(2) + (seen[1] - y).powi(2) + square * wrap(seen[2] - heading).powi(2)
    };
    let cost: f64 = episode.pose.iter().map(|p| p.pose).zip(&poses).map(|(seen, at)| one((&seen, at))).sum();
    if cost.is_finite() { cost } else { f64::INFINITY }
}

/// The least of a function between two ends, by golden sections.
fn golden(mut low: f64, mut high: f64, cost: impl Fn(f64) -> f64) -> f64 {
    const SHARE: f64 = 0.618_033_988_749_894_9;
    let inside = |low: f64, high: f64| [high - SHARE * (high - low), low + SHARE * (high - low)];
    let [mut left, mut right] = inside(low, high);
    let (mut at_left, mut at_right) = (cost(left), cost(right));
    for _ in 0..SECTIONS {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = inside(low, high)[0];
            at_left = cost(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = inside(low, high)[1];
            at_right = cost(right);
        }
    }
    (low + high) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_sections_find_the_least() {
        assert!((golden(-1.0, 2.0, |x| (x - 0.3).powi(2)) - 0.3).abs() < 2e-3);
    }

    #[test]
    fn every_combination_is_on_offer() {
        let inner = |starts| InnerState { name: "a", unit: "1", sd: 1.0, starts };
        let found = offers(&[inner(&[1.0, 2.0]), inner(&[0.0]), inner(&[3.0, 4.0])]);
        assert_eq!(found.len(), 4);
        assert_eq!(found[1][..3], [1.0, 0.0, 4.0]);
    }
}
