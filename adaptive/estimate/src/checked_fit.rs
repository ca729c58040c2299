//! A fit with its lack-of-fit test, and intervals that include model error.

use serde::Serialize;
use trundle_diagnose::{FitCheck, check_fit};
use trundle_infer::{Basis, Comparison, Fit, InferError, Likelihood};
use trundle_model::Model;
use trundle_record::Dataset;

/// A fit with the result of its lack-of-fit test.
#[derive(Clone, Debug)]
pub struct CheckedFit {
    /// The fit. If the test rejects the model, its covariance is the sandwich covariance.
    pub fit: Fit,
    /// Origin of the intervals.
    pub basis: Basis,
    /// Result of the test; `None` if there is no test for the likelihood.
    pub check: Option<FitCheck>,
}

impl CheckedFit {
    /// A fit by a likelihood that has no test.
    pub fn untested(fit: Fit) -> Self {
        Self { fit, basis: Basis::Curvature, check: None }
    }

    /// Tests a fit of `model` by the default likelihood with shared parameters.
    ///
    /// # Errors
    /// If a recording has too few data.
    pub fn new(recordings: &[Dataset], model: &Model, fit: Fit) -> Result<Self, InferError> {
        let comparisons = comparisons(recordings, model, &fit)?;
        let mut check: Option<FitCheck> = None;
        for (data, comparison) in recordings.iter().zip(&comparisons) {
            let with_own_noise = Fit { channels: comparison.channels(), ..fit.clone() };
            let Some(found) = check_fit(data, comparison, &with_own_noise)? else {
                return Ok(Self::untested(fit));
            };
            check = Some(check.map_or(found, |so_far| worse(so_far, found)));
        }
        if !check.is_some_and(|check| check.is_rejected) {
            return Ok(Self { fit, basis: Basis::Curvature, check });
        }
        let likelihoods: Vec<&dyn Likelihood> = comparisons.iter().map(|c| c as &dyn Likelihood).collect();
        Ok(match fit.sandwiched(model, &likelihoods)? {
            Some((fit, basis)) => Self { fit, basis, check },
            None => Self { fit, basis: Basis::Curvature, check },
        })
    }
}

/// The comparison of each recording, with the noise of the fit, or its own noise if there are several.
fn comparisons(recordings: &[Dataset], model: &Model, fit: &Fit) -> Result<Vec<Comparison>, InferError> {
    if let [data] = recordings {
        return Ok(vec![Comparison::of(data)?.with_channels(fit.channels)]);
    }
    // A fit estimates the noise twice.
    let tuned = |data: &Dataset| {
        Comparison::of(data)?.with_tuned_noise(model, &fit.values)?.with_tuned_noise(model, &fit.values)
    };
    recordings.iter().map(tuned).collect()
}

/// The larger values of two results.
fn worse(a: FitCheck, b: FitCheck) -> FitCheck {
    FitCheck {
        is_rejected: a.is_rejected || b.is_rejected,
        gain_nats: a.gain_nats.max(b.gain_nats),
        residual_force_rms: a.residual_force_rms.max(b.residual_force_rms),
        residual_torque_rms: a.residual_torque_rms.max(b.residual_torque_rms),
    }
}

/// Result of the lack-of-fit test in a summary.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LackOfFitSummary {
    /// Whether the data reject the model.
    pub found: bool,
    /// Gain in log likelihood from a random-walk wrench, nats.
    pub gain_nats: f64,
    /// Root mean square of the residual force, N.
    pub residual_force_rms: f64,
    /// Root mean square of the residual torque, N·m.
    pub residual_torque_rms: f64,
}

impl From<FitCheck> for LackOfFitSummary {
    fn from(check: FitCheck) -> Self {
        let FitCheck { is_rejected: found, gain_nats, residual_force_rms, residual_torque_rms } = check;
        Self { found, gain_nats, residual_force_rms, residual_torque_rms }
    }
}
