//! Checks of a recording for mistakes, without any model of its effects. Each finding has a remedy.
//!
//! A check is a function from the prepared recording to findings. It tests a property that every passive object on a floor
//! has, whatever its wheels and friction. The diagnosis covers everything that depends on a model.

mod axes;
mod clocks;
mod data;
mod direction;
mod dynamics;
mod episodes;
mod excitation;
mod finding;
mod gains;
pub(crate) mod gaps;
mod grasp;
mod gripper;
pub(crate) mod group;
mod input;
mod instruments;
mod lags;
mod tare;
mod units;
mod wrench_fit;

use crate::error::Error;
use crate::fault::Fault;
use crate::prepare::{Options, ReadingAxes, prepare_with};
use crate::recording::Recording;
pub use finding::{Finding, Severity};
use input::CheckInput;

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
