//! Poses that agree neither with the motion before them nor with the motion after them.
//!
//! At a knock or a sudden stop a good pose leaves what came before, but agrees with what follows; a spike leaves
//! both, to the same side.

use super::intensity::likeliest_by;
use super::kalman::{Axis, Estimate, LogSum, Update};
use rayon::prelude::*;

/// Standard deviations of the prediction at which a pose disagrees.
const GATE: f64 = 5.0;
/// After this many disagreements in a row the filter follows the poses.
const PATIENCE: usize = 3;
/// Where the prediction is this many times less certain than the pose, it has no opinion.
const VAGUE: f64 = 100.0;
/// Fewer poses than this hold no motion to compare with.
const FEWEST: usize = 8;

/// Indices of the spikes among `pose` (theta unwrapped) at times `t`, in increasing order.
pub(crate) fn spikes(t: &[f64], pose: &[[f64; 3]], sd: &[f64; 3]) -> Vec<usize> {
    if t.len() < FEWEST {
        return vec![];
    }
    let axis = |k: usize| {
        let z: Vec<f64> = pose.iter().map(|p| p[k]).collect();
        on_axis(t, &z, sd[k])
    };
    let mut found: Vec<usize> = (0..3).into_par_iter().flat_map_iter(axis).collect();
    found.sort_unstable();
    found.dedup();
    found
}

fn on_axis(t: &[f64], z: &[f64], sd: f64) -> Vec<usize> {
    if z.iter().all(|value| *value == z[0]) {
        return vec![];
    }
    let before = disagreements(t, z, sd);
    let reversed: Vec<f64> = t.iter().rev().map(|t| -t).collect();
    let mirrored: Vec<f64> = z.iter().rev().copied().collect();
    let mut after = disagreements(&reversed, &mirrored, sd);
    after.reverse();
    let spike = |(a, b): (&Option<f64>, &Option<f64>)| match (a, b) {
        (Some(a), Some(b)) => a.abs().min(b.abs()) > GATE && a * b > 0.0,
        (Some(alone), None) | (None, Some(alone)) => alone.abs() > GATE,
        (None, None) => false,
    };
    (0..z.len()).filter(|&i| spike((&before[i], &after[i]))).collect()
}

/// Each pose less its prediction from the poses before it, in standard deviations; `None`: no opinion.
fn disagreements(t: &[f64], z: &[f64], sd: f64) -> Vec<Option<f64>> {
    let axis = Axis::new(t, z, sd, None);
    let jerk = likeliest_by(|jerk| gated(&axis, jerk, |_| ()));
    let mut scores = Vec::with_capacity(t.len());
    gated(&axis, jerk, |update| {
        let known = update.spread < VAGUE * axis.variance;
        scores.push(known.then(|| update.innovation / update.spread.sqrt()));
    });
    scores
}

/// Log likelihood of a filter that does not follow a pose that disagrees, unless several in a row do.
fn gated(axis: &Axis, jerk: f64, mut see: impl FnMut(&Update)) -> f64 {
    let mut state: Option<Estimate> = None;
    let (mut surprise, mut spread, mut refused) = (0.0, LogSum::new(), 0);
    for i in 0..axis.t.len() {
        let predicted = state.as_ref().map_or_else(|| axis.start(), |last| axis.predict(i, last, jerk));
        let update = axis.update(i, predicted);
        let square = update.surprise();
        let follows = square <= GATE * GATE || refused == PATIENCE;
        surprise += square.min(GATE * GATE);
        spread.add(update.spread);
        see(&update);
        refused = if follows { 0 } else { refused + 1 };
        state = Some(if follows { update.posterior() } else { update.predicted });
    }
    -0.5 * (surprise + spread.value())
}
