//! Measurement noise, as stated by the recording or estimated from the data.

use serde::Serialize;

use crate::episode::{Episode, WrenchStream};
use crate::metadata::{Contact, Metadata};
use crate::recording::Recording;

use super::outlier::resolution;
use super::sampling::{median_step, quantile};
use super::transform::wrapped;

/// Measurement noise, one standard deviation each.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Noise {
    /// Of an object pose: x and y in m, theta in rad.
    pub pose: [f64; 3],
    /// Of each force axis, N.
    pub force: f64,
    /// Of the torque about the vertical, N m.
    pub torque: f64,
    /// Of the time stamps, s.
    pub time: f64,
    /// Whether the recording states the noise. Otherwise it is estimated from the data.
    pub stated: bool,
}

/// Pose noise if there are too few poses for an estimate: typical of a good motion-capture system.
const DEFAULT_POSE_SD: [f64; 3] = [5e-4, 5e-4, 2e-3];
/// Wrench noise relative to the largest reading, if there are too few readings for an estimate.
const DEFAULT_RELATIVE_WRENCH_SD: f64 = 0.01;
/// Lower bound of all standard deviations, m, rad, N or N m. Likelihoods need a finite width.
const MIN_SD: f64 = 1e-6;
/// Uncertainty of the position of a point contact, m. It turns force noise into torque noise.
const POINT_CONTACT_SD_M: f64 = 1e-3;
/// Quantile of the absolute residuals from which the noise is estimated. It is high because trackers flicker between a few
/// values, but excludes spikes and sudden changes of the motion.
const RESIDUAL_QUANTILE: f64 = 0.8;
/// The same quantile of |x| for a standard normal variable x.
const NORMAL_QUANTILE: f64 = 1.281_551_565_544_600_4;
/// Minimum number of residuals for an estimate.
const MIN_RESIDUALS: usize = 20;

/// The noise that `recording` states, or else an estimate.
pub(crate) fn stated_or_estimated(recording: &Recording) -> Noise {
    match &recording.metadata.noise {
        Some(stated) => Noise {
            pose: stated.pose,
            force: stated.force,
            torque: stated.torque.unwrap_or_else(|| torque_noise(recording, stated.force)),
            time: stated.time,
            stated: true,
        },
        None => estimated(recording),
    }
}

/// Estimate of the noise from the data, whether or not it is stated.
pub(crate) fn estimated(recording: &Recording) -> Noise {
    let force = wrench_noise(recording, &[0, 1]);
    Noise {
        pose: estimated_pose(recording),
        force,
        torque: torque_noise(recording, force),
        time: 0.0,
        stated: false,
    }
}

/// Estimate of the noise of the object's poses from the data, m, m, rad.
pub(crate) fn estimated_pose(recording: &Recording) -> [f64; 3] {
    [0, 1, 2].map(|k| pose_noise(recording, k))
}

fn torque_noise(recording: &Recording, force: f64) -> f64 {
    let measured = recording.episodes.iter().any(|episode| episode.columns.contains_key("torque_z"));
    match (&recording.metadata.wrench.contact, measured) {
        (Contact::Point, false) => force * POINT_CONTACT_SD_M,
        _ => wrench_noise(recording, &[5]),
    }
}

/// The training episodes. Held-out episodes are not used for estimates.
fn training(recording: &Recording) -> impl Iterator<Item = &Episode> {
    recording.episodes.iter().filter(|episode| !recording.metadata.is_held_out(&episode.name))
}

fn pose_noise(recording: &Recording, k: usize) -> f64 {
    let mut residuals = vec![];
    let mut finest = f64::INFINITY;
    for object in training(recording).filter_map(Episode::object) {
        let (t, pose) = without_repeats(&object.t, &object.value);
        finest = finest.min(resolution(&pose, k));
        let z: Vec<f64> = pose.iter().map(|p| p[k]).collect();
        residuals.extend(interpolation_residuals(&t, &z, k == 2));
    }
    let rounding = if finest.is_finite() { finest / 12f64.sqrt() } else { 0.0 };
    robust_sd(residuals).map_or(DEFAULT_POSE_SD[k], |sd| sd.max(rounding).max(MIN_SD))
}

