//! What the next recording of the same push would look like, if the draws are right.
//!
//! Of each draw the episode is simulated in open loop under a wrench that the recorded one may have
//! been: its tare error and its noise are drawn anew, as the start's and the tracker's noise are.

use crate::PosteriorError;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use trundle_infer::{Channels, InferError, open_loop};
use trundle_model::Model;
use trundle_record::{PoseSample, Prepared, WrenchSample};

/// Poses of an episode, one list a draw: world, m, m, rad, at the times of the recorded poses.
pub type Predicted = Vec<Vec<[f64; 3]>>;

/// Predictive draws of an episode for some values of all slots; `stream` tells episodes apart.
///
/// # Errors
/// When values have the wrong length.
pub fn predictive(
    model: &Model,
    values: &[Vec<f64>],
    channels: &Channels,
    episode: &Prepared,
    (seed, stream): (u64, u64),
) -> Result<Predicted, PosteriorError> {
    let one = |(k, values): (usize, &Vec<f64>)| {
        let plant = model.plant(values).map_err(InferError::from)?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream((stream << 32) + k as u64 + 1);
        let mut poses = open_loop(&plant, &other(episode, channels, model.dof, &mut rng));
        for pose in &mut poses {
            *pose = noisy(*pose, channels.pose, model.dof, &mut rng);
        }
        Ok(poses)
    };
    values.par_iter().enumerate().map(one).collect()
}

/// The episode as it may have been: the wrench without an error, the start without one.
fn other(episode: &Prepared, channels: &Channels, dof: [bool; 3], rng: &mut ChaCha8Rng) -> Prepared {
    let tare = noisy([0.0; 3], episode.tare_sd, dof, rng);
    let wrench = episode.wrench.iter().map(|sample| {
        let reading = noisy(sample.reading, channels.reading, dof, rng);
        WrenchSample { reading: [0, 1, 2].map(|k| reading[k] - tare[k]), ..sample.clone() }
    });
    let wrench = wrench.collect();
    let from = if episode.at_rest { rest(episode) } else { 0 };
    let before = episode.pose.get(..=from).unwrap_or_default();
    let n = before.len().max(1) as f64;
    let mean = [0, 1, 2].map(|k| before.iter().map(|p| p.pose[k]).sum::<f64>() / n);
    let start = noisy(mean, channels.pose.map(|s| s / n.sqrt()), dof, rng);
    let pose = episode.pose.iter().enumerate();
    let pose =
        pose.map(|(k, p)| if k == 0 { PoseSample { t: p.t, pose: start } } else { p.clone() }).collect();
    Prepared { wrench, pose, ..episode.clone() }
}

/// The last pose before contact.
fn rest(episode: &Prepared) -> usize {
    episode.pose.iter().rposition(|p| p.t <= episode.contact).unwrap_or(0)
}

fn noisy(value: [f64; 3], sd: [f64; 3], dof: [bool; 3], rng: &mut ChaCha8Rng) -> [f64; 3] {
    let draws: [f64; 3] = [0; 3].map(|_| rng.sample(StandardNormal));
    [0, 1, 2].map(|k| if dof[k] { value[k] + sd[k] * draws[k] } else { value[k] })
}
