//! What would be recorded of a push if a model were true: without noise.

use super::bench::{Bench, Instruments, extent};
use super::choose::SORTING_RATE;
use super::push::Push;
use trundle_infer::{InferError, open_loop};
use trundle_model::Plant;
use trundle_record::{Counts, PoseSample, Prepared, WrenchSample};

/// Time in which the object rests before contact, s.
const REST: f64 = 0.4;

/// The push as an episode, `ordinal` of its recording, before it is known how the object moves. The command is what the
/// sensor reads: a robot that controls force controls its reading. So both models see the same wrench, and all that differs
/// is the motion.
pub(super) fn commanded(push: &Push, instruments: &Instruments, ordinal: usize) -> Prepared {
    Prepared {
        ordinal,
        name: format!("push_{ordinal}"),
        wrench: readings(push, instruments.wrench_rate),
        pose: still(push.start, push.duration, instruments.pose_rate),
        contact: REST,
        tare_sd: instruments.tare,
        at_rest: true,
        counts: Counts::default(),
        ..Default::default()
    }
}

/// The same with the object moving.
pub(super) fn moved(episode: Prepared, poses: &[[f64; 3]]) -> Prepared {
    let pairs = episode.pose.iter().zip(poses);
    let pose = pairs.map(|(still, &pose)| PoseSample { pose, ..*still }).collect();
    // Nothing is known of the motion that a still object was asked for.
    Prepared { pose, motion_cache: Default::default(), ..episode }
}

/// The push as an episode of a plant.
pub(super) fn imagine(
    plant: &Plant<f64>,
    push: &Push,
    instruments: &Instruments,
    ordinal: usize,
) -> Prepared {
    let episode = commanded(push, instruments, ordinal);
    let poses = open_loop(plant, &episode);
    moved(episode, &poses)
}

fn readings(push: &Push, rate: f64) -> Vec<WrenchSample> {
    let (knots, frame) = (push.knots(), push.gripper());
    let sample = |t: f64| WrenchSample { t, reading: at(&knots, t - REST), frame, ..Default::default() };
    times(push.duration, rate).map(sample).collect()
}

fn still(pose: [f64; 3], duration: f64, rate: f64) -> Vec<PoseSample> {
    times(duration, rate).map(|t| PoseSample { t, pose }).collect()
}

fn times(duration: f64, rate: f64) -> impl Iterator<Item = f64> {
    let count = ((REST + duration) * rate).floor() as usize;
    (0..=count).map(move |k| k as f64 / rate)
}

/// The command at a time from contact on; nothing before.
fn at(knots: &[[f64; 4]], t: f64) -> [f64; 3] {
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

/// A push is made weaker at most so often until it keeps within its limits, each time by [`WEAKER`].
const ATTEMPTS: usize = 8;
const WEAKER: f64 = 0.65;

/// Poses of an imagined episode.
pub(crate) type Moves<'m> = dyn Fn(&Prepared) -> Result<Vec<[f64; 3]>, InferError> + 'm;

/// The push as strong as the limits on motion allow under all of some models; `None` where no strength does.
pub(super) fn within_limits(
    models: &[&Moves<'_>],
    push: &Push,
    bench: &Bench,
) -> Result<Option<Push>, InferError> {
    let instruments = bench.instruments.thinned(SORTING_RATE);
    let allowed = [bench.limits.distance, bench.limits.speed, bench.limits.spin];
    let keeps = |push: &Push| -> Result<bool, InferError> {
        let episode = commanded(push, &instruments, bench.recorded);
        for moves in models {
            let sizes = extent(&moves(&episode)?, instruments.pose_rate);
            if sizes.iter().zip(allowed).any(|(size, most)| *size > most || size.is_nan()) {
                return Ok(false);
            }
        }
        Ok(true)
    };
    let mut push = *push;
    for _ in 0..ATTEMPTS {
        if keeps(&push)? {
            return Ok(Some(push));
        }
        push = push.scaled(WEAKER);
    }
    Ok(None)
}
