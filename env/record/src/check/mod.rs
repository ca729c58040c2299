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
pub(crate) mod instruments;
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

/// Checks of the units and of the tare. An error in them falsifies the motion or the load.
const QUANTITIES: [Check; 5] =
    [units::lengths_and_gains, units::object_angles, units::torques, gripper::angles, tare::missing];

/// Checks that relate poses, wrench and footprint. With a wrong motion or load, their findings would be consequences of
/// that error.
const RELATIONS: [Check; 6] =
    [gripper::frozen, axes::axes, clocks::lag, episodes::other_object, grasp::slip, grasp::out_of_reach];

/// Checks of a single stream.
const STREAMS: [Check; 9] = [
    units::noise,
    instruments::unsigned,
    clocks::overlap,
    gaps::gaps,
    tare::load_before_contact,
    tare::inconsistent,
    instruments::clipping,
    instruments::masked,
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
    let run = |checks: &[Check]| checks.iter().flat_map(|check| check(&input)).collect::<Vec<Finding>>();
    let mut findings = run(&QUANTITIES);
    if findings.iter().all(|finding| finding.severity != Severity::Error) {
        findings.extend(run(&RELATIONS));
    }
    findings.extend(run(&STREAMS));
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
