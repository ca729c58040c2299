//! An episode cut into the steps of a simulation.

use crate::InferError;
use trundle_model::Clock;
use trundle_record::{Motion, Noise, PoseSample, Prepared, WrenchSample};

/// Longest step of a fit, s: two a pose at 60 Hz; the integrator is of second order and halves its
/// steps where dry friction stops a body.
pub(crate) const LONGEST: f64 = 0.008;

/// Poses nearer to one another than this are left out of a fit, s: they add little but time.
const CLOSEST: f64 = 0.004;

/// How still an object at rest is, m/s and rad/s.
const STILL: f64 = 1e-4;

/// A step: the mean reading over it, and the pose seen at its end, if one was.
#[derive(Clone, Debug)]
pub struct Step {
    /// Duration, s.
    pub dt: f64,
    /// Mean reading over the step, reading axes, N, N, N·m.
    pub reading: [f64; 3],
    /// Pose of the reading frame in the object frame, m, m, rad.
    pub frame: [f64; 3],
    /// When.
    pub clock: Clock,
    /// Variance of the mean reading over that of one sample: sample spacing over `dt`.
    pub thinning: f64,
    /// Pose seen at the end.
    pub pose: Option<[f64; 3]>,
}

/// An episode as the filter and the sensitivities walk through it.
#[derive(Clone, Debug)]
pub struct Track {
    /// The episode's name.
    pub name: String,
    /// Time of the first step's beginning, s.
    pub start: f64,
    /// Pose there, and the variance of each coordinate.
    pub pose: ([f64; 3], [f64; 3]),
    /// Twist there, world axes, and its variance.
    pub twist: ([f64; 3], [f64; 3]),
    /// Variance of the tare error, reading axes.
    pub tare: [f64; 3],
    /// The steps.
    pub steps: Vec<Step>,
}

impl Track {
    /// Cut an episode. An object at rest is followed from the moment of contact on.
    ///
    /// # Errors
    /// When fewer than five poses or two wrench samples are left.
    pub fn new(episode: &Prepared, noise: &Noise) -> Result<Self, InferError> {
        Self::with_steps(episode, noise, LONGEST, CLOSEST)
    }

    /// The same in steps three times as long, for finding out where to search.
    ///
    /// # Errors
    /// As [`Track::new`].
    pub fn coarse(episode: &Prepared, noise: &Noise) -> Result<Self, InferError> {
        Self::with_steps(episode, noise, 3.0 * LONGEST, 3.0 * CLOSEST)
    }

    fn with_steps(episode: &Prepared, noise: &Noise, longest: f64, closest: f64) -> Result<Self, InferError> {
        let lacks = |reason: &str| InferError::NoData {
            recording: episode.name.clone(),
            reason: reason.to_owned(),
            remedy: "leave the episode out, or record more of it".to_owned(),
        };
        if episode.wrench.len() < 2 {
            return Err(lacks("fewer than two wrench samples are left"));
        }
        let poses = &episode.pose;
        let first =
            if episode.at_rest { poses.iter().rposition(|p| p.t <= episode.contact).unwrap_or(0) } else { 0 };
        if poses.len() < first + 5 {
            return Err(lacks("fewer than five poses are left from contact on"));
        }
        let (pose, twist) = start(episode, noise, first);
        let readings = Readings::new(&episode.wrench);
        let mut steps = Vec::new();
        let mut from = poses[first].t;
        for pose in &poses[first + 1..] {
            if pose.t - from > 0.99 * closest {
                cut(from, pose, &readings, episode.contact, longest, &mut steps);
                from = pose.t;
            }
        }
        let tare = crate::noise::tare_variance(episode);
        Ok(Self { name: episode.name.clone(), start: poses[first].t, pose, twist, tare, steps })
    }

    /// The poses `first + 1..end` of an episode, from a state known at the pose `first`.
    pub(crate) fn between(episode: &Prepared, first: usize, end: usize, known: &Motion) -> Self {
        let readings = Readings::new(&episode.wrench);
        let mut steps = Vec::new();
        for pair in episode.pose[first..end.max(first + 1)].windows(2) {
            cut(pair[0].t, &pair[1], &readings, episode.contact, LONGEST, &mut steps);
        }
        Self {
            name: episode.name.clone(),
            start: known.t,
            pose: (known.pose, [0, 1, 2].map(|k| known.cov[k][0][0])),
            twist: (known.twist, [0, 1, 2].map(|k| known.cov[k][1][1])),
            tare: crate::noise::tare_variance(episode),
            steps,
        }
    }

    /// The beginning, up to a time, s.
    pub(crate) fn until(&self, end: f64) -> Self {
        let mut t = self.start;
        let before = self.steps.iter().take_while(|step| {
            t += step.dt;
            t <= end
        });
        Self { steps: before.cloned().collect(), ..self.clone() }
    }

