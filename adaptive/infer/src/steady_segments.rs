//! Steady segments of a slow manipulation, in which the object is pushed and moves throughout. Each segment
//! gives one averaged sample.

use crate::curve::Curve;
use crate::wrench_sample::WrenchSample;
use trundle_model::{to_body, transport};
use trundle_record::{Motion, Noise, Prepared};

/// Maximum duration of a segment, s. The friction of a real floor varies with position, so residuals are
/// correlated over about one second. Shorter segments would be counted as independent samples.
const MAX_SEGMENT_S: f64 = 1.0;

/// Minimum duration of a segment, s.
pub(crate) const MIN_SEGMENT_S: f64 = 0.3;

/// Time removed from both ends of a segment, s: the smoother rounds off the start and the end of a motion.
pub(crate) const SEGMENT_EDGE_S: f64 = 0.1;

/// Interval between poses that ends a segment, s.
const MAX_POSE_GAP_S: f64 = 0.1;

/// Half width of the interval around a pose over which the load is averaged, s.
const LOAD_HALF_WIDTH_S: f64 = 0.05;

/// Averaged samples of one episode, one for each steady segment.
pub fn wrench_samples(episode: &Prepared, noise: &Noise) -> Vec<WrenchSample> {
    samples(0, episode, noise)
}

/// Averaged samples of the episode with index `index`.
pub(crate) fn samples(index: usize, episode: &Prepared, noise: &Noise) -> Vec<WrenchSample> {
    if episode.pose.len() < 5 {
        sample_of_push(index, episode).into_iter().collect()
    } else {
        segment_samples(index, episode, noise)
    }
}

/// Load above which the gripper pushes, N: one fifth of the 90th percentile of the load.
fn load_threshold(episode: &Prepared) -> f64 {
    let mut loads: Vec<f64> =
        episode.wrench.iter().filter(|w| w.t >= episode.contact).map(|w| magnitude(w.reading)).collect();
    loads.sort_by(f64::total_cmp);
    // The maximum may be an impact, and the median may be zero where the gripper idles most of the time.
    loads.get(loads.len() * 9 / 10).map_or(f64::INFINITY, |load| 0.2 * load)
}

fn magnitude([x, y, _]: [f64; 3]) -> f64 {
    x.hypot(y)
}

/// Samples of a continuous log: means over segments in which the object is pushed and moves throughout. Dry
/// friction is not proportional to speed, so a mean over motion and rest would mix two different wrenches.
fn segment_samples(index: usize, episode: &Prepared, noise: &Noise) -> Vec<WrenchSample> {
    let threshold = load_threshold(episode);
    let (motion, curve) = (episode.motion(noise), Curve::new(episode));
    let is_driven = |m: &Motion| m.t >= episode.contact && is_moving(m) && load(episode, m.t) > threshold;
    motion
        .chunk_by(|a, b| is_driven(a) == is_driven(b) && b.t - a.t < MAX_POSE_GAP_S)
        .filter(|run| is_driven(&run[0]))
        .flat_map(divide)
        .filter_map(|piece| sample(index, (episode, &curve), piece))
        .collect()
}

/// Whether the object moves: its twist is significant against the uncertainty of the smoother.
pub(crate) fn is_moving(m: &Motion) -> bool {
    let signal: f64 = (0..3).map(|k| m.twist[k] * m.twist[k] / m.cov[k][1][1].max(1e-18)).sum();
    signal > 25.0
}

/// Mean load around a time, N; zero without readings.
fn load(episode: &Prepared, t: f64) -> f64 {
    let near = between(episode, t - LOAD_HALF_WIDTH_S, t + LOAD_HALF_WIDTH_S);
    magnitude(mean(near.iter().map(|w| w.reading)))
}

/// Wrench samples between two times, s.
pub(crate) fn between(episode: &Prepared, start: f64, end: f64) -> &[trundle_record::WrenchSample] {
    let first = episode.wrench.partition_point(|w| w.t < start);
    let last = episode.wrench.partition_point(|w| w.t <= end);
    &episode.wrench[first..last]
}

fn mean(values: impl ExactSizeIterator<Item = [f64; 3]>) -> [f64; 3] {
    let n = values.len().max(1) as f64;
    values.fold([0.0; 3], |sum, v| [0, 1, 2].map(|k| sum[k] + v[k] / n))
}

/// A run without its ends, divided evenly into segments of at most [`MAX_SEGMENT_S`].
fn divide(run: &[Motion]) -> Vec<&[Motion]> {
    let (start, end) = (run[0].t + SEGMENT_EDGE_S, run[run.len() - 1].t - SEGMENT_EDGE_S);
    if end - start < MIN_SEGMENT_S {
        return vec![];
    }
    let count = ((end - start) / MAX_SEGMENT_S).ceil();
    let cut = |k: f64| run.partition_point(|m| m.t < start + k / count * (end - start));
    (0..count as usize).map(|k| &run[cut(k as f64)..cut(k as f64 + 1.0)]).collect()
}

