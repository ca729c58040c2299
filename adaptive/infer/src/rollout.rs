//! Simulations of a recording: in open loop, and one window ahead.

use crate::curve::Curve;
use crate::filter::{Innovation, filter};
use crate::initial_state::initial_state;
use crate::simulation::simulate;
use crate::{Channels, InferError, Track};
use std::sync::Arc;
use trundle_model::{Model, Plant};
use trundle_record::{Motion, Noise, Prepared};

/// Simulated poses at the times of the recorded poses, world, m, m, rad. The simulation starts from the first
/// pose, at rest or with its velocity, under the recorded wrench, which is fixed in the frame of the
/// simulated object. Initial states of the laws with several possible starts are estimated from the first
/// second after contact.
pub fn open_loop(plant: &Plant<f64>, episode: &Prepared) -> Vec<[f64; 3]> {
    simulate(plant, episode, initial_state(plant, episode), f64::INFINITY)
}

/// Length of a prediction window, s.
pub const PREDICTION_WINDOW_S: f64 = 1.0;

/// Predictions over one window: the errors of the poses and the density of the predictions.
pub struct Window {
    /// Predictions at each pose of the window. Errors are measured minus predicted.
    pub samples: Vec<Innovation>,
}

/// Predictions over successive windows of one second from contact on. Each starts from a state estimated with
/// samples up to the start of the window only. A window that is not finite is `None`.
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
        // A measured motion does not contain the laws' own states, so a filter estimates them. All other
        // states start as for models without own states. The comparison between models is then fair.
        let track = Track::new(episode, noise)?;
        let known: Vec<Motion> =
            window_starts(episode, noise).into_iter().map(|(_, motion)| motion).collect();
        let windows = filter.predict_windows(&track, &known, PREDICTION_WINDOW_S).unwrap_or_default();
        return Ok(windows.into_iter().map(|samples| samples.map(|samples| Window { samples })).collect());
    }
    let (curve, timing) = (Arc::new(Curve::with_noise(episode, noise)), episode.timing_variances(noise));
    let found = window_starts(episode, noise).into_iter().map(|(index, motion)| {
        let end = motion.t + PREDICTION_WINDOW_S;
        let count = episode.pose[index..].partition_point(|p| p.t <= end + 1e-9);
        let track = Track::between(episode, &curve, index, index + count, &motion, &timing);
        filter.predict_only(&track).map(|samples| Window { samples })
    });
    Ok(found.collect())
}

/// Starts of the windows: index of the pose sample, and the causal estimate of the motion there.
fn window_starts(episode: &Prepared, noise: &Noise) -> Vec<(usize, Motion)> {
    let Some(last) = episode.pose.last() else { return vec![] };
    let known = episode.filtered_motion(noise);
    let mut begin = episode.contact.max(episode.pose[0].t);
    let mut found = Vec::new();
    while begin + PREDICTION_WINDOW_S <= last.t + 1e-9 {
        let index = episode.pose.partition_point(|p| p.t <= begin + 1e-9).saturating_sub(1);
        if let Some(motion) = known.get(index) {
            found.push((index, motion.clone()));
        }
        begin += PREDICTION_WINDOW_S;
    }
    found
}
