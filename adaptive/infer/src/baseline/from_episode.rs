//! Transitions from recordings, for regressions on the same data as a fit.

use super::transitions::Transition;
use trundle_record::{Motion, Noise, Prepared};

/// Maximum duration of a transition relative to the requested one; longer intervals are gaps.
const MAX_DURATION_RATIO: f64 = 1.2;

/// Transitions of a prepared episode: successive intervals of `dt` seconds from contact on. The states are
/// smoothed over all poses. The wrench is the mean over the interval of the tared wrench on the object, in
/// object axes.
///
/// The states depend on later poses, as in a fit of the whole episode. Intervals within a gap of the poses or
/// without a wrench sample are left out.
pub fn transitions_of(episode: &Prepared, noise: &Noise, dt: f64) -> Vec<Transition> {
    let motion = episode.motion(noise);
    let mut found = vec![];
    let mut from = motion.partition_point(|m| m.t < episode.contact);
    if !(dt.is_finite() && dt > 0.0) {
        return found;
    }
    while let Some(before) = motion.get(from) {
        // The pose nearest to the end of the interval.
        let reach = before.t + dt - spacing(&motion, from) / 2.0;
        let to = motion.partition_point(|m| m.t < reach).max(from + 1);
        let Some(after) = motion.get(to) else { break };
        if after.t - before.t <= MAX_DURATION_RATIO * dt {
            found.extend(mean_wrench(episode, before.t, after.t).map(|wrench| Transition {
                before: vector(before),
                wrench,
                dt: after.t - before.t,
                after: vector(after),
            }));
        }
        from = to;
    }
    found
}

/// Time to the next pose, s.
fn spacing(motion: &[Motion], index: usize) -> f64 {
    motion.get(index + 1).map_or(0.0, |next| next.t - motion[index].t)
}

fn vector(m: &Motion) -> [f64; 6] {
    [m.pose[0], m.pose[1], m.pose[2], m.twist[0], m.twist[1], m.twist[2]]
}

/// Mean wrench on the object over an interval; `None` where nothing was read.
fn mean_wrench(episode: &Prepared, from: f64, to: f64) -> Option<[f64; 3]> {
    let first = episode.wrench.partition_point(|w| w.t < from);
    let end = episode.wrench.partition_point(|w| w.t < to);
    let samples = episode.wrench.get(first..end).filter(|samples| !samples.is_empty())?;
    let n = samples.len() as f64;
    let add = |sum: [f64; 3], w: [f64; 3]| [0, 1, 2].map(|k| sum[k] + w[k] / n);
    Some(samples.iter().map(|w| w.on_object()).fold([0.0; 3], add))
}