    /// Number of pose samples compared.
    pub fn observations(&self) -> usize {
        self.steps.iter().filter(|s| s.pose.is_some()).count()
    }
}

type Known = ([f64; 3], [f64; 3]);

/// Pose and twist with their variances where the track begins.
fn start(episode: &Prepared, noise: &Noise, first: usize) -> (Known, Known) {
    let variance = noise.pose.map(|s| s * s);
    if episode.at_rest {
        let seen = &episode.pose[..=first];
        let n = seen.len() as f64;
        let mean = [0, 1, 2].map(|k| seen.iter().map(|p| p.pose[k]).sum::<f64>() / n);
        return ((mean, variance.map(|v| v / n)), ([0.0; 3], [STILL * STILL; 3]));
    }
    let motion = episode.motion(noise);
    match motion.first() {
        Some(m) => ((m.pose, variance), (m.twist, [0, 1, 2].map(|k| 4.0 * m.cov[k][1][1]))),
        None => ((episode.pose[0].pose, variance), ([0.0; 3], [1.0; 3])),
    }
}

/// Cut the time between two poses into equal steps.
pub(crate) fn cut(
    from: f64,
    to: &PoseSample,
    readings: &Readings<'_>,
    contact: f64,
    longest: f64,
    steps: &mut Vec<Step>,
) {
    let pieces = ((to.t - from) / longest).ceil().max(1.0);
    let dt = (to.t - from) / pieces;
    for k in 0..pieces as usize {
        let begin = from + k as f64 * dt;
        let middle = begin + dt / 2.0;
        let (reading, frame, spacing) = readings.mean(begin, begin + dt);
        let pose = (k + 1 == pieces as usize).then_some(to.pose);
        let clock = Clock { since_contact: middle - contact };
        steps.push(Step { dt, reading, frame, clock, thinning: spacing / dt, pose });
    }
}

/// The wrench samples, interpolated linearly.
pub(crate) struct Readings<'a> {
    samples: &'a [WrenchSample],
}

impl<'a> Readings<'a> {
    pub(crate) fn new(samples: &'a [WrenchSample]) -> Self {
        Self { samples }
    }

    /// The reading at a time; before the first and after the last sample, that sample's.
    fn at(&self, t: f64, after: usize) -> [f64; 3] {
        let last = self.samples.len() - 1;
        if after == 0 {
            return self.samples[0].reading;
        }
        if after > last {
            return self.samples[last].reading;
        }
        let (a, b) = (&self.samples[after - 1], &self.samples[after]);
        let share = (t - a.t) / (b.t - a.t);
        [0, 1, 2].map(|k| a.reading[k] + share * (b.reading[k] - a.reading[k]))
    }

    /// Mean reading over an interval, the frame in its middle, and the spacing of samples, s.
    pub(crate) fn mean(&self, from: f64, to: f64) -> ([f64; 3], [f64; 3], f64) {
        let first = self.samples.partition_point(|s| s.t <= from);
        let end = self.samples.partition_point(|s| s.t < to).max(first);
        let mut integral = [0.0; 3];
        let (mut t, mut value) = (from, self.at(from, first));
        let inner = self.samples[first..end].iter().map(|s| (s.t, s.reading));
        for (next_t, next) in inner.chain([(to, self.at(to, end))]) {
            for k in 0..3 {
                integral[k] += (next_t - t) * (value[k] + next[k]) / 2.0;
            }
            (t, value) = (next_t, next);
        }
        let middle = self.samples.partition_point(|s| s.t <= (from + to) / 2.0).saturating_sub(1);
        let (low, high) = (first.saturating_sub(1), end.min(self.samples.len() - 1));
        let spacing = if high > low {
            (self.samples[high].t - self.samples[low].t) / (high - low) as f64
        } else {
            to - from
        };
        (integral.map(|i| i / (to - from)), self.samples[middle].frame, spacing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Vec<WrenchSample> {
        (0..6)
            .map(|k| WrenchSample { t: k as f64 * 0.1, reading: [k as f64, 0.0, 0.0], frame: [0.0; 3] })
            .collect()
    }

    #[test]
    fn the_mean_of_a_ramp_is_its_middle() {
        let samples = ramp();
        let readings = Readings::new(&samples);
        for (from, to) in [(0.0, 0.5), (0.03, 0.07), (0.15, 0.45), (0.2, 0.3)] {
            let (mean, _, spacing) = readings.mean(from, to);
            assert!((mean[0] - 5.0 * (from + to)).abs() < 1e-12, "{from} {to} {mean:?}");
            assert!((spacing - 0.1).abs() < 1e-12);
        }
    }

    #[test]
    fn readings_are_held_beyond_their_ends() {
        let samples = ramp();
        let readings = Readings::new(&samples);
        assert!((readings.mean(-0.2, -0.1).0[0]).abs() < 1e-12);
        assert!((readings.mean(0.6, 0.7).0[0] - 5.0).abs() < 1e-12);
    }
}
