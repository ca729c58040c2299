//! The answer for programs: `diagnosis.json` of a recording of joints.

use crate::error_metrics::ErrorMetrics;
use serde::Serialize;
use std::collections::BTreeMap;
use trundle_diagnose::{Quantity, Verdict};

/// The answer of a diagnosis of joints; keys as in DIAGNOSIS.md and MECHANISM.md.
#[derive(Clone, Debug, Serialize)]
pub struct JointAnswer {
    /// `trundle-diagnosis/1`.
    pub format: &'static str,
    /// Name of the recording.
    pub recording: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The missing effects, the largest contribution first.
    pub missing: Vec<JointEffect>,
    /// Sets of single effects that the data cannot distinguish: `effect:joint`.
    pub tied: Vec<Vec<String>>,
    /// Classes of effect sets that the data cannot distinguish.
    pub tied_sets: Vec<Vec<Vec<String>>>,
    /// Detectable effects that do not improve predictions by a material share.
    pub immaterial: Vec<JointEffect>,
    /// Where the mechanism under test disagrees with the recording.
    pub mismatch: JointMismatch,
    /// What remains after the named effects.
    pub residual: JointResidual,
    /// Doubts about the answer.
    pub warnings: Vec<String>,
    /// Effects that explain the data almost as well.
    pub alternatives: Vec<JointAlternative>,
    /// Parameters of the nominal mechanism.
    pub nominal: JointNominal,
    /// Error metrics before and after.
    pub fit: JointFit,
}

/// Largest probability that every name of an explanation is wrong.
const MAX_ALL_WRONG: f64 = 0.5;

impl JointAnswer {
    /// Whether at least one of the named effects is more probably missing than not. An effect counts together with those that the
    /// data cannot distinguish from it, and effects count as independent.
    pub(crate) fn has_probable_name(&self) -> bool {
        let wrong = |effect: &JointEffect| {
            let class = self.tied.iter().find(|class| class.contains(&effect.label()));
            (1.0 - effect.probability * class.map_or(1, Vec::len) as f64).max(0.0)
        };
        self.missing.iter().map(wrong).product::<f64>() <= MAX_ALL_WRONG
    }
}

impl JointEffect {
    /// `effect:joint`, as in ties.
    fn label(&self) -> String {
        let place = self.place.as_ref().and_then(|place| place.values().next());
        place.map_or_else(|| self.effect.clone(), |place| format!("{}:{place}", self.effect))
    }
}

/// A missing effect.
#[derive(Clone, Debug, Serialize)]
pub struct JointEffect {
    /// Name of the effect.
    pub effect: String,
    /// Probability that it belongs into the model.
    pub probability: f64,
    /// Statement for readers.
    pub statement: String,
    /// Its parameters.
    pub parameters: BTreeMap<String, Quantity>,
    /// `{"joint": NAME}` or `{"body": NAME}`.
    #[serde(rename = "where")]
    pub place: Option<BTreeMap<&'static str, String>>,
    /// Share by which the held-out misfit of the effort rises without it.
    pub explains: Option<f64>,
}

/// Where the mechanism under test disagrees with the recording.
#[derive(Clone, Debug, Default, Serialize)]
pub struct JointMismatch {
    /// Share of each joint in the misfit.
    pub joints: BTreeMap<String, f64>,
    /// The motion during which it occurs, in words.
    pub regime: Option<String>,
    /// The same as a keyword.
    pub regime_kind: Option<RegimeKind>,
    /// Intervals of time.
    pub windows: Vec<JointWindow>,
}

/// Kind of motion during which a joint's residual is larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RegimeKind {
    /// In the half of the samples with the higher speed.
    HighSpeed,
    /// In the half with the lower speed.
    LowSpeed,
    /// In the half with the larger acceleration.
    LargeAcceleration,
    /// In the half with the smaller acceleration.
    SmallAcceleration,
    /// In positive direction.
    PositiveDirection,
    /// In negative direction.
    NegativeDirection,
    /// In the first half of the recording.
    FirstHalf,
    /// In the second half.
    SecondHalf,
}

/// An interval in which a joint's equation is violated most.
#[derive(Clone, Debug, Serialize)]
pub struct JointWindow {
    /// Name of the episode.
    pub episode: String,
    /// Name of the joint.
    pub joint: String,
    /// Start, s.
    pub start: f64,
    /// End, s.
    pub end: f64,
    /// Root mean square of the residual, standard deviations of the whole residual.
    pub strength: f64,
}

/// What remains after the named effects.
#[derive(Clone, Debug, Default, Serialize)]
pub struct JointResidual {
    /// Root mean square of each joint's residual effort.
    pub effort_rms: BTreeMap<String, f64>,
    /// Unit of each joint's efforts.
    pub effort_unit: BTreeMap<String, &'static str>,
    /// Share of the misfit before.
    pub share: Option<f64>,
    /// How far the effects reduce each joint's misfit towards the noise: 0 not at all, 1 to the noise; logarithmic.
    pub explained: BTreeMap<String, f64>,
    /// The motion during which it occurs, in words.
    pub regime: Option<String>,
    /// The same as a keyword.
    pub regime_kind: Option<RegimeKind>,
}

/// An effect that explains the data almost as well.
#[derive(Clone, Debug, Serialize)]
pub struct JointAlternative {
    /// Name of the effect.
    pub effect: String,
    /// Its probability.
    pub probability: f64,
    /// The motion or rig that separates it from the named effect.
    pub experiment: String,
    /// `{"joint": NAME}` or `{"body": NAME}`.
    #[serde(rename = "where")]
    pub place: Option<BTreeMap<&'static str, String>>,
}

/// A parameter of the nominal mechanism.
#[derive(Clone, Debug, Serialize)]
pub struct JointParameter {
    /// Mean.
    pub mean: Option<f64>,
    /// Standard deviation.
    pub sd: Option<f64>,
    /// Unit.
    pub unit: &'static str,
    /// Whether the data identify it.
    pub identifiable: bool,
}

/// Parameters of the nominal mechanism.
#[derive(Clone, Debug, Default, Serialize)]
pub struct JointNominal {
    /// As given by the model or the recording.
    pub given: BTreeMap<String, f64>,
    /// Refitted without the effects.
    pub before: BTreeMap<String, JointParameter>,
    /// Refitted together with the effects.
    pub after: BTreeMap<String, JointParameter>,
}

/// Error metrics before and after.
#[derive(Clone, Debug, Serialize)]
pub struct JointBeforeAfter {
    /// Of the nominal mechanism.
    pub before: ErrorMetrics,
    /// With the named effects.
    pub after: ErrorMetrics,
}

/// Error metrics.
#[derive(Clone, Debug, Serialize)]
pub struct JointFit {
    /// On held-out episodes; null if there are none.
    pub held_out: Option<JointBeforeAfter>,
    /// On training episodes.
    pub training: Option<JointBeforeAfter>,
}
