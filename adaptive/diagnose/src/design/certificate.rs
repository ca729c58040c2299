//! The certificate of a tie: two models, the same trajectories within noise.

use crate::thresholds::MAX_TIE_DIFFERENCE_NATS;
use serde::Serialize;
use trundle_infer::{
    Comparison, Fit, InferError, Innovation, Likelihood, MotionLikelihood, WrenchLikelihood,
};

/// How alike two fitted models are on what was recorded.
#[derive(Clone, Debug, Serialize)]
pub struct Certificate {
    /// Names of the two models.
    pub models: [String; 2],
    /// Greatest distance of their simulated positions over all training episodes, m; none where wrenches are compared.
    pub position: Option<f64>,
    /// Greatest difference of their simulated headings, rad.
    pub heading: Option<f64>,
    /// Greatest difference of the forces that they need for the motion, N; none where motions are compared.
    pub force: Option<f64>,
    /// Greatest difference of the torques, N·m.
    pub torque: Option<f64>,
    /// The greatest difference in standard deviations: of a simulated pose, of what the noise of wrench, tare and
    /// tracker alone does to it; of a wrench, of its scatter.
    pub sigmas: f64,
    /// The episode in which that is, and when, s.
    pub episode: String,
    /// Its time, s, on the table's clock.
    pub t: f64,
    /// Log likelihood of the first less that of the second, nats.
    pub log_likelihood_difference: f64,
    /// Whether nothing that was recorded tells them apart.
    pub same: bool,
    /// All of it for a person.
    pub statement: String,
}

/// Difference below which two trajectories are the same, standard deviations.
const WITHIN: f64 = 1.0;

/// Compare what two fitted models say of the training episodes: their simulations from the recorded wrench, or, for
/// slow pushes, the wrenches that they need.
///
/// # Errors
/// When a fit is not one of a model on this recording.
pub fn certificate(
    comparison: &Comparison,
    names: [&str; 2],
    fits: [&Fit; 2],
) -> Result<Certificate, InferError> {
    let found = match comparison {
        Comparison::Motion(motion) => of_motion(motion, fits)?,
        Comparison::Wrench(wrench) => of_wrench(wrench, fits)?,
    };
    Ok(concluded(found, names, fits[1].cost - fits[0].cost))
}

