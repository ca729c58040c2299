//! `diagnosis.json`: the answer for programs (`trundle-diagnosis/1`).

use crate::design::{Certificate, Experiment};
use serde::Serialize;
use std::collections::BTreeMap;
use trundle_infer::Score;
use trundle_record::WrenchPose;

/// The whole answer.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// `trundle-diagnosis/1`.
    pub format: &'static str,
    /// Name of the recording.
    pub recording: String,
    /// What became of it.
    pub verdict: Verdict,
    /// The effects that were left out, largest contribution first.
    pub missing: Vec<MissingEffect>,
    /// Sets of effects that the data cannot tell apart.
    pub tied: Vec<Vec<String>>,
    /// Classes of whole sets of effects that the data cannot tell apart.
    pub tied_sets: Vec<Vec<Vec<String>>>,
    /// Detectable effects whose correction would not improve prediction by a material share; no part of the verdict.
    pub immaterial: Vec<MissingEffect>,
    /// Where the simulation as given goes wrong.
    pub mismatch: Mismatch,
    /// What remains after the named effects, also where nothing is named.
    pub residual: ResidualSummary,
    /// Doubts that a careful reader must know of.
    pub warnings: Vec<String>,
    /// What explains the data almost as well.
    pub alternatives: Vec<Alternative>,
    /// How alike the models of tied effects are on what was recorded.
    pub certificates: Vec<Certificate>,
    /// The pushes that would tell the best alternatives apart, where they could be designed.
    pub experiments: Vec<Experiment>,
    /// Parameters of the simulation under test.
    pub nominal: Nominal,
    /// The pose that brought each wrench to the object.
    pub wrench_pose: WrenchPose,
    /// Figures before and after.
    pub fit: ErrorMetrics,
}

/// What remains: the wrench that the model after still misses.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ResidualSummary {
    /// Root mean square of the missing force over the training episodes, N.
    pub force_rms: Option<f64>,
    /// The same of the moment about the object's origin, N·m.
    pub torque_rms: Option<f64>,
    /// Share of the misfit before.
    pub share: Option<f64>,
    /// Stretches of time in which it stands out.
    pub windows: Vec<Window>,
    /// In which motions.
    pub regime: Option<String>,
    /// Significant periodicity in position or time.
    pub periods: Vec<Period>,
}

/// A period of what remains.
#[derive(Clone, Debug, Serialize)]
pub struct Period {
    /// `position` or `time`.
    pub of: &'static str,
    /// m or s.
    pub period: f64,
    /// Unit of the period.
    pub unit: &'static str,
    /// Amplitude of the force, N.
    pub amplitude: f64,
}

/// What became of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing is missing.
    Consistent,
    /// The laws suffice, the given values do not.
    Reparameterised,
    /// What is missing has a name.
    Explained,
    /// Something is missing that nothing known explains.
    Unexplained,
}

/// A number with its interval.
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
    /// A moment.
    Event {
        /// Name of the episode.
        episode: String,
        /// The table's t, s.
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

/// An effect that was left out.
#[derive(Clone, Debug, Serialize)]
pub struct MissingEffect {
    /// Its name in a diagnosis.
    pub effect: String,
    /// That it belongs in the model, given the data.
    pub probability: f64,
    /// The sentence for people.
    pub statement: String,
    /// Its parameters that the data hold.
    pub parameters: BTreeMap<String, Value>,
    /// Where and when it acts; `None` where the data do not hold it.
    #[serde(rename = "where")]
    pub place: Option<BTreeMap<&'static str, Place>>,
    /// Rise of the held-out misfit when it alone is dropped and the rest refitted, as a share.
    pub explains: Option<f64>,
}

/// Where the simulation as given goes wrong.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Mismatch {
    /// Stretches of time.
    pub windows: Vec<Window>,
    /// Shares of the standardised misfit.
    pub channels: Channels,
    /// Where on the object the missing wrench acts, if at one point, m.
    pub body_point: Option<[f64; 2]>,
    /// Polygon on the floor, if tied to it.
    pub world_region: Option<Vec<[f64; 2]>>,
    /// In which motions.
    pub regime: Option<String>,
}

/// A stretch of time in which the simulation goes wrong.
#[derive(Clone, Debug, Serialize)]
pub struct Window {
    /// Name of the episode.
    pub episode: String,
    /// s, the table's `t`.
    pub start: f64,
    /// s.
    pub end: f64,
    /// −log10 p.
    pub strength: f64,
}

/// Shares that add up to one.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Channels {
    /// Position along world x.
    pub x: f64,
    /// Position along world y.
    pub y: f64,
    /// Heading.
    pub theta: f64,
}

/// What explains the data almost as well, and how to tell.
#[derive(Clone, Debug, Serialize)]
pub struct Alternative {
    /// The effect; several joined by `+`.
    pub effect: String,
    /// Of the model with it.
    pub probability: f64,
    /// The push that would tell.
    pub experiment: String,
}

/// A parameter of the simulation under test.
#[derive(Clone, Debug, Serialize)]
pub struct Parameter {
    /// Posterior mean; null where the data do not hold it.
    pub mean: Option<f64>,
    /// Posterior standard deviation; null where the data do not hold it.
    pub sd: Option<f64>,
    /// SI unit.
    pub unit: &'static str,
    /// Whether the data hold it.
    pub identifiable: bool,
}

/// Parameters of the simulation under test.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Nominal {
    /// As the model file gave them.
    pub given: BTreeMap<String, f64>,
    /// Refitted, the effects left out.
    pub before: BTreeMap<String, Parameter>,
    /// Refitted together with the effects.
    pub after: BTreeMap<String, Parameter>,
}

/// Before and after on some episodes.
#[derive(Clone, Debug, Serialize)]
pub struct BeforeAfter {
    /// The simulation under test.
    pub before: Score,
    /// With the effects found, or with an unnamed wrench that predicts.
    pub after: Score,
}

/// Figures.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorMetrics {
    /// On episodes never fitted; null when there are none.
    pub held_out: Option<BeforeAfter>,
    /// On those that were.
    pub training: BeforeAfter,
}
