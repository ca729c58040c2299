//! The answer for programs: `diagnosis.json`, format `trundle-diagnosis/1`.

use crate::design::{Certificate, Experiment};
use crate::parameter::Parameter;
use serde::Serialize;
use std::collections::BTreeMap;
use trundle_infer::Score;
use trundle_record::WrenchPose;

/// The answer of a diagnosis.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// `trundle-diagnosis/1`.
    pub format: &'static str,
    /// Name of the recording.
    pub recording: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The missing effects, the largest contribution first.
    pub missing: Vec<MissingEffect>,
    /// Sets of single effects that the data cannot distinguish.
    pub tied: Vec<Vec<String>>,
    /// Classes of effect sets that the data cannot distinguish.
    pub tied_sets: Vec<Vec<Vec<String>>>,
    /// Detectable effects whose correction does not improve predictions by a material share. They do not
    /// affect the verdict.
    pub immaterial: Vec<MissingEffect>,
    /// Where the nominal model disagrees with the recording.
    pub mismatch: Mismatch,
    /// Residual of the named model, or of the nominal model if nothing is named.
    pub residual: ResidualSummary,
    /// Warnings about the reliability of the answer.
    pub warnings: Vec<String>,
    /// Models that explain the data almost as well.
    pub alternatives: Vec<Alternative>,
    /// How well the recording distinguishes tied models.
    pub certificates: Vec<Certificate>,
    /// Discriminating experiments for the best alternatives, if they could be designed.
    pub experiments: Vec<Experiment>,
    /// Parameters of the nominal model.
    pub nominal: Nominal,
    /// The pose that transformed each wrench to the object.
    pub wrench_pose: WrenchPose,
    /// Error metrics before and after.
    pub fit: ErrorMetrics,
}

/// Residual: the missing wrench of the model "after".
#[derive(Clone, Debug, Default, Serialize)]
pub struct ResidualSummary {
    /// Root mean square of the missing force over the training episodes, N.
    pub force_rms: Option<f64>,
    /// Root mean square of the missing torque about the object's origin, N·m.
    pub torque_rms: Option<f64>,
    /// Share of the misfit before.
    pub share: Option<f64>,
    /// Intervals in which the residual is significant.
    pub windows: Vec<Window>,
    /// Regime of motion in which it occurs, in words.
    pub regime: Option<String>,
    /// The same as a keyword.
    pub regime_kind: Option<RegimeKind>,
    /// Significant periodicity in position or time.
    pub periods: Vec<Period>,
}

/// A period of the residual.
#[derive(Clone, Debug, Serialize)]
pub struct Period {
    /// `position` or `time`.
    pub of: &'static str,
    /// The period, m or s.
    pub period: f64,
    /// Unit of the period.
    pub unit: &'static str,
    /// Amplitude of the force, N.
    pub amplitude: f64,
}

/// The verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// No effect is missing.
    Consistent,
    /// The laws suffice, but the given values do not.
    Reparameterised,
    /// Named effects explain the mismatch.
    Explained,
    /// No effect of the catalogue explains the mismatch.
    Unexplained,
}

/// A quantity with its uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// Posterior mean.
    pub mean: f64,
    /// Posterior standard deviation.
    pub sd: f64,
    /// SI unit.
    pub unit: &'static str,
}

/// A parameter of an effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A number.
    Number(Quantity),
    /// A symmetric matrix about the origin in the body frame, rows (x, y, θ), of SI units.
    Matrix {
        /// Posterior mean.
        mean: [[f64; 3]; 3],
        /// Posterior standard deviation, where it is known.
        sd: Option<[[f64; 3]; 3]>,
        /// `SI`: N·s/m, N·s and N·m·s.
        unit: &'static str,
    },
}

/// Where or when an effect acts.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Place {
    /// A point of the body or of the world, m.
    Point(Point),
    /// Corners of a region of the floor, world, m.
    Region(Vec<[f64; 2]>),
    /// An event.
    Event {
        /// Name of the episode.
        episode: String,
        /// Time `t` of the episode's table, s.
        time: Moment,
    },
}

