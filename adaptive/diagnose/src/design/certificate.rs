//! Certificates of indistinguishability: two models whose predictions of a recording differ by less than the
//! noise.

use crate::thresholds::MAX_TIE_DIFFERENCE_NATS;
use serde::Serialize;
use trundle_infer::{
    Comparison, Fit, InferError, Innovation, Likelihood, MotionLikelihood, WrenchLikelihood,
};

/// Differences of two fitted models on a recording.
#[derive(Clone, Debug, Serialize)]
pub struct Certificate {
    /// Names of the two models.
    pub models: [String; 2],
    /// Maximum distance of the simulated positions over all training episodes, m; `None` if wrenches are compared.
    pub position: Option<f64>,
    /// Maximum difference of the simulated headings, rad.
    pub heading: Option<f64>,
    /// Maximum difference of the predicted forces, N; `None` if motions are compared.
    pub force: Option<f64>,
    /// Maximum difference of the predicted torques, N·m.
    pub torque: Option<f64>,
    /// Maximum difference in standard deviations. For simulated poses, the standard deviation includes the noise of
    /// wrench, tare and tracker; for wrenches, it is their scatter.
    pub sigmas: f64,
    /// Episode with that difference.
    pub episode: String,
    /// Time of that difference on the clock of the table, s.
    pub t: f64,
    /// Log likelihood of the first model minus that of the second, nats.
    pub log_likelihood_difference: f64,
    /// Whether the recording cannot distinguish the models.
    pub same: bool,
    /// Summary in words.
    pub statement: String,
}

/// Difference below which two trajectories are equal within noise, standard deviations.
const MAX_DIFFERENCE_SD: f64 = 1.0;

/// Compares the predictions of two fitted models on the training episodes: open-loop simulations, or the required
/// wrenches if the recording is quasi-static.
///
/// # Errors
/// If a fit does not belong to the recording.
pub fn certificate(
    comparison: &Comparison,
    names: [&str; 2],
    fits: [&Fit; 2],
) -> Result<Certificate, InferError> {
    let found = match comparison {
        Comparison::Motion(motion) => of_motion(motion, fits)?,
        Comparison::Wrench(wrench) => of_wrench(wrench, fits)?,
    };
    Ok(conclude(found, names, fits[1].cost - fits[0].cost))
}

/// A certificate without differences.
fn empty() -> Certificate {
    Certificate {
        models: [String::new(), String::new()],
        position: None,
        heading: None,
        force: None,
        torque: None,
        sigmas: 0.0,
        episode: String::new(),
        t: 0.0,
        log_likelihood_difference: 0.0,
        same: false,
        statement: String::new(),
    }
}

/// Factor on the tracker's noise at which poses no longer correct the filter. Its predictions are then open-loop
/// simulations, and their covariance is due to the noise of the other instruments.
pub(crate) const OPEN_LOOP_NOISE_FACTOR: f64 = 1e4;

fn of_motion(motion: &MotionLikelihood, fits: [&Fit; 2]) -> Result<Certificate, InferError> {
    // Use the same noise for both models, so that only their laws differ.
    let channels = fits[0].channels;
    let open_loop = motion.with_channels(channels.scaled(OPEN_LOOP_NOISE_FACTOR, 1.0));
    let simulated = |fit: &Fit| {
        let all = open_loop.innovations(&fit.model, &fit.values)?;
        Ok::<_, InferError>(all.unwrap_or_default())
    };
    let (first, second) = (simulated(fits[0])?, simulated(fits[1])?);
    let mut found = Certificate { position: Some(0.0), heading: Some(0.0), ..empty() };
    if first.len() != second.len() || first.is_empty() {
        found.sigmas = f64::INFINITY;
    }
    for ((track, a), b) in motion.tracks().iter().zip(&first).zip(&second) {
        for (a, b) in a.iter().zip(b) {
            let pose_difference = [0, 1, 2].map(|k| a.error[k] - b.error[k]);
            found.position = max_of(found.position, pose_difference[0].hypot(pose_difference[1]));
            found.heading = max_of(found.heading, pose_difference[2].abs());
            let sigmas = in_standard_deviations(pose_difference, a, channels.pose, fits[0].model.dof);
            if sigmas > found.sigmas {
                (found.sigmas, found.t) = (sigmas, a.t);
                found.episode.clone_from(&track.name);
            }
        }
    }
    Ok(found)
}

/// An episode simulated by two models: at each time, both poses and the standard deviation of a pose due to the
/// noise of the instruments.
pub(crate) struct SimulatedPair {
    pub episode: String,
    pub samples: Vec<(f64, [[f64; 3]; 2], [f64; 3])>,
}

