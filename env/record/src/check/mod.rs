//! What is wrong with a recording, found before any physics: each finding a sentence with its remedy.
//!
//! A check is one function from the prepared recording to findings. Each asks for what holds for every passive
//! object on a floor, whatever its wheels and friction; what only a model could tell is left to the diagnosis.

mod axes;
mod clocks;
mod direction;
mod dynamics;
mod episodes;
mod excitation;
mod explain;
mod gains;
mod gaps;
mod grasp;
mod gripper;
mod group;
mod instruments;
mod lags;
mod subject;
mod tare;
mod units;

use serde::Serialize;

use crate::error::Error;
use crate::fault::Fault;
use crate::prepare::{Options, ReadingAxes, prepare_with};
use crate::recording::Recording;
use subject::Subject;

/// How grave a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// What follows from the recording would be wrong.
    Error,
    /// It may be wrong.
    Warning,
    /// Good to know.
    Note,
}

/// One finding.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// What was checked, as "units".
    pub kind: &'static str,
    /// How grave it is.
    pub severity: Severity,
    /// What is seen, with its figures.
    pub sentence: String,
    /// What to do about it.
    pub remedy: String,
    /// Where; `None` if it concerns the whole recording.
    pub episode: Option<String>,
}

impl Finding {
    fn new(kind: &'static str, severity: Severity, sentence: String, remedy: &str) -> Self {
        Self { kind, severity, sentence, remedy: remedy.to_owned(), episode: None }
    }

    fn of(self, episode: &str) -> Self {
        Self { episode: Some(episode.to_owned()), ..self }
    }
}

type Check = fn(&Subject) -> Vec<Finding>;

const CHECKS: [Check; 20] = [
    units::scales,
    units::angles,
    units::torques,
    units::noise,
    gripper::degrees,
    gripper::frozen,
    axes::axes,
    instruments::unsigned,
    clocks::lag,
    clocks::overlap,
    gaps::gaps,
    tare::steady,
    tare::alike,
    tare::missing,
    episodes::alike,
    instruments::clipping,
    instruments::masked,
    grasp::slip,
    grasp::place,
    excitation::enough,
];

/// All findings about `recording`, the gravest first.
pub fn check(recording: &Recording) -> Vec<Finding> {
    let options = Options { axes: ReadingAxes::Published, ..Options::default() };
    let dataset = match prepare_with(recording, options) {
        Ok(dataset) => dataset,
        Err(error) => return vec![unusable(error)],
    };
    let subject = Subject::new(recording, &dataset);
    let mut findings: Vec<Finding> = CHECKS.iter().flat_map(|check| check(&subject)).collect();
    findings.sort_by_key(|finding| finding.severity);
    findings
}

fn unusable(error: Error) -> Finding {
    let Error { place, fault } = error;
    match *fault {
        Fault::Unusable { reason, remedy } => {
            Finding::new("unusable", Severity::Error, format!("{place}: {reason}"), &remedy)
        }
        other => Finding::new("unusable", Severity::Error, format!("{place}: {other}"), "repair it there"),
    }
}
