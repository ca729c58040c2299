//! How noisy the instruments are, where the recording does not say.

use serde::Serialize;

use crate::episode::{Episode, WrenchStream};
use crate::metadata::{Contact, Metadata};
use crate::recording::Recording;

use super::outlier::resolution;
use super::sampling::{median_step, quantile};
use super::transform::wrapped;

/// One standard deviation of what the instruments add.
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
    /// Whether the recording states it; otherwise it is estimated from the data.
    pub stated: bool,
}

/// Pose noise where there are too few poses to estimate one: that of a good motion-capture system's object frame.
const USUAL_POSE: [f64; 3] = [5e-4, 5e-4, 2e-3];
/// Wrench noise where there are too few readings to estimate one, relative to the largest reading.
const USUAL_WRENCH: f64 = 0.01;
/// Nothing is measured better than this (m, rad, N, N m): likelihoods need a width.
const FLOOR: f64 = 1e-6;
/// A point contact is known to about a millimetre, so its moment to the force noise times this, m.
const POINT_ARM: f64 = 1e-3;
/// Quantile of the residuals taken for the noise, and that of |x| of a standard normal variable: high, because
/// trackers flicker between a few states, but below what spikes and corners of the motion reach.
const QUANTILE: (f64, f64) = (0.8, 1.281_551_565_544_600_4);
/// Fewer residuals than this are no estimate.
const FEWEST: usize = 20;

/// The noise that `recording` states or shows.
pub(crate) fn of(recording: &Recording) -> Noise {
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

/// The noise that the data show, whatever is stated.
pub(crate) fn estimated(recording: &Recording) -> Noise {
    let force = wrench_noise(recording, &[0, 1]);
    Noise {
        pose: seen_pose(recording),
        force,
        torque: torque_noise(recording, force),
        time: 0.0,
        stated: false,
    }
}

/// The noise that the object's poses show, m, m, rad, whatever is stated.
pub(crate) fn seen_pose(recording: &Recording) -> [f64; 3] {
    [0, 1, 2].map(|k| pose_noise(recording, k))
}

fn torque_noise(recording: &Recording, force: f64) -> f64 {
    let measured = recording.episodes.iter().any(|episode| episode.columns.contains_key("torque_z"));
    match (&recording.metadata.wrench.contact, measured) {
        (Contact::Point, false) => force * POINT_ARM,
        _ => wrench_noise(recording, &[5]),
    }
}

/// The episodes that may be looked at.
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
    robust_sd(residuals).map_or(USUAL_POSE[k], |sd| sd.max(rounding).max(FLOOR))
}

fn wrench_noise(recording: &Recording, axes: &[usize]) -> f64 {
    let streams: Vec<(String, WrenchStream)> =
        training(recording).filter_map(|e| Some((e.name.clone(), e.wrench()?))).collect();
    let largest = streams
        .iter()
        .flat_map(|(_, s)| s.value.iter().flat_map(|v| axes.iter().map(|&k| v[k].abs())))
        .fold(0.0, f64::max);
    let shown = sd_before_contact(&recording.metadata, &streams, axes)
        .or_else(|| robust_sd(streams.iter().flat_map(|(_, s)| differences(s, axes)).collect()));
    shown.unwrap_or(USUAL_WRENCH * largest).max(FLOOR)
}

/// Pooled standard deviation within the intervals without contact.
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
    (freedom >= FEWEST as f64).then(|| (sum / freedom).sqrt())
}

fn differences(stream: &WrenchStream, axes: &[usize]) -> Vec<f64> {
    let measured = axes.iter().filter(|&&k| stream.present[k]);
    let column = |&k: &usize| stream.value.iter().map(|v| v[k]).collect::<Vec<f64>>();
    measured.flat_map(|k| interpolation_residuals(&stream.t, &column(k), false)).collect()
}

/// What each sample differs by from the cubic through its two neighbours on either side, scaled to the noise of
/// one sample. A smooth motion leaves nothing; white noise leaves itself. Windows across a gap are left out.
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

/// Held poses would look noiseless.
fn without_repeats(t: &[f64], pose: &[[f64; 3]]) -> (Vec<f64>, Vec<[f64; 3]>) {
    let fresh = (0..t.len()).filter(|&i| i == 0 || pose[i] != pose[i - 1]);
    fresh.map(|i| (t[i], pose[i])).unzip()
}

fn robust_sd(residuals: Vec<f64>) -> Option<f64> {
    if residuals.len() < FEWEST {
        return None;
    }
    quantile(residuals.into_iter().map(f64::abs), QUANTILE.0).map(|size| size / QUANTILE.1)
}
