//! Stretches of a slow manipulation in which the object is pushed and moves throughout, a sample each.

use crate::curve::Curve;
use crate::quasi::WrenchSample;
use trundle_model::{to_body, transport};
use trundle_record::{Motion, Noise, Prepared};

/// Longest stretch that makes one sample, s. The friction of a real floor changes from place to place, so that
/// what a model leaves over is alike within a second or so: shorter samples would be counted as independent.
const LONGEST: f64 = 1.0;

/// Shortest stretch that makes a sample, s.
pub(crate) const SHORTEST: f64 = 0.3;

/// Left out at the ends of a stretch, s: the smoother rounds off where a motion begins and ends.
pub(crate) const EDGE: f64 = 0.1;

/// Interval between poses that ends a stretch, s.
const GAP: f64 = 0.1;

/// Readings this near to a pose tell the load on it, s.
const NEAR: f64 = 0.05;

/// The stretches of one episode in which a wrench moves the object.
pub fn wrench_samples(episode: &Prepared, noise: &Noise) -> Vec<WrenchSample> {
    samples(0, episode, noise)
}

/// The same, of the episode with this index.
pub(crate) fn samples(index: usize, episode: &Prepared, noise: &Noise) -> Vec<WrenchSample> {
    if episode.pose.len() < 5 {
        whole_push(index, episode).into_iter().collect()
    } else {
        stretches(index, episode, noise)
    }
}

/// Load below which the gripper does not push: a fifth of what it pushes with at its hardest.
fn load_threshold(episode: &Prepared) -> f64 {
    let mut loads: Vec<f64> =
        episode.wrench.iter().filter(|w| w.t >= episode.contact).map(|w| size(w.reading)).collect();
    loads.sort_by(f64::total_cmp);
    // Not the largest, which may be a knock, nor the median: a gripper may stand idle most of the time.
    loads.get(loads.len() * 9 / 10).map_or(f64::INFINITY, |load| 0.2 * load)
}

fn size([x, y, _]: [f64; 3]) -> f64 {
    x.hypot(y)
}

/// A continuous log: means over stretches in which it is pushed and moves all the time. A mean over going and
/// stopping would mix two wrenches of a dry law, which are not in proportion to the speed.
fn stretches(index: usize, episode: &Prepared, noise: &Noise) -> Vec<WrenchSample> {
    let threshold = load_threshold(episode);
    let (motion, curve) = (episode.motion(noise), Curve::new(episode));
    let going = |m: &Motion| m.t >= episode.contact && moves(m) && load(episode, m.t) > threshold;
    motion
        .chunk_by(|a, b| going(a) == going(b) && b.t - a.t < GAP)
        .filter(|run| going(&run[0]))
        .flat_map(pieces)
        .filter_map(|piece| sample(index, (episode, &curve), piece))
        .collect()
}

/// Whether an object surely moves.
pub(crate) fn moves(m: &Motion) -> bool {
    let signal: f64 = (0..3).map(|k| m.twist[k] * m.twist[k] / m.cov[k][1][1].max(1e-18)).sum();
    signal > 25.0
}

/// Mean load around a time, N; none where nothing was read.
fn load(episode: &Prepared, t: f64) -> f64 {
    let near = between(episode, t - NEAR, t + NEAR);
    size(mean(near.iter().map(|w| w.reading)))
}

/// The readings from one time to another, s.
pub(crate) fn between(episode: &Prepared, start: f64, end: f64) -> &[trundle_record::WrenchSample] {
    let first = episode.wrench.partition_point(|w| w.t < start);
    let last = episode.wrench.partition_point(|w| w.t <= end);
    &episode.wrench[first..last]
}

fn mean(values: impl ExactSizeIterator<Item = [f64; 3]>) -> [f64; 3] {
    let n = values.len().max(1) as f64;
    values.fold([0.0; 3], |sum, v| [0, 1, 2].map(|k| sum[k] + v[k] / n))
}

/// A run without its ends, cut evenly.
fn pieces(run: &[Motion]) -> Vec<&[Motion]> {
    let (start, end) = (run[0].t + EDGE, run[run.len() - 1].t - EDGE);
    if end - start < SHORTEST {
        return vec![];
    }
    let count = ((end - start) / LONGEST).ceil();
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
        clock: curve.held(t, frame),
    })
}

/// A push of which only the poses before and after are known: the mean twist while it lasted, and
/// the mean wrench over it, its frame followed along the straight way between the two poses.
fn whole_push(index: usize, episode: &Prepared) -> Option<WrenchSample> {
    let (first, last) = (episode.pose.first()?, episode.pose.last()?);
    let threshold = load_threshold(episode);
    let pushing: Vec<_> =
        episode.wrench.iter().filter(|w| w.t >= episode.contact && size(w.reading) > threshold).collect();
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
        // The frame was found with the first pose; follow the object to where it is by now.
        let frame = relative(compose(first.pose, sample.frame), at(sample.t));
        let on_object = transport(sample.reading, frame);
        for k in 0..3 {
            wrench[k] += on_object[k] / n;
        }
    }
    let clock = Curve::new(episode).held((begin + end) / 2.0, [0.0; 3]);
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

/// Pose of `inner`, given in `outer`, in the world.
fn compose(outer: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = outer[2].sin_cos();
    [
        outer[0] + cos * inner[0] - sin * inner[1],
        outer[1] + sin * inner[0] + cos * inner[1],
        outer[2] + inner[2],
    ]
}

/// A world pose as seen from `from`.
fn relative(pose: [f64; 3], from: [f64; 3]) -> [f64; 3] {
    let d = to_body([pose[0] - from[0], pose[1] - from[1], 0.0], from[2]);
    [d[0], d[1], pose[2] - from[2]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_record::{Counts, PoseSample, WrenchSample as WrenchReading};

    /// Pushed along x at 5 mm/s with 0.7 N for two of every four seconds, idle in between.
    fn stop_and_go() -> Prepared {
        let going = |t: f64| (t / 4.0).fract() < 0.5;
        let poses = (0..1200).map(|k| {
            let t = f64::from(k) * 0.02;
            let x = 0.01 * ((t / 4.0).floor() + (2.0 * (t / 4.0).fract()).min(1.0));
            // A fixed pattern of a few micrometres stands for the tracker's noise.
            let jitter = 1e-6 * f64::from((k * 7919) % 11 - 5);
            PoseSample { t, pose: [x + jitter, jitter, 1e-2 * jitter] }
        });
        let wrench = (0..2400).map(|k| {
            let t = f64::from(k) * 0.01;
            let force = if going(t) { 0.7 } else { 0.0 };
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
    fn samples_are_of_motion_only() {
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
