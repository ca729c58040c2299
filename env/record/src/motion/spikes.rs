//! Detection of spikes: poses that disagree with the motion before them and with the motion after them.
//!
//! After an impact or a sudden stop, a valid pose disagrees with the motion before it but agrees with the motion after it.
//! A spike disagrees with both, in the same direction. How jerky a motion is does not depend on the direction of time, so
//! that both directions have one intensity of the jerk. Otherwise one of them may explain a rest as a row of spikes.

use super::intensity::maximize;
use super::kalman::{Axis, Estimate, LogSum, Update};
use rayon::prelude::*;

/// Normalised innovation above which a pose disagrees with the prediction.
const GATE_SD: f64 = 5.0;
/// Number of consecutive disagreements after which the filter follows the poses.
const MAX_CONSECUTIVE_REJECTIONS: usize = 3;
/// Innovation variance in pose variances above which the prediction is too uncertain to judge a pose.
const MAX_INNOVATION_VARIANCE_RATIO: f64 = 100.0;
/// Minimum number of poses for a comparison with the motion.
const MIN_POSES: usize = 8;

/// Indices of the spikes among `pose` (theta unwrapped) at times `t`, in increasing order.
pub(crate) fn spikes(t: &[f64], pose: &[[f64; 3]], sd: &[f64; 3]) -> Vec<usize> {
    if t.len() < MIN_POSES {
        return vec![];
    }
    let axis = |k: usize| {
        let z: Vec<f64> = pose.iter().map(|p| p[k]).collect();
        spikes_on_axis(t, &z, sd[k])
    };
    let mut found: Vec<usize> = (0..3).into_par_iter().flat_map_iter(axis).collect();
    found.sort_unstable();
    found.dedup();
    found
}

fn spikes_on_axis(t: &[f64], z: &[f64], sd: f64) -> Vec<usize> {
    if z.iter().all(|value| *value == z[0]) {
        return vec![];
    }
    let reversed: Vec<f64> = t.iter().rev().map(|t| -t).collect();
    let mirrored: Vec<f64> = z.iter().rev().copied().collect();
    let axes = [Axis::new(t, z, sd, None), Axis::new(&reversed, &mirrored, sd, None)];
    let jerk = maximize(|jerk| axes.iter().map(|axis| gated_log_likelihood(axis, jerk, |_| ())).sum());
    let [before, mut after] = axes.map(|axis| normalized_innovations(&axis, jerk));
    after.reverse();
    let spike = |(a, b): (&Option<f64>, &Option<f64>)| match (a, b) {
        (Some(a), Some(b)) => a.abs().min(b.abs()) > GATE_SD && a * b > 0.0,
        (Some(alone), None) | (None, Some(alone)) => alone.abs() > GATE_SD,
        (None, None) => false,
    };
    (0..z.len()).filter(|&i| spike((&before[i], &after[i]))).collect()
}

/// Normalised innovation of each pose given the poses before it; `None` if the prediction is too uncertain.
fn normalized_innovations(axis: &Axis, jerk: f64) -> Vec<Option<f64>> {
    let mut scores = Vec::with_capacity(axis.t.len());
    gated_log_likelihood(axis, jerk, |update| {
        let known = update.innovation_variance < MAX_INNOVATION_VARIANCE_RATIO * axis.variance;
        scores.push(known.then(|| update.innovation / update.innovation_variance.sqrt()));
    });
    scores
}

/// Log-likelihood of a filter that rejects disagreeing poses, unless several in a row disagree.
fn gated_log_likelihood(axis: &Axis, jerk: f64, mut visit: impl FnMut(&Update)) -> f64 {
    let mut state: Option<Estimate> = None;
    let (mut squares, mut log_variances, mut rejected) = (0.0, LogSum::new(), 0);
    for i in 0..axis.t.len() {
        let predicted = state.as_ref().map_or_else(|| axis.start(), |last| axis.predict(i, last, jerk));
        let update = axis.update(i, predicted);
        let square = update.normalized_square();
        let follows = square <= GATE_SD * GATE_SD || rejected == MAX_CONSECUTIVE_REJECTIONS;
        squares += square.min(GATE_SD * GATE_SD);
        log_variances.add(update.innovation_variance);
        visit(&update);
        rejected = if follows { 0 } else { rejected + 1 };
        state = Some(if follows { update.posterior() } else { update.predicted });
    }
    -0.5 * (squares + log_variances.value())
}
