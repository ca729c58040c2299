//! Checks of a recording for mistakes, without any model of its effects. Each finding has a remedy.
//!
//! A check is a function from the prepared recording to findings. It tests a property that every passive object on a floor
//! has, whatever its wheels and friction. The diagnosis covers everything that depends on a model.

mod axes;
mod clocks;
mod direction;
mod dynamics;
mod episodes;
mod excitation;
mod gains;
mod gaps;
mod grasp;
mod gripper;
mod group;
mod input;
mod instruments;
mod lags;
mod tare;
mod units;
mod wrench_fit;

use serde::Serialize;

use crate::error::Error;
use crate::fault::Fault;
use crate::prepare::{Options, ReadingAxes, prepare_with};
use crate::recording::Recording;
use input::CheckInput;

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Results from this recording would be wrong.
    Error,
    /// Results from this recording may be wrong.
    Warning,
    /// For information.
    Note,
}

/// A finding of a check.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Category, for example "units".
    pub kind: &'static str,
    /// Severity.
    pub severity: Severity,
    /// What is wrong, with numbers.
    pub sentence: String,
    /// How to correct it.
    pub remedy: String,
    /// Name of the episode; `None` if the finding concerns the whole recording.
    pub episode: Option<String>,
}

impl Finding {
    fn new(kind: &'static str, severity: Severity, sentence: String, remedy: &str) -> Self {
        Self { kind, severity, sentence, remedy: remedy.to_owned(), episode: None }
    }

    fn in_episode(self, episode: &str) -> Self {
        Self { episode: Some(episode.to_owned()), ..self }
    }
}

type Check = fn(&CheckInput) -> Vec<Finding>;

const CHECKS: [Check; 20] = [
    units::lengths_and_gains,
    units::object_angles,
    units::torques,
    units::noise,
    gripper::angles,
    gripper::frozen,
    axes::axes,
    instruments::unsigned,
    clocks::lag,
    clocks::overlap,
    gaps::gaps,
    tare::load_before_contact,
    tare::inconsistent,
    tare::missing,
    episodes::other_object,
    instruments::clipping,
    instruments::masked,
    grasp::slip,
    grasp::out_of_reach,
    excitation::excitation,
];

/// All findings about `recording`, most severe first.
pub fn check(recording: &Recording) -> Vec<Finding> {
    let options = Options { axes: ReadingAxes::Published, ..Options::default() };
    let dataset = match prepare_with(recording, options) {
        Ok(dataset) => dataset,
        Err(error) => return vec![unusable(error)],
    };
    let input = CheckInput::new(recording, &dataset);
    let mut findings: Vec<Finding> = CHECKS.iter().flat_map(|check| check(&input)).collect();
    findings.sort_by_key(|finding| finding.severity);
    findings
}

fn unusable(error: Error) -> Finding {
    let Error { place, fault } = error;
    match *fault {
        Fault::Unusable { reason, remedy } => {
            Finding::new("unusable", Severity::Error, format!("{place}: {reason}"), &remedy)
        }
        other => Finding::new(
            "unusable",
            Severity::Error,
            format!("{place}: {other}"),
            "correct the recording at this place",
        ),
    }
}