fn wrench_noise(recording: &Recording, axes: &[usize]) -> f64 {
    let streams: Vec<(String, WrenchStream)> =
        training(recording).filter_map(|e| Some((e.name.clone(), e.wrench()?))).collect();
    let largest = streams
        .iter()
        .flat_map(|(_, s)| s.value.iter().flat_map(|v| axes.iter().map(|&k| v[k].abs())))
        .fold(0.0, f64::max);
    let estimate = sd_before_contact(&recording.metadata, &streams, axes)
        .or_else(|| robust_sd(streams.iter().flat_map(|(_, s)| differences(s, axes)).collect()));
    estimate.unwrap_or(DEFAULT_RELATIVE_WRENCH_SD * largest).max(MIN_SD)
}

/// Pooled standard deviation in the intervals without contact; `None` if there are too few samples.
fn sd_before_contact(metadata: &Metadata, streams: &[(String, WrenchStream)], axes: &[usize]) -> Option<f64> {
    let (mut sum, mut freedom) = (0.0, 0.0);
    for (name, stream) in streams {
        let Some([start, end]) = metadata.wrench.precontact(name) else { continue };
        let inside = (0..stream.t.len()).filter(|&i| stream.t[i] >= start && stream.t[i] <= end);
        let rows: Vec<usize> = inside.filter(|&i| stream.value[i].iter().all(|v| v.is_finite())).collect();
        for &k in axes.iter().filter(|&&k| stream.present[k]) {
            let mean = rows.iter().map(|&i| stream.value[i][k]).sum::<f64>() / rows.len().max(1) as f64;
            sum += rows.iter().map(|&i| (stream.value[i][k] - mean).powi(2)).sum::<f64>();
            freedom += rows.len().saturating_sub(1) as f64;
        }
    }
    (freedom >= MIN_RESIDUALS as f64).then(|| (sum / freedom).sqrt())
}

fn differences(stream: &WrenchStream, axes: &[usize]) -> Vec<f64> {
    let measured = axes.iter().filter(|&&k| stream.present[k]);
    let column = |&k: &usize| stream.value.iter().map(|v| v[k]).collect::<Vec<f64>>();
    measured.flat_map(|k| interpolation_residuals(&stream.t, &column(k), false)).collect()
}

/// Residual of each sample from the cubic through its two neighbours on either side, scaled to the noise of one sample. It
/// is zero for a smooth motion and has the variance of the noise for white noise. Windows across a gap are skipped.
fn interpolation_residuals(t: &[f64], z: &[f64], circular: bool) -> Vec<f64> {
    let Some(step) = median_step(t) else { return vec![] };
    let smooth_enough = |i: &usize| t[i + 2] - t[i - 2] < 8.0 * step;
    let residual = |i: usize| {
        let near = [i - 2, i - 1, i + 1, i + 2];
        let offset = |j: usize| if circular { wrapped(z[j] - z[i]) } else { z[j] - z[i] };
        let weights = near.map(|j| {
            near.iter().filter(|&&m| m != j).map(|&m| (t[i] - t[m]) / (t[j] - t[m])).product::<f64>()
        });
        let interpolated: f64 = near.iter().zip(weights).map(|(&j, w)| w * offset(j)).sum();
        interpolated / (1.0 + weights.iter().map(|w| w * w).sum::<f64>()).sqrt()
    };
    (2..t.len().saturating_sub(2)).filter(smooth_enough).map(residual).collect()
}

/// Poses without exact repeats, which would bias the estimate of the noise towards zero.
fn without_repeats(t: &[f64], pose: &[[f64; 3]]) -> (Vec<f64>, Vec<[f64; 3]>) {
    let fresh = (0..t.len()).filter(|&i| i == 0 || pose[i] != pose[i - 1]);
    fresh.map(|i| (t[i], pose[i])).unzip()
}

fn robust_sd(residuals: Vec<f64>) -> Option<f64> {
    if residuals.len() < MIN_RESIDUALS {
        return None;
    }
    quantile(residuals.into_iter().map(f64::abs), RESIDUAL_QUANTILE).map(|size| size / NORMAL_QUANTILE)
}
