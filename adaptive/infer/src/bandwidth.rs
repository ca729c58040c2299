//! Frequency up to which poses determine the force that accelerates an object. Required and recorded wrenches
//! are compared below it.
//!
//! White noise of variance σ² in poses T seconds apart has the spectrum σ² T, and its second derivative has
//! ω⁴ σ² T. Below ω₀, with the filter 1/(1 + (ω/ω₀)⁶) of [`trundle_record::low_pass`], this integrates to the
//! variance
//!
//! ```text
//! (1/π) ∫ ω⁴ σ² T / (1 + (ω/ω₀)⁶)² dω = σ² T ω₀⁵ / 18
//! ```
//! At the bandwidth, the mass times the root of this variance equals the noise of a wrench sample. Below it,
//! the error of the true model is that of the wrench sensor at any rate of the tracker. Above it, the noise
//! of the tracker dominates. The smoother removes only parts of the acceleration that are smaller than its
//! noise, hence above the same bound.

use std::f64::consts::TAU;
use trundle_model::{Clock, Plant};
use trundle_record::{Noise, Prepared, mean_pose_noise};

/// Minimum noise of a wrench sample as a share of the recorded wrench (root mean square): the accuracy of a
/// good force-torque sensor. It applies to commands, whose noise is zero.
const WRENCH_ACCURACY: f64 = 0.01;

/// Bandwidth over some episodes, Hz, for the axes that move; at most half the rate of the poses. `None`
/// without motion.
///
/// For several `plants` it is the lowest of theirs.
pub(crate) fn force_bandwidth(
    plants: &[&Plant<f64>],
    dof: [bool; 3],
    episodes: &[Prepared],
    noise: &Noise,
) -> Option<f64> {
    let spacing = spacing(episodes)?;
    let (force, torque) = wrench_noise(episodes, noise);
    let pose = mean_pose_noise(episodes.iter(), noise);
    let one = |plant: &&Plant<f64>| {
        let rigid = plant.rigid(Clock::since_contact(0.0));
        let inertia = [rigid.mass, rigid.mass, rigid.inertia];
        (0..3).filter(|&k| dof[k]).map(move |k| {
            let unit = inertia[k] * pose[k];
            let tolerated = if k < 2 { force } else { torque };
            (18.0 * tolerated * tolerated / (unit * unit * spacing)).powf(0.2) / TAU
        })
    };
    let lowest = plants.iter().flat_map(one).fold(0.5 / spacing, f64::min);
    (lowest.is_finite() && lowest > 0.0).then_some(lowest)
}

/// Mean interval between poses, s.
pub(crate) fn spacing(episodes: &[Prepared]) -> Option<f64> {
    let span = |episode: &Prepared| Some(episode.pose.last()?.t - episode.pose.first()?.t);
    let time: f64 = episodes.iter().filter_map(span).sum();
    let intervals: usize = episodes.iter().map(|episode| episode.pose.len().saturating_sub(1)).sum();
    (time > 0.0 && intervals > 0).then(|| time / intervals as f64)
}

/// Noise of a wrench sample about the object's origin, N and N·m, at least [`WRENCH_ACCURACY`] times the
/// recorded wrench.
fn wrench_noise(episodes: &[Prepared], noise: &Noise) -> (f64, f64) {
    let (mut force, mut torque, mut arm, mut count) = (0.0, 0.0, 0.0, 0.0);
    for sample in episodes.iter().flat_map(|e| e.wrench.iter().filter(|w| w.t >= e.contact)) {
        let [x, y, turn] = sample.on_object();
        force += x * x + y * y;
        torque += turn * turn;
        arm += sample.frame[0].powi(2) + sample.frame[1].powi(2);
        count += 1.0;
    }
    let rms = |sum: f64| (sum / f64::max(count, 1.0)).sqrt();
    let of_torque = noise.torque.hypot(rms(arm) * noise.force);
    (noise.force.max(WRENCH_ACCURACY * rms(force)), of_torque.max(WRENCH_ACCURACY * rms(torque)))
}