/// A time with its uncertainty, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Moment {
    /// Posterior mean.
    pub mean: f64,
    /// Posterior standard deviation.
    pub sd: f64,
}

/// A point with its uncertainty, m.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// x, y.
    pub mean: [f64; 2],
    /// Standard deviations.
    pub sd: [f64; 2],
}

/// A missing effect.
#[derive(Clone, Debug, Serialize)]
pub struct MissingEffect {
    /// Name of the effect in a diagnosis.
    pub effect: String,
    /// Posterior probability of the effect.
    pub probability: f64,
    /// The statement for readers.
    pub statement: String,
    /// Its identifiable parameters.
    pub parameters: BTreeMap<String, Value>,
    /// Where and when it acts; `None` if not identifiable.
    #[serde(rename = "where")]
    pub place: Option<BTreeMap<&'static str, Place>>,
    /// Share by which the held-out misfit falls with the effect, relative to a refit without it.
    pub explains: Option<f64>,
}

/// Where the nominal model disagrees with the recording.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Mismatch {
    /// Intervals of time.
    pub windows: Vec<Window>,
    /// Shares of the standardised misfit by direction.
    pub channels: Channels,
    /// Point of the object at which the missing wrench acts, if it is a single point, m.
    pub body_point: Option<[f64; 2]>,
    /// Polygon on the floor, if the mismatch is confined to it, m.
    pub world_region: Option<Vec<[f64; 2]>>,
    /// Regime of motion in which it occurs, in words.
    pub regime: Option<String>,
    /// The same as a keyword.
    pub regime_kind: Option<RegimeKind>,
}

/// Kind of motion regime in which a wrench is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RegimeKind {
    /// On one part of the floor.
    PartOfFloor,
    /// From a time on.
    FromTimeOn,
    /// A force with a constant direction in the world.
    ConstantInWorld,
    /// A wrench that is constant in the sensor's axes.
    ConstantInSensor,
    /// When moving along one direction of the world.
    WorldDirection,
    /// A drag that moves with the object.
    DragOnObject,
    /// Just after each contact.
    AfterContact,
    /// At low speed and at reversals.
    LowSpeed,
    /// At high speed.
    HighSpeed,
    /// At all speeds.
    AllSpeeds,
}

/// An interval in which the nominal model disagrees with the recording.
#[derive(Clone, Debug, Serialize)]
pub struct Window {
    /// Name of the episode.
    pub episode: String,
    /// Start, time `t` of the episode's table, s.
    pub start: f64,
    /// End, s.
    pub end: f64,
    /// −log10 p.
    pub strength: f64,
}

/// Shares that sum to one.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Channels {
    /// Position along world x.
    pub x: f64,
    /// Position along world y.
    pub y: f64,
    /// Heading.
    pub theta: f64,
}

/// A model that explains the data almost as well, and an experiment to distinguish it.
#[derive(Clone, Debug, Serialize)]
pub struct Alternative {
    /// Its effects, joined by `+`.
    pub effect: String,
    /// Posterior probability of the model.
    pub probability: f64,
    /// The discriminating experiment.
    pub experiment: String,
}

/// Parameters of the nominal model.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Nominal {
    /// Values given by the model file.
    pub given: BTreeMap<String, f64>,
    /// Refitted without the effects.
    pub before: BTreeMap<String, Parameter>,
    /// Refitted together with the effects.
    pub after: BTreeMap<String, Parameter>,
}

/// Error metrics before and after.
#[derive(Clone, Debug, Serialize)]
pub struct BeforeAfter {
    /// Of the nominal model.
    pub before: Score,
    /// Of the model with the named effects, or with a model discrepancy.
    pub after: Score,
}

/// Error metrics.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorMetrics {
    /// On held-out episodes; null if there are none.
    pub held_out: Option<BeforeAfter>,
    /// On training episodes.
    pub training: BeforeAfter,
}
