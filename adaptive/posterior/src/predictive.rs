//! Posterior predictive draws of a repetition of a recorded push.
//!
//! Each draw simulates the episode in open loop under a resampled wrench. The tare error, the wrench noise,
//! the initial pose and the tracker noise are drawn anew.

use crate::{Posterior, PosteriorError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use trundle_infer::{Channels, InferError, open_loop};
use trundle_model::Model;
use trundle_record::{PoseSample, Prepared, WrenchSample};

/// Simulated poses of an episode, one list for each draw: world, m, m, rad, at the times of the recorded
/// poses.
pub type Predicted = Vec<Vec<[f64; 3]>>;

/// Posterior predictive draws of an episode, one for each entry of `values` (values of all slots). `stream`
/// selects the random numbers of the episode.
///
/// # Errors
/// When an entry of `values` has the wrong length.
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
        let mut poses = open_loop(&plant, &resampled(episode, channels, model.dof, &mut rng));
        for pose in &mut poses {
            *pose = noisy(*pose, channels.pose, model.dof, &mut rng);
        }
        Ok(poses)
    };
    values.par_iter().enumerate().map(one).collect()
}

impl Posterior {
    /// Values of all slots at `draws` evenly spaced draws of each chain, one chain after the other. At least one draw of each
    /// chain is selected, and at most all.
    pub fn spaced_values(&self, draws: usize) -> Vec<Vec<f64>> {
        let kept = self.values.first().map_or(0, Vec::len);
        let draws = draws.clamp(1, kept.max(1));
        let spaced = |chain: &Vec<Vec<f64>>| {
            let pick = |k: usize| chain[k * kept / draws].clone();
            (0..draws).map(pick).collect::<Vec<_>>()
        };
        self.values.iter().flat_map(spaced).collect()
    }
}

/// The episode with resampled wrench errors and initial pose.
fn resampled(episode: &Prepared, channels: &Channels, dof: [bool; 3], rng: &mut ChaCha8Rng) -> Prepared {
    let tare = noisy([0.0; 3], episode.tare_sd, dof, rng);
    let wrench = episode.wrench.iter().map(|sample| {
        let reading = noisy(sample.reading, channels.reading, dof, rng);
        WrenchSample { reading: [0, 1, 2].map(|k| reading[k] - tare[k]), ..sample.clone() }
    });
    let wrench = wrench.collect();
    let from = if episode.at_rest { last_resting_pose(episode) } else { 0 };
    let before = episode.pose.get(..=from).unwrap_or_default();
    let n = before.len().max(1) as f64;
    let mean = [0, 1, 2].map(|k| before.iter().map(|p| p.pose[k]).sum::<f64>() / n);
    let start = noisy(mean, channels.pose.map(|s| s / n.sqrt()), dof, rng);
    let pose = episode.pose.iter().enumerate();
    let pose =
        pose.map(|(k, p)| if k == 0 { PoseSample { t: p.t, pose: start } } else { p.clone() }).collect();
    Prepared { wrench, pose, ..episode.clone() }
}

/// Index of the last pose before contact.
fn last_resting_pose(episode: &Prepared) -> usize {
    episode.pose.iter().rposition(|p| p.t <= episode.contact).unwrap_or(0)
}

fn noisy(value: [f64; 3], sd: [f64; 3], dof: [bool; 3], rng: &mut ChaCha8Rng) -> [f64; 3] {
    let draws: [f64; 3] = [0; 3].map(|_| rng.sample(StandardNormal));
    [0, 1, 2].map(|k| if dof[k] { value[k] + sd[k] * draws[k] } else { value[k] })
}
