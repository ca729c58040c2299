//! Summary of a fit.

use serde::Serialize;
use trundle_infer::{Basis, Channels, Estimate, INTERVAL_COVERAGE, Score};
use trundle_record::Dataset;

use crate::checked_fit::{CheckedFit, LackOfFitSummary};
use crate::identifiability::IdentifiabilitySummary;

/// Summary of a fit, as documented in `docs/estimation.md`.
#[derive(Clone, Debug, Serialize)]
pub struct FitSummary {
    /// Name of the recording.
    pub recording: String,
    /// The free parameters.
    pub parameters: Vec<ParameterSummary>,
    /// Log evidence by Laplace's approximation, nats.
    pub log_evidence: f64,
    /// Whether the search converged.
    pub converged: bool,
    /// Whether wrenches are compared because inertia is negligible.
    pub quasi_static: bool,
    /// Result of the lack-of-fit test; `None` without one.
    pub lack_of_fit: Option<LackOfFitSummary>,
    /// Origin of the intervals.
    pub intervals: IntervalSummary,
    /// Measurement noise.
    pub noise: NoiseSummary,
    /// Error metrics of the training episodes.
    pub training: Score,
    /// Error metrics of the held-out episodes; `None` without any.
    pub held_out: Option<Score>,
    /// Parameters with a prior-data conflict, in words.
    pub excluded_by_prior: Vec<String>,
    /// Identifiability; absent if the user's prior conflicts with the data.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identifiability: Option<IdentifiabilitySummary>,
    /// Name of the likelihood.
    pub likelihood: &'static str,
    /// Name of the loss.
    pub loss: &'static str,
}

/// A free parameter after a fit, SI units; values are `None` if it is not identifiable.
#[derive(Clone, Debug, Serialize)]
pub struct ParameterSummary {
    name: String,
    mean: Option<f64>,
    sd: Option<f64>,
    /// Lower end of the interval.
    low: Option<f64>,
    /// Upper end of the interval.
    high: Option<f64>,
    unit: &'static str,
    identifiable: bool,
}

/// Origin of intervals.
#[derive(Clone, Debug, Serialize)]
pub struct IntervalSummary {
    coverage: f64,
    basis: &'static str,
    /// Number of episodes of the sandwich covariance.
    episodes: Option<usize>,
}

/// Standard deviations of the noise.
#[derive(Clone, Debug, Serialize)]
pub struct NoiseSummary {
    /// m, m, rad.
    pub pose: [f64; 3],
    /// N.
    pub force: f64,
    /// N·m.
    pub torque: f64,
    /// Whether the recording states it.
    pub stated: bool,
}

impl NoiseSummary {
    /// Noise of a comparison with a recording.
    pub fn new(channels: &Channels, data: &Dataset) -> Self {
        let [force, _, torque] = channels.reading;
        Self { pose: channels.pose, force, torque, stated: data.noise.stated }
    }
}

impl From<Basis> for IntervalSummary {
    fn from(basis: Basis) -> Self {
        let (basis, episodes) = match basis {
            Basis::Curvature => ("curvature", None),
            Basis::Sandwich(episodes) => ("sandwich", Some(episodes)),
        };
        Self { coverage: INTERVAL_COVERAGE, basis, episodes }
    }
}

/// Summaries of the free parameters of a fit.
pub(crate) fn parameters(checked: &CheckedFit) -> Vec<ParameterSummary> {
    let parameter = |(k, e): (usize, &Estimate)| {
        let if_identified = |value: f64| e.identified.then_some(value);
        let [low, high] = checked.fit.interval(k, checked.basis).map(if_identified);
        ParameterSummary {
            name: e.name.clone(),
            mean: if_identified(e.mean),
            sd: if_identified(e.sd),
            low,
            high,
            unit: e.unit,
            identifiable: e.identified,
        }
    };
    checked.fit.estimates.iter().enumerate().map(parameter).collect()
}
