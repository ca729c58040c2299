//! An episode as intervals between poses, each with the motion that was seen: what a foreign simulator is held against.

use trundle_infer::{InferError, StateVector, Track};
use trundle_model::{Clock, State};
use trundle_record::{Motion, Noise, Prepared, WrenchSample};

/// Poses nearer to one another than this are passed over, s: a call of somebody's simulator is dear.
const CLOSEST: f64 = 0.0125;

/// A step of the simulator.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// Mean reading, reading axes.
    pub reading: [f64; 3],
    /// Pose of the reading's frame in the object frame.
    pub frame: [f64; 3],
    pub clock: Clock,
    pub dt: f64,
}

/// From one pose to the next.
#[derive(Clone, Debug)]
pub(crate) struct Interval {
    /// Begin, s.
    pub t: f64,
    pub span: f64,
    /// Smoothed states at both ends.
    pub from: StateVector,
    pub to: StateVector,
    /// The motion in the middle, from the smoothed one.
    pub middle: State<f64>,
    /// Its acceleration, world axes.
    pub accel: [f64; 3],
    /// Standard deviation of its twist.
    pub doubt: [f64; 3],
    /// Pose seen at the end.
    pub seen: [f64; 3],
    /// Variance of the mean reading over that of one sample.
    pub thinning: f64,
    pub pieces: Vec<Piece>,
}

impl Interval {
    /// When the laws are asked: the middle.
    pub fn clock(&self) -> Clock {
        let first = self.pieces[0].clock;
        let t = self.t + self.span / 2.0;
        Clock { t, dt: self.span, since_contact: first.since_contact + t - first.t, ..first }
    }
}

/// An episode.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    pub name: String,
    /// State at the first pose less the smoothed one, and its variance.
    pub start: (StateVector, StateVector),
    /// Variance of the tare error, reading axes.
    pub tare: [f64; 3],
    pub intervals: Vec<Interval>,
    pub recorded: Recorded,
}

impl Path {
    /// Cut an episode, from contact on where it rests before.
    ///
    /// # Errors
    /// When too few poses or wrench samples are left.
    pub fn new(episode: &Prepared, noise: &Noise) -> Result<Self, InferError> {
        let track = Track::new(episode, noise)?;
        let motion = episode.motion(noise);
        let at = |t: f64| nearest(&motion, t);
        let lacks = || InferError::NoData {
            recording: episode.name.clone(),
            reason: "too few poses are left to smooth a motion".to_owned(),
            remedy: "leave the episode out, or record more of it".to_owned(),
        };
        let first = at(track.start).ok_or_else(lacks)?;
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
        let (mut intervals, mut pieces) = (vec![], vec![]);
        let (mut t, mut begin, mut from) = (track.start, track.start, first);
        for step in &track.steps {
            pieces.push(Piece { reading: step.reading, frame: step.frame, clock: step.clock, dt: step.dt });
            t += step.dt;
            let (Some(seen), Some(to)) = (step.pose, at(t)) else { continue };
            let span = t - begin;
            if span < CLOSEST {
                continue;
            }
            let pieces = std::mem::take(&mut pieces);
            intervals.push(interval(
                begin,
                span,
                [from, to],
                seen,
                (step.thinning * step.dt / span).min(1.0),
                pieces,
            ));
            (begin, from) = (t, to);
        }
        if intervals.len() < 4 {
            return Err(lacks());
        }
        Ok(Self {
            name: episode.name.clone(),
            start: (start, variance),
            tare: track.tare,
            intervals,
            recorded: Recorded::new(episode),
        })
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
    seen: [f64; 3],
    thinning: f64,
    pieces: Vec<Piece>,
) -> Interval {
    let vector = |m: &Motion| [m.pose[0], m.pose[1], m.pose[2], m.twist[0], m.twist[1], m.twist[2]];
    let mean = |f: fn(&Motion, usize) -> f64| [0, 1, 2].map(|k| 0.5 * (f(a, k) + f(b, k)));
    Interval {
        t,
        span,
        from: vector(a),
        to: vector(b),
        middle: State::moving(mean(|m, k| m.pose[k]), mean(|m, k| m.twist[k])),
        accel: mean(|m, k| m.accel[k]),
        doubt: mean(|m, k| m.cov[k][1][1].max(0.0)).map(f64::sqrt),
        seen,
        thinning,
        pieces,
    }
}

/// The readings of an episode, linear between samples.
#[derive(Clone, Debug)]
pub(crate) struct Recorded(Vec<WrenchSample>);

impl Recorded {
    pub fn new(episode: &Prepared) -> Self {
        Self(episode.wrench.clone())
    }

    /// Mean reading over an interval, and the frame of the sample after its beginning.
    pub fn mean(&self, from: f64, to: f64) -> ([f64; 3], [f64; 3]) {
        // Sampled more finely than any recording's readings, to a part in 10⁴ of what they change by.
        const POINTS: usize = 4;
        let share = (to - from) / POINTS as f64;
        let points = (0..POINTS).map(|k| self.at(from + (k as f64 + 0.5) * share));
        let sum = points.fold([0.0; 3], |sum, p| [0, 1, 2].map(|k| sum[k] + p[k] / POINTS as f64));
        let after = self.0.partition_point(|s| s.t < from).min(self.0.len().saturating_sub(1));
        (sum, self.0.get(after).map_or([0.0; 3], |s| s.frame))
    }

    fn at(&self, t: f64) -> [f64; 3] {
        let after = self.0.partition_point(|s| s.t <= t);
        match (after.checked_sub(1).and_then(|k| self.0.get(k)), self.0.get(after)) {
            (Some(a), Some(b)) => {
                let share = (t - a.t) / (b.t - a.t);
                [0, 1, 2].map(|k| a.reading[k] + share * (b.reading[k] - a.reading[k]))
            }
            (Some(only), None) | (None, Some(only)) => only.reading,
            (None, None) => [0.0; 3],
        }
    }
}
