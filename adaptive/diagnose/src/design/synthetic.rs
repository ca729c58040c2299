//! Noise-free synthetic recordings of a push.

use super::push::Push;
use super::setup::{Instruments, Setup, extent};
use trundle_infer::{InferError, open_loop};
use trundle_model::Plant;
use trundle_record::{Counts, PoseSample, Prepared, WrenchSample};

/// Rate of poses for ranking pushes, Hz: six of the filter's longest steps between poses.
pub(super) const RANKING_RATE_HZ: f64 = 21.0;

/// Time at rest before contact, s.
const REST_S: f64 = 0.4;

/// The push as an episode in which the object does not move; `ordinal` is its place in the recording. The command
/// equals the sensor's reading, because a force-controlled robot controls its reading. Both models thus see the
/// same wrench and differ in the motion only.
pub(super) fn resting_episode(push: &Push, instruments: &Instruments, ordinal: usize) -> Prepared {
    Prepared {
        ordinal,
        name: format!("push_{ordinal}"),
        wrench: readings(push, instruments.wrench_rate),
        pose: resting_poses(push.start, push.duration, instruments.pose_rate),
        contact: REST_S,
        tare_sd: instruments.tare,
        at_rest: true,
        counts: Counts::default(),
        ..Default::default()
    }
}

/// The episode with simulated poses.
pub(super) fn with_poses(episode: Prepared, poses: &[[f64; 3]]) -> Prepared {
    let pairs = episode.pose.iter().zip(poses);
    let pose = pairs.map(|(resting, &pose)| PoseSample { pose, ..*resting }).collect();
    // The smoothed motion of the resting object must not be reused.
    Prepared { pose, motion_cache: Default::default(), ..episode }
}

/// Simulates a push with a plant.
pub(super) fn simulate_push(
    plant: &Plant<f64>,
    push: &Push,
    instruments: &Instruments,
    ordinal: usize,
) -> Prepared {
    let episode = resting_episode(push, instruments, ordinal);
    let poses = open_loop(plant, &episode);
    with_poses(episode, &poses)
}

fn readings(push: &Push, rate: f64) -> Vec<WrenchSample> {
    let (knots, frame) = (push.knots(), push.gripper());
    let sample =
        |t: f64| WrenchSample { t, reading: command_at(&knots, t - REST_S), frame, ..Default::default() };
    times(push.duration, rate).map(sample).collect()
}

fn resting_poses(pose: [f64; 3], duration: f64, rate: f64) -> Vec<PoseSample> {
    times(duration, rate).map(|t| PoseSample { t, pose }).collect()
}

fn times(duration: f64, rate: f64) -> impl Iterator<Item = f64> {
    let count = ((REST_S + duration) * rate).floor() as usize;
    (0..=count).map(move |k| k as f64 / rate)
}

/// Command at a time since contact, by linear interpolation; zero before contact.
fn command_at(knots: &[[f64; 4]], t: f64) -> [f64; 3] {
    let later = knots.partition_point(|knot| knot[0] <= t);
    let value = |knot: &[f64; 4]| [knot[1], knot[2], knot[3]];
    match (later.checked_sub(1).and_then(|k| knots.get(k)), knots.get(later)) {
        (Some(a), Some(b)) => {
            let share = (t - a[0]) / (b[0] - a[0]);
            [1, 2, 3].map(|k| a[k] + share * (b[k] - a[k]))
        }
        (Some(knot), None) => value(knot),
        (None, _) => [0.0; 3],
    }
}

/// Maximum number of reductions of a push to respect the limits, and the factor of each.
const MAX_REDUCTIONS: usize = 8;
const REDUCTION: f64 = 0.65;

/// Predicts the poses of a synthetic episode.
pub(crate) type PosePredictor<'m> = dyn Fn(&Prepared) -> Result<Vec<[f64; 3]>, InferError> + 'm;

/// Scales a push down until the motions predicted by all models respect the limits; `None` if no scale does.
pub(super) fn scaled_to_limits(
    predictors: &[&PosePredictor<'_>],
    push: &Push,
    setup: &Setup,
) -> Result<Option<Push>, InferError> {
    let instruments = setup.instruments.thinned(RANKING_RATE_HZ);
    let allowed = [setup.limits.distance, setup.limits.speed, setup.limits.spin];
    let is_within_limits = |push: &Push| -> Result<bool, InferError> {
        let episode = resting_episode(push, &instruments, setup.recorded_episodes);
        for predict in predictors {
            let sizes = extent(&predict(&episode)?, instruments.pose_rate);
            if sizes.iter().zip(allowed).any(|(size, limit)| *size > limit || size.is_nan()) {
                return Ok(false);
            }
        }
        Ok(true)
    };
    let mut push = *push;
    for _ in 0..MAX_REDUCTIONS {
        if is_within_limits(&push)? {
            return Ok(Some(push));
        }
        push = push.scaled(REDUCTION);
    }
    Ok(None)
}
