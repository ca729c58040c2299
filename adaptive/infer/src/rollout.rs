//! Simulations of a recording, as DIAGNOSIS.md defines them: open loop, and one window ahead.

use crate::beginning::beginning;
use crate::curve::Curve;
use crate::filter::{Innovation, filter, push};
use crate::track::{Step, cut};
use crate::{Channels, InferError, Track};
use std::sync::Arc;
use trundle_model::{MAX_INNER_STATES, Model, Plant, State};
use trundle_record::{Motion, Noise, Prepared};

/// Poses at the times of the recorded poses, simulated from the first one, at rest or with its velocity, under the
/// recorded wrench, which is held in the simulated object's frame. Shape: one pose a sample,
/// world, m, m, rad. Where a law's own state may start in several ways, the first second after contact tells.
pub fn open_loop(plant: &Plant<f64>, episode: &Prepared) -> Vec<[f64; 3]> {
    simulated(plant, episode, beginning(plant, episode), f64::INFINITY)
}

/// The same up to a time, s, with the laws' own states starting from `inner`.
pub(crate) fn simulated(
    plant: &Plant<f64>,
    episode: &Prepared,
    inner: [f64; MAX_INNER_STATES],
    until: f64,
) -> Vec<[f64; 3]> {
    let Some(first) = episode.pose.first() else { return vec![] };
    let mut state = State::moving(first.pose, episode.first_twist).with_inner(inner);
    let mut poses = vec![first.pose];
    if episode.wrench.is_empty() {
        return vec![first.pose; episode.pose.len()];
    }
    let curve = Curve::new(episode);
    let mut steps: Vec<Step> = Vec::new();
    for pair in episode.pose.windows(2).take_while(|pair| pair[1].t <= until) {
        steps.clear();
        cut(pair[0].t, &pair[1], &curve, curve.longest(), &mut steps);
        for step in &steps {
            push(plant, &mut state, &[0.0; 3], step, &curve);
        }
        poses.push(state.pose);
    }
    poses
}

/// Length of a prediction window, s.
const WINDOW: f64 = 1.0;

/// One window's predictions: what was seen less what was predicted, with the prediction's density.
pub struct Window {
    /// Predictions at each pose sample of the window; their errors are seen less predicted.
    pub samples: Vec<Innovation>,
}

/// Predictions over successive windows of one second from contact on, each from a state estimated
/// with samples up to its start only. `None` in place of a window that is not finite.
///
/// # Errors
/// When `values` has the wrong length.
pub fn windows(
    model: &Model,
    values: &[f64],
    channels: &Channels,
    episode: &Prepared,
    noise: &Noise,
) -> Result<Vec<Option<Window>>, InferError> {
    let filter = filter(model, values, channels)?;
    if !model.inner().is_empty() {
        // The laws' own states are nowhere in a motion; a filter carries them. All else begins as without them, or models
        // with states would be judged by better beginnings than others.
        let track = Track::new(episode, noise)?;
        let known: Vec<Motion> = starts(episode, noise).into_iter().map(|(_, motion)| motion).collect();
        let windows = filter.ahead(&track, &known, WINDOW).unwrap_or_default();
        return Ok(windows.into_iter().map(|samples| samples.map(|samples| Window { samples })).collect());
    }
    let curve = Arc::new(Curve::with_noise(episode, noise));
    let found = starts(episode, noise).into_iter().map(|(index, motion)| {
        let end = motion.t + WINDOW;
        let count = episode.pose[index..].partition_point(|p| p.t <= end + 1e-9);
        let track = Track::between(episode, &curve, index, index + count, &motion);
        filter.predict_only(&track).map(|samples| Window { samples })
    });
    Ok(found.collect())
}

/// Where windows start: index of the pose sample, and the causal estimate there.
fn starts(episode: &Prepared, noise: &Noise) -> Vec<(usize, Motion)> {
    let Some(last) = episode.pose.last() else { return vec![] };
    let known = episode.filtered_motion(noise);
    let mut begin = episode.contact.max(episode.pose[0].t);
    let mut found = Vec::new();
    while begin + WINDOW <= last.t + 1e-9 {
        let index = episode.pose.partition_point(|p| p.t <= begin + 1e-9).saturating_sub(1);
        if let Some(motion) = known.get(index) {
            found.push((index, motion.clone()));
        }
        begin += WINDOW;
    }
    found
}