fn sample(index: usize, (episode, curve): (&Prepared, &Curve), piece: &[Motion]) -> Option<WrenchSample> {
    let (start, end) = (piece.first()?.t, piece.last()?.t);
    if between(episode, start, end).is_empty() || end <= start {
        return None;
    }
    let t = (start + end) / 2.0;
    let (frame, reading) = (curve.frame(t).0, curve.mean(start, end).reading);
    Some(WrenchSample {
        episode: index,
        t,
        pose: mean(piece.iter().map(|m| m.pose)),
        twist: mean(piece.iter().map(|m| m.twist)),
        reading,
        frame,
        clock: curve.clock_at_grasp(t, frame),
    })
}

/// Sample of a push with poses known only before and after it: the mean twist over the push and the mean
/// wrench. The reading frame moves with the object along the straight line between the two poses.
fn sample_of_push(index: usize, episode: &Prepared) -> Option<WrenchSample> {
    let (first, last) = (episode.pose.first()?, episode.pose.last()?);
    let threshold = load_threshold(episode);
    let pushing: Vec<_> = episode
        .wrench
        .iter()
        .filter(|w| w.t >= episode.contact && magnitude(w.reading) > threshold)
        .collect();
    let (begin, end) = (pushing.first()?.t, pushing.last()?.t);
    let duration = end - begin;
    if pushing.len() < 5 || duration <= 0.0 {
        return None;
    }
    let change = [0, 1, 2].map(|k| last.pose[k] - first.pose[k]);
    let at = |t: f64| {
        let share = ((t - begin) / duration).clamp(0.0, 1.0);
        [0, 1, 2].map(|k| first.pose[k] + share * change[k])
    };
    let pose = at((begin + end) / 2.0);
    let n = pushing.len() as f64;
    let mut wrench = [0.0; 3];
    for sample in &pushing {
        // The frame was computed from the first pose. Move it with the object to the time of the sample.
        let frame = relative(compose(first.pose, sample.frame), at(sample.t));
        let on_object = transport(sample.reading, frame);
        for k in 0..3 {
            wrench[k] += on_object[k] / n;
        }
    }
    let clock = Curve::new(episode).clock_at_grasp((begin + end) / 2.0, [0.0; 3]);
    let twist = change.map(|c| c / duration);
    Some(WrenchSample {
        episode: index,
        t: (begin + end) / 2.0,
        pose,
        twist,
        reading: wrench,
        frame: [0.0; 3],
        clock,
    })
}

/// World pose of `inner`, which is given in the frame `outer`.
fn compose(outer: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = outer[2].sin_cos();
    [
        outer[0] + cos * inner[0] - sin * inner[1],
        outer[1] + sin * inner[0] + cos * inner[1],
        outer[2] + inner[2],
    ]
}

/// A world pose in the frame `from`.
fn relative(pose: [f64; 3], from: [f64; 3]) -> [f64; 3] {
    let d = to_body([pose[0] - from[0], pose[1] - from[1], 0.0], from[2]);
    [d[0], d[1], pose[2] - from[2]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_record::{Counts, PoseSample, WrenchSample as WrenchReading};

    /// A push along x at 5 mm/s with 0.7 N for two of every four seconds, with pauses between.
    fn stop_and_go() -> Prepared {
        let is_driven = |t: f64| (t / 4.0).fract() < 0.5;
        let poses = (0..1200).map(|k| {
            let t = f64::from(k) * 0.02;
            let x = 0.01 * ((t / 4.0).floor() + (2.0 * (t / 4.0).fract()).min(1.0));
            // A fixed pattern of a few micrometres represents the noise of the tracker.
            let jitter = 1e-6 * f64::from((k * 7919) % 11 - 5);
            PoseSample { t, pose: [x + jitter, jitter, 1e-2 * jitter] }
        });
        let wrench = (0..2400).map(|k| {
            let t = f64::from(k) * 0.01;
            let force = if is_driven(t) { 0.7 } else { 0.0 };
            WrenchReading { t, reading: [force, 0.0, 0.0], frame: [-0.05, 0.0, 0.0], ..Default::default() }
        });
        Prepared {
            ordinal: 0,
            name: "log".to_owned(),
            wrench: wrench.collect(),
            pose: poses.collect(),
            contact: 0.0,
            tare_sd: [0.0; 3],
            at_rest: false,
            counts: Counts::default(),
            ..Default::default()
        }
    }

    #[test]
    fn samples_cover_only_motion() {
        let noise = Noise { pose: [4e-6; 3], force: 1e-3, torque: 1e-5, time: 0.0, stated: true };
        let samples = wrench_samples(&stop_and_go(), &noise);
        // Six pushes of two seconds, two samples each.
        assert_eq!(samples.len(), 12);
        for sample in &samples {
            let within = (sample.t / 4.0).fract() * 4.0;
            assert!((0.5..1.5).contains(&within), "{within}");
            assert!((sample.twist[0] - 5e-3).abs() < 2e-4, "{:?}", sample.twist);
            assert!((sample.reading[0] - 0.7).abs() < 1e-9, "{:?}", sample.reading);
        }
    }

    #[test]
    fn relative_undoes_compose() {
        let (outer, inner) = ([1.0, -2.0, 0.7], [0.3, 0.1, -0.2]);
        for (a, b) in relative(compose(outer, inner), outer).iter().zip(inner) {
            assert!((a - b).abs() < 1e-12);
        }
    }
}
