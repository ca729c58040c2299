//! An episode as intervals between poses, each with the smoothed motion. A black-box simulator is compared with
//! it.

use trundle_infer::{Channels, InferError, Readings, StateVector, Step, Track};
use trundle_model::{Clock, State};
use trundle_record::{Motion, Noise, Prepared};

/// Minimum spacing of poses, s. Closer poses are skipped, because calls of a simulator are expensive.
const MIN_POSE_SPACING_S: f64 = 0.0125;

/// The interval from one pose to the next.
#[derive(Clone, Debug)]
pub(crate) struct Interval {
    /// Time of its beginning, s.
    pub t: f64,
    pub span: f64,
    /// Smoothed states at both ends.
    pub from: StateVector,
    pub to: StateVector,
    /// Smoothed motion at the midpoint.
    pub middle: State<f64>,
    /// Standard deviation of the twist at the midpoint.
    pub twist_sd: [f64; 3],
    /// Measured pose at the end.
    pub measured: [f64; 3],
    /// Variance of the mean reading divided by that of one sample.
    pub thinning: f64,
    /// Simulation steps of the interval.
    pub steps: Vec<Step>,
}

impl Interval {
    /// Variances of the measured pose: of the tracker, and of the error of its time stamp.
    pub fn pose_variance(&self, channels: &Channels) -> [f64; 3] {
        let timing = self.steps.last().map_or([0.0; 3], |step| step.timing_variance);
        [0, 1, 2].map(|k| channels.pose[k].powi(2) + timing[k])
    }

    /// Clock of the midpoint, at which laws are evaluated.
    pub fn clock(&self) -> Clock {
        let first = self.steps[0].clock;
        let t = self.t + self.span / 2.0;
        Clock { t, dt: self.span, since_contact: first.since_contact + t - first.t, ..first }
    }
}

/// An episode as a sequence of intervals.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    pub name: String,
    /// Difference between the filtered and the smoothed state at the first pose, and its variance.
    pub start: (StateVector, StateVector),
    /// Variance of the tare error, reading axes.
    pub tare: [f64; 3],
    pub intervals: Vec<Interval>,
    pub readings: Readings,
}

impl Path {
    /// Divides an episode into intervals. An episode that is at rest before contact starts at contact.
    ///
    /// # Errors
    /// If too few poses or wrench samples remain.
    pub fn new(episode: &Prepared, noise: &Noise) -> Result<Self, InferError> {
        let track = Track::new(episode, noise)?;
        let motion = episode.motion(noise);
        let at = |t: f64| nearest(&motion, t);
        let too_short = || InferError::NoData {
            recording: episode.name.clone(),
            reason: "too few poses remain to smooth the motion".to_owned(),
            remedy: "remove the episode, or record a longer one".to_owned(),
        };
        let first = at(track.start).ok_or_else(too_short)?;
        let (pose, twist) = (track.pose, track.twist);
        let start = [
            pose.0[0] - first.pose[0],
            pose.0[1] - first.pose[1],
            pose.0[2] - first.pose[2],
            twist.0[0] - first.twist[0],
            twist.0[1] - first.twist[1],
            twist.0[2] - first.twist[2],
        ];
        let variance = [pose.1[0], pose.1[1], pose.1[2], twist.1[0], twist.1[1], twist.1[2]];
        let (mut intervals, mut steps) = (vec![], vec![]);
        let (mut t, mut begin, mut from) = (track.start, track.start, first);
        for step in &track.steps {
            steps.push(step.clone());
            t += step.dt;
            let (Some(measured), Some(to)) = (step.pose, at(t)) else { continue };
            let span = t - begin;
            if span < MIN_POSE_SPACING_S {
                continue;
            }
            let steps = std::mem::take(&mut steps);
            intervals.push(interval(
                begin,
                span,
                [from, to],
                measured,
                (step.thinning * step.dt / span).min(1.0),
                steps,
            ));
            (begin, from) = (t, to);
        }
        if intervals.len() < 4 {
            return Err(too_short());
        }
        Ok(Self {
            name: episode.name.clone(),
            start: (start, variance),
            tare: track.tare,
            intervals,
            readings: Readings::of(&track),
        })
    }

    /// Number of intervals that begin before a time since contact, s.
    pub fn intervals_before(&self, since_contact: f64) -> usize {
        self.intervals.partition_point(|i| i.steps[0].clock.since_contact < since_contact)
    }
}

fn nearest(motion: &[Motion], t: f64) -> Option<&Motion> {
    let k = motion.partition_point(|m| m.t < t - 1e-6);
    motion.get(k.min(motion.len().checked_sub(1)?))
}

fn interval(
    t: f64,
    span: f64,
    [a, b]: [&Motion; 2],
    measured: [f64; 3],
    thinning: f64,
    steps: Vec<Step>,
) -> Interval {
    let vector = |m: &Motion| [m.pose[0], m.pose[1], m.pose[2], m.twist[0], m.twist[1], m.twist[2]];
    let mean = |f: fn(&Motion, usize) -> f64| [0, 1, 2].map(|k| 0.5 * (f(a, k) + f(b, k)));
    Interval {
        t,
        span,
        from: vector(a),
        to: vector(b),
        middle: State::moving(mean(|m, k| m.pose[k]), mean(|m, k| m.twist[k])),
        twist_sd: mean(|m, k| m.cov[k][1][1].max(0.0)).map(f64::sqrt),
        measured,
        thinning,
        steps,
    }
}
