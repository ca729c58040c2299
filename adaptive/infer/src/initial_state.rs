//! Estimates the initial values of the laws' own states, for example the direction of a caster, in a
//! simulation from the first pose.

use crate::error_metrics::wrap;
use crate::simulation::simulate;
use trundle_model::{InnerState, MAX_INNER_STATES, Model, Plant};
use trundle_record::Prepared;

/// Time after contact from which the initial states are estimated, s. This time is excluded from the error
/// metrics.
pub const SETTLING_TIME_S: f64 = 1.0;

/// Golden-section steps for each state: the bracket shrinks by a factor of about 1000.
const GOLDEN_STEPS: usize = 16;

/// Points tried around each start, in standard deviations. A caster that points against the motion may swivel
/// either way, so the misfit is discontinuous.
const START_GRID_SD: [f64; 9] = [-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0];

/// Time after contact that is excluded from the error metrics of a model, s. It is nonzero if a state of a
/// law has several possible starts and must be estimated.
pub fn unscored_time(model: &Model) -> f64 {
    if model.inner().iter().any(is_unknown) { SETTLING_TIME_S } else { 0.0 }
}

fn is_unknown(inner: &InnerState) -> bool {
    inner.starts.len() > 1
}

/// Initial states whose simulated motion is closest to the recorded motion in the first second after contact.
/// The search takes the best combination of the laws' starts, then refines one state at a time: on a grid
/// around every start, then by golden sections around the best point.
pub(crate) fn initial_state(plant: &Plant<f64>, episode: &Prepared) -> [f64; MAX_INNER_STATES] {
    let own: Vec<InnerState> = plant.laws.iter().flat_map(|law| law.spec().inner_states).copied().collect();
    let combinations = combinations(&own);
    let first = combinations.first().copied().unwrap_or_default();
    if combinations.len() < 2 {
        return first;
    }
    let costs: Vec<f64> =
        combinations.iter().map(|&combination| misfit(plant, episode, combination)).collect();
    let best = (0..combinations.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b]));
    let mut best = best.map_or(first, |k| combinations[k]);
    for (k, inner) in own.iter().enumerate().filter(|(_, inner)| is_unknown(inner)) {
        let cost = |value: f64| {
            let mut trial = best;
            trial[k] = value;
            misfit(plant, episode, trial)
        };
        let tried = inner.starts.iter().flat_map(|start| START_GRID_SD.map(|share| start + share * inner.sd));
        let center = tried.map(|v| (v, cost(v))).min_by(|a, b| a.1.total_cmp(&b.1)).map_or(best[k], |v| v.0);
        let found = golden_section(center - 0.25 * inner.sd, center + 0.25 * inner.sd, cost);
        best[k] = found;
    }
    best
}

/// Every combination of starts.
fn combinations(own: &[InnerState]) -> Vec<[f64; MAX_INNER_STATES]> {
    let mut combinations = vec![[0.0; MAX_INNER_STATES]];
    for (k, inner) in own.iter().enumerate().take(MAX_INNER_STATES) {
        let with = |combination: &[f64; MAX_INNER_STATES], start: f64| {
            let mut combination = *combination;
            combination[k] = start;
            combination
        };
        combinations =
            combinations.iter().flat_map(|o| inner.starts.iter().map(move |&s| with(o, s))).collect();
    }
    combinations
}

/// Sum of squared distances from the recorded motion up to [`SETTLING_TIME_S`] after contact. Rotations are
/// scaled by the radius of gyration.
fn misfit(plant: &Plant<f64>, episode: &Prepared, inner: [f64; MAX_INNER_STATES]) -> f64 {
    let square = plant.inertia / plant.mass;
    let poses = simulate(plant, episode, inner, episode.contact + SETTLING_TIME_S);
    let one = |(seen, [x, y, heading]): (&[f64; 3], &[f64; 3])| {
        (seen[0] - x).powi(2) + (seen[1] - y).powi(2) + square * wrap(seen[2] - heading).powi(2)
    };
    let cost: f64 = episode.pose.iter().map(|p| p.pose).zip(&poses).map(|(seen, at)| one((&seen, at))).sum();
    if cost.is_finite() { cost } else { f64::INFINITY }
}

/// Minimum of a function on an interval by golden-section search.
fn golden_section(mut low: f64, mut high: f64, cost: impl Fn(f64) -> f64) -> f64 {
    const SHARE: f64 = 0.618_033_988_749_894_9;
    let inside = |low: f64, high: f64| [high - SHARE * (high - low), low + SHARE * (high - low)];
    let [mut left, mut right] = inside(low, high);
    let (mut at_left, mut at_right) = (cost(left), cost(right));
    for _ in 0..GOLDEN_STEPS {
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
    fn golden_sections_find_the_minimum() {
        assert!((golden_section(-1.0, 2.0, |x| (x - 0.3).powi(2)) - 0.3).abs() < 2e-3);
    }

    #[test]
    fn starts_combine_in_every_way() {
        let inner = |starts| InnerState { name: "a", unit: "1", sd: 1.0, starts };
        let found = combinations(&[inner(&[1.0, 2.0]), inner(&[0.0]), inner(&[3.0, 4.0])]);
        assert_eq!(found.len(), 4);
        assert_eq!(found[1][..3], [1.0, 0.0, 4.0]);
    }
}