/// Nothing differs yet.
fn blank() -> Certificate {
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

/// Factor on the tracker's noise under which poses correct nothing: what the filter predicts then is the simulation in
/// open loop, with what the instruments' noise makes of it.
pub(crate) const BLIND: f64 = 1e4;

fn of_motion(motion: &MotionLikelihood, fits: [&Fit; 2]) -> Result<Certificate, InferError> {
    // Both under the same noise, so that only the laws differ.
    let channels = fits[0].channels;
    let blind = motion.with_channels(channels.scaled(BLIND, 1.0));
    let simulated = |fit: &Fit| {
        let all = blind.innovations(&fit.model, &fit.values)?;
        Ok::<_, InferError>(all.unwrap_or_default())
    };
    let (first, second) = (simulated(fits[0])?, simulated(fits[1])?);
    let mut found = Certificate { position: Some(0.0), heading: Some(0.0), ..blank() };
    if first.len() != second.len() || first.is_empty() {
        found.sigmas = f64::INFINITY;
    }
    for ((track, a), b) in motion.tracks().iter().zip(&first).zip(&second) {
        for (a, b) in a.iter().zip(b) {
            let apart = [0, 1, 2].map(|k| a.error[k] - b.error[k]);
            found.position = larger(found.position, apart[0].hypot(apart[1]));
            found.heading = larger(found.heading, apart[2].abs());
            let sigmas = in_noise(apart, a, channels.pose, fits[0].model.dof);
            if sigmas > found.sigmas {
                (found.sigmas, found.t) = (sigmas, a.t);
                found.episode.clone_from(&track.name);
            }
        }
    }
    Ok(found)
}

/// An episode as two models simulate it: its name, and at some times both poses and the standard deviation of one that
/// the instruments' noise explains.
pub(crate) struct Simulated {
    pub episode: String,
    pub samples: Vec<(f64, [[f64; 3]; 2], [f64; 3])>,
}

/// The certificate of two models by their simulations; `costs` are their −log likelihoods.
pub(crate) fn of_simulations(
    names: [&str; 2],
    costs: [f64; 2],
    simulated: &[Simulated],
    dof: [bool; 3],
) -> Certificate {
    let mut found = Certificate { position: Some(0.0), heading: Some(0.0), ..blank() };
    for one in simulated {
        for (t, [a, b], sd) in &one.samples {
            let apart = [0, 1, 2].map(|k| a[k] - b[k]);
            found.position = larger(found.position, apart[0].hypot(apart[1]));
            found.heading = larger(found.heading, apart[2].abs());
            let moving = (0..3).filter(|&k| dof[k] && sd[k] > 0.0);
            let sigmas = moving.map(|k| apart[k].abs() / sd[k]).fold(0.0, f64::max);
            if sigmas > found.sigmas {
                (found.sigmas, found.t) = (sigmas, *t);
                found.episode.clone_from(&one.episode);
            }
        }
    }
    concluded(found, names, costs[1] - costs[0])
}

fn concluded(found: Certificate, names: [&str; 2], difference: f64) -> Certificate {
    let same = difference.abs() < MAX_TIE_DIFFERENCE_NATS && found.sigmas < WITHIN;
    let statement = stated(names, &found, difference, same);
    Certificate {
        models: names.map(str::to_owned),
        log_likelihood_difference: difference,
        same,
        statement,
        ..found
    }
}

fn larger(most: Option<f64>, value: f64) -> Option<f64> {
    most.map(|most| most.max(value))
}

/// A difference of poses in standard deviations of the simulated one, the largest over its coordinates.
fn in_noise(apart: [f64; 3], of: &Innovation, pose: [f64; 3], dof: [bool; 3]) -> f64 {
    let sigmas = |k: usize| {
        let seen = pose[k] * pose[k];
        let simulated = (of.covariance[(k, k)] - BLIND * BLIND * seen).max(0.0);
        apart[k].abs() / (simulated + seen).sqrt()
    };
    (0..3).filter(|&k| dof[k]).map(sigmas).fold(0.0, f64::max)
}

fn of_wrench(wrench: &WrenchLikelihood, fits: [&Fit; 2]) -> Result<Certificate, InferError> {
    let plants = [fits[0].model.plant(&fits[0].values)?, fits[1].model.plant(&fits[1].values)?];
    let [scatter, _, turning] = fits[0].channels.reading;
    let names: Vec<String> = wrench.split().into_iter().map(|(name, _)| name).collect();
    let mut found = Certificate { force: Some(0.0), torque: Some(0.0), ..blank() };
    for sample in wrench.samples() {
        let [a, b] = [sample.residual(&plants[0]), sample.residual(&plants[1])];
        let (force, torque) = ((a[0] - b[0]).hypot(a[1] - b[1]), (a[2] - b[2]).abs());
        found.force = larger(found.force, force);
        found.torque = larger(found.torque, torque);
        let sigmas = (force / scatter.max(1e-12)).max(torque / turning.max(1e-12));
        if sigmas > found.sigmas {
            (found.sigmas, found.t) = (sigmas, sample.t);
            found.episode = names.get(sample.episode).cloned().unwrap_or_default();
        }
    }
    Ok(found)
}

fn stated([first, second]: [&str; 2], found: &Certificate, difference: f64, same: bool) -> String {
    let what = match (found.position, found.heading, found.force, found.torque) {
        (Some(position), Some(heading), _, _) => {
            format!(
                "their simulated trajectories part by at most {:.1} mm and {:.2}°",
                1e3 * position,
                heading.to_degrees()
            )
        }
        (_, _, Some(force), Some(torque)) => {
            format!("the wrenches that they need differ by at most {force:.2} N and {torque:.3} N·m")
        }
        _ => "nothing of them can be compared".to_owned(),
    };
    let verdict = match (same, difference.abs() < MAX_TIE_DIFFERENCE_NATS) {
        (true, _) => "two models, the same motion within noise",
        (false, true) => "equally likely, though not the same motion",
        (false, false) => "not the same within noise",
    };
    format!(
        "{first} and {second}: {verdict}. Over all training episodes {what}, {:.2} of the noise's standard deviation \
         (worst in {}, at {:.2} s), and their log likelihoods differ by {:.1}.",
        found.sigmas,
        found.episode,
        found.t,
        difference.abs()
    )
}
