//! The lack-of-fit test for a fit outside of a diagnosis.

use crate::lack_of_fit::lack_of_fit;
use trundle_infer::{Comparison, Fit, InferError, Residual};
use trundle_record::Dataset;

/// Result of the lack-of-fit test on the training episodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitCheck {
    /// Whether the data reject the model.
    pub is_rejected: bool,
    /// Gain in log likelihood from a random-walk wrench in addition to the model, nats.
    pub gain_nats: f64,
    /// Root mean square of the smoothed residual force, N.
    pub residual_force_rms: f64,
    /// Root mean square of the smoothed residual torque about the object's origin, N·m.
    pub residual_torque_rms: f64,
}

/// Test a fit for lack of fit; `None` if the wrench is compared instead of the motion, for which there is no
/// test.
///
/// # Errors
/// If the fit's values do not belong to its model.
pub fn check_fit(data: &Dataset, comparison: &Comparison, fit: &Fit) -> Result<Option<FitCheck>, InferError> {
    let (Some(lack), Comparison::Motion(motion)) = (lack_of_fit(comparison, fit)?, comparison) else {
        return Ok(None);
    };
    let residuals = motion.with_channels(lack.channels).residuals(&fit.model, &fit.values)?;
    // The wrench is zero before contact.
    let contact = |k: usize| data.training.get(k).map_or(f64::NEG_INFINITY, |e| e.contact);
    let pushed: Vec<[f64; 3]> = residuals
        .iter()
        .flatten()
        .enumerate()
        .flat_map(|(k, episode)| episode.iter().filter(move |r: &&Residual| r.t >= contact(k)))
        .map(|r| r.wrench)
        .collect();
    let rms = |square: &dyn Fn(&[f64; 3]) -> f64| {
        (pushed.iter().map(square).sum::<f64>() / pushed.len().max(1) as f64).sqrt()
    };
    Ok(Some(FitCheck {
        is_rejected: lack.is_significant(comparison.observations()),
        gain_nats: lack.gain,
        residual_force_rms: rms(&|w| w[0] * w[0] + w[1] * w[1]),
        residual_torque_rms: rms(&|w| w[2] * w[2]),
    }))
}
