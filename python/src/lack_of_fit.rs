//! Lack-of-fit test of a fit, and intervals that include model error.

use serde_json::{Value, json};
use trundle_diagnose::{FitCheck, check_fit};
use trundle_infer::{Basis, Comparison, Fit, InferError, Likelihood};
use trundle_model::Model;
use trundle_record::Dataset;

/// A fit with what the lack-of-fit test says of it.
pub(crate) struct Tested {
    /// The fit; with the sandwich covariance where the test finds a lack of fit.
    pub fit: Fit,
    /// Where its intervals come from.
    pub basis: Basis,
    /// The test's result; `None` where there is no test.
    pub lack: Option<FitCheck>,
}

impl Tested {
    /// A fit by a likelihood for which there is no test.
    pub fn untested(fit: Fit) -> Self {
        Self { fit, basis: Basis::Curvature, lack: None }
    }

    /// Test a fit of `model` to recordings, by the default likelihood and with shared parameters.
    pub fn new(recordings: &[Dataset], model: &Model, fit: Fit) -> Result<Self, InferError> {
        let comparisons = comparisons(recordings, model, &fit)?;
        let mut lack: Option<FitCheck> = None;
        for (data, comparison) in recordings.iter().zip(&comparisons) {
            let own = Fit { channels: comparison.channels(), ..fit.clone() };
            let Some(found) = check_fit(data, comparison, &own)? else { return Ok(Self::untested(fit)) };
            lack = Some(lack.map_or(found, |so_far| worse(so_far, found)));
        }
        if !lack.is_some_and(|lack| lack.is_rejected) {
            return Ok(Self { fit, basis: Basis::Curvature, lack });
        }
        let likelihoods: Vec<&dyn Likelihood> = comparisons.iter().map(|c| c as &dyn Likelihood).collect();
        Ok(match fit.sandwiched(model, &likelihoods)? {
            Some((fit, basis)) => Self { fit, basis, lack },
            None => Self { fit, basis: Basis::Curvature, lack },
        })
    }

    /// The parts `lack_of_fit` and `intervals` of a summary.
    pub fn summary(&self) -> (Value, Value) {
        let (basis, episodes) = match self.basis {
            Basis::Curvature => ("curvature", None),
            Basis::Sandwich(episodes) => ("sandwich", Some(episodes)),
        };
        (lack_summary(self.lack), json!({"coverage": 0.9, "basis": basis, "episodes": episodes}))
    }
}

/// The test's result for a summary; null where there is no test.
pub(crate) fn lack_summary(lack: Option<FitCheck>) -> Value {
    lack.map_or(Value::Null, |lack| {
        json!({
            "found": lack.is_rejected,
            "gain_nats": lack.gain_nats,
            "residual_force_rms": lack.residual_force_rms,
            "residual_torque_rms": lack.residual_torque_rms,
        })
    })
}

/// Each recording's comparison, with the noise of the fit.
fn comparisons(recordings: &[Dataset], model: &Model, fit: &Fit) -> Result<Vec<Comparison>, InferError> {
    if let [data] = recordings {
        return Ok(vec![Comparison::of(data)?.with_channels(fit.channels)]);
    }
    // Each recording has its own noise, found twice over as in a fit.
    let tuned = |data: &Dataset| {
        Comparison::of(data)?.with_tuned_noise(model, &fit.values)?.with_tuned_noise(model, &fit.values)
    };
    recordings.iter().map(tuned).collect()
}

/// The larger of two recordings' figures.
fn worse(a: FitCheck, b: FitCheck) -> FitCheck {
    FitCheck {
        is_rejected: a.is_rejected || b.is_rejected,
        gain_nats: a.gain_nats.max(b.gain_nats),
        residual_force_rms: a.residual_force_rms.max(b.residual_force_rms),
        residual_torque_rms: a.residual_torque_rms.max(b.residual_torque_rms),
    }
}
