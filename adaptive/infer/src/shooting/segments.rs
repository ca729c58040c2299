//! Division of recordings into segments that are simulated from a known state.

use crate::curve::Curve;
use crate::track::cut_into_steps;
use crate::{InferError, StateVector, Transition};
use trundle_model::{Clock, State};
use trundle_record::{MIN_POSES_FOR_MOTION, Motion, Noise, PoseSample, Prepared};

/// Division of a recording into segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// Eq. 8: intervals of `stride` pose samples, each from the smoothed state at its start to the pose and
    /// the smoothed twist at its end.
    Steps {
        /// Number of pose samples per interval, at least 1.
        stride: usize,
    },
    /// Eq. 9: a whole episode, of which only the last pose is compared.
    Final,
    /// Multiple shooting: successive windows in which every pose is compared.
    Windows {
        /// Length of a window, s.
        length: f64,
    },
}

/// A step of a simulation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input {
    /// Mean reading, reading axes.
    pub reading: [f64; 3],
    /// Pose of the reading frame in the object frame.
    pub frame: [f64; 3],
    pub clock: Clock,
    pub dt: f64,
}

/// A measured state, and the number of inputs before it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observed {
    pub after: usize,
    pub state: StateVector,
}

/// A part of an episode that is simulated from a known state.
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    /// Index of the episode.
    pub episode: usize,
    /// Start time, s.
    pub t: f64,
    pub start: State<f64>,
    pub inputs: Vec<Input>,
    pub observed: Vec<Observed>,
}

/// Segments of the episode `index`, and its smoothed motion.
pub(crate) fn of_episode(
    index: usize,
    episode: &Prepared,
    noise: &Noise,
    how: Cut,
) -> Result<(Vec<Segment>, Vec<Motion>), InferError> {
    if episode.wrench.len() < 2 {
        return Err(no_data(episode, "fewer than two wrench samples are left"));
    }
    let motion = episode.motion(noise);
    if motion.is_empty() && !(how == Cut::Final && episode.at_rest) {
        let reason =
            format!("fewer than {MIN_POSES_FOR_MOTION} poses are left; a velocity cannot be estimated");
        return Err(no_data(episode, &reason));
    }
    let first = first_pose(episode);
    let divider = Divider { index, episode, motion: &motion, curve: Curve::new(episode) };
    let ends = divider.ends(first, how);
    if ends.len() < 2 {
        return Err(no_data(episode, "no pose is left after contact"));
    }
    let segments = ends.windows(2).map(|pair| divider.segment(pair[0], pair[1], first, how)).collect();
    Ok((segments, motion))
}

fn no_data(episode: &Prepared, reason: &str) -> InferError {
    InferError::NoData {
        recording: episode.name.clone(),
        reason: reason.to_owned(),
        remedy: "leave the episode out, or record more of it".to_owned(),
    }
}

/// Index of the first simulated pose: the last pose before contact if the object is at rest, otherwise the
/// first one.
fn first_pose(episode: &Prepared) -> usize {
    let before = episode.pose.iter().rposition(|p| p.t <= episode.contact);
    if episode.at_rest { before.unwrap_or(0) } else { 0 }
}

struct Divider<'a> {
    index: usize,
    episode: &'a Prepared,
    motion: &'a [Motion],
    curve: Curve,
}

impl Divider<'_> {
    /// Indices of the poses at which segments start and end.
    fn ends(&self, first: usize, how: Cut) -> Vec<usize> {
        let poses = &self.episode.pose;
        let last = poses.len().saturating_sub(1);
        match how {
            Cut::Final if first < last => vec![first, last],
            Cut::Final => vec![],
            Cut::Steps { stride } => (first..=last).step_by(stride.max(1)).collect(),
            Cut::Windows { length } => {
                let mut ends = vec![first.min(last)];
                while let Some(&from) = ends.last().filter(|&&from| from < last) {
                    let within = poses.partition_point(|p| p.t <= poses[from].t + length + 1e-9);
                    ends.push(within.saturating_sub(1).max(from + 1));
                }
                ends
            }
        }
    }

    fn segment(&self, from: usize, to: usize, first: usize, how: Cut) -> Segment {
        let poses = &self.episode.pose;
        let (mut inputs, mut observed) = (vec![], vec![]);
        for (k, pair) in poses[from..=to].windows(2).enumerate() {
            self.push_inputs(&pair[0], &pair[1], &mut inputs);
            if matches!(how, Cut::Windows { .. }) || from + k + 1 == to {
                observed.push(Observed { after: inputs.len(), state: self.observed_state(from + k + 1) });
            }
        }
        Segment { episode: self.index, t: poses[from].t, start: self.start(from, first), inputs, observed }
    }

    fn push_inputs(&self, from: &PoseSample, to: &PoseSample, inputs: &mut Vec<Input>) {
        let mut steps = vec![];
        cut_into_steps(from.t, to, &self.curve, self.curve.max_step(), &mut steps);
        inputs.extend(steps.into_iter().map(|s| Input {
            reading: s.reading,
            frame: s.frame,
            clock: s.clock,
            dt: s.dt,
        }));
    }

    /// State at a pose. If the episode starts at rest, it is the mean of the poses until contact.
    fn start(&self, at: usize, first: usize) -> State<f64> {
        if at == first && self.episode.at_rest {
            let resting = &self.episode.pose[..=first];
            let mean = |k: usize| resting.iter().map(|p| p.pose[k]).sum::<f64>() / resting.len() as f64;
            return State::at_rest([0, 1, 2].map(mean));
        }
        let m = &self.motion[at];
        State::moving(m.pose, m.twist)
    }

    /// Recorded pose and smoothed twist.
    fn observed_state(&self, at: usize) -> StateVector {
        let [vx, vy, spin] = self.motion.get(at).map_or([0.0; 3], |m| m.twist);
        let [x, y, theta] = self.episode.pose[at].pose;
        [x, y, theta, vx, vy, spin]
    }
}

/// Maximum step within a transition, s; the same as in [`crate::hold`].
const MAX_STEP_S: f64 = 0.005;

/// Segment of a transition. The wrench is constant in object axes.
pub(crate) fn of_transition(transition: &Transition) -> Segment {
    let steps = (transition.dt / MAX_STEP_S).ceil().max(1.0);
    let [x, y, theta, vx, vy, spin] = transition.before;
    let input = Input {
        reading: transition.wrench,
        frame: [0.0; 3],
        clock: Clock::since_contact(0.0),
        dt: transition.dt / steps,
    };
    let inputs = vec![input; steps as usize];
    let observed = vec![Observed { after: inputs.len(), state: transition.after }];
    Segment { episode: 0, t: 0.0, start: State::moving([x, y, theta], [vx, vy, spin]), inputs, observed }
}