/// The certificate of two models from their simulations; `costs` are their negative log likelihoods.
pub(crate) fn certificate_from_simulations(
    names: [&str; 2],
    costs: [f64; 2],
    simulated: &[SimulatedPair],
    dof: [bool; 3],
) -> Certificate {
    let mut found = Certificate { position: Some(0.0), heading: Some(0.0), ..empty() };
    for one in simulated {
        for (t, [a, b], sd) in &one.samples {
            let pose_difference = [0, 1, 2].map(|k| a[k] - b[k]);
            found.position = max_of(found.position, pose_difference[0].hypot(pose_difference[1]));
            found.heading = max_of(found.heading, pose_difference[2].abs());
            let moving = (0..3).filter(|&k| dof[k] && sd[k] > 0.0);
            let sigmas = moving.map(|k| pose_difference[k].abs() / sd[k]).fold(0.0, f64::max);
            if sigmas > found.sigmas {
                (found.sigmas, found.t) = (sigmas, *t);
                found.episode.clone_from(&one.episode);
            }
        }
    }
    conclude(found, names, costs[1] - costs[0])
}

fn conclude(found: Certificate, names: [&str; 2], difference: f64) -> Certificate {
    let same = difference.abs() < MAX_TIE_DIFFERENCE_NATS && found.sigmas < MAX_DIFFERENCE_SD;
    let statement = statement_of(names, &found, difference, same);
    Certificate {
        models: names.map(str::to_owned),
        log_likelihood_difference: difference,
        same,
        statement,
        ..found
    }
}

fn max_of(current: Option<f64>, value: f64) -> Option<f64> {
    current.map(|current| current.max(value))
}

/// The largest coordinate of a pose difference, in standard deviations of a simulated pose.
fn in_standard_deviations(pose_difference: [f64; 3], of: &Innovation, pose: [f64; 3], dof: [bool; 3]) -> f64 {
    let sigmas = |k: usize| {
        let tracker = pose[k] * pose[k];
        let simulated =
            (of.covariance[(k, k)] - OPEN_LOOP_NOISE_FACTOR * OPEN_LOOP_NOISE_FACTOR * tracker).max(0.0);
        pose_difference[k].abs() / (simulated + tracker).sqrt()
    };
    (0..3).filter(|&k| dof[k]).map(sigmas).fold(0.0, f64::max)
}

fn of_wrench(wrench: &WrenchLikelihood, fits: [&Fit; 2]) -> Result<Certificate, InferError> {
    let plants = [fits[0].model.plant(&fits[0].values)?, fits[1].model.plant(&fits[1].values)?];
    let [scatter, _, torque_scatter] = fits[0].channels.reading;
    let names: Vec<String> = wrench.split().into_iter().map(|(name, _)| name).collect();
    let mut found = Certificate { force: Some(0.0), torque: Some(0.0), ..empty() };
    for sample in wrench.samples() {
        let [a, b] = [sample.residual(&plants[0]), sample.residual(&plants[1])];
        let (force, torque) = ((a[0] - b[0]).hypot(a[1] - b[1]), (a[2] - b[2]).abs());
        found.force = max_of(found.force, force);
        found.torque = max_of(found.torque, torque);
        let sigmas = (force / scatter.max(1e-12)).max(torque / torque_scatter.max(1e-12));
        if sigmas > found.sigmas {
            (found.sigmas, found.t) = (sigmas, sample.t);
            found.episode = names.get(sample.episode).cloned().unwrap_or_default();
        }
    }
    Ok(found)
}

fn statement_of([first, second]: [&str; 2], found: &Certificate, difference: f64, same: bool) -> String {
    let what = match (found.position, found.heading, found.force, found.torque) {
        (Some(position), Some(heading), _, _) => {
            format!(
                "their simulated trajectories differ by at most {:.1} mm and {:.2}°",
                1e3 * position,
                heading.to_degrees()
            )
        }
        (_, _, Some(force), Some(torque)) => {
            format!("their predicted wrenches differ by at most {force:.2} N and {torque:.3} N·m")
        }
        _ => "their predictions cannot be compared".to_owned(),
    };
    let verdict = match (same, difference.abs() < MAX_TIE_DIFFERENCE_NATS) {
        (true, _) => "indistinguishable within noise",
        (false, true) => "equally likely, but their motions differ",
        (false, false) => "distinguishable",
    };
    format!(
        "{first} and {second}: {verdict}. Over all training episodes {what}, {:.2} standard deviations of the noise \
         (largest in {} at {:.2} s). Their log likelihoods differ by {:.1} nats.",
        found.sigmas,
        found.episode,
        found.t,
        difference.abs()
    )
}
