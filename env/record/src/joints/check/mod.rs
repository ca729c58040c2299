//! Checks of recordings of joints for mistakes, without a model of the mechanism. Each finding has a remedy.
//!
//! A check is a function from the tracks of all joints to findings. It tests properties that every mechanism has: positive
//! inertia, friction that dissipates, velocities that are derivatives of positions.

mod clocks;
mod command_lag;
mod dynamics;
mod effort_scale;
mod effort_sign;
mod excitation;
mod frozen;
mod input;
mod merge;
mod order;
mod quantisation;
mod regression;
mod saturation;
mod shifts;
mod spikes;
mod units;
mod velocity;
mod wrapped;

use super::recording::JointRecording;
use crate::check::{Finding, Severity};
use input::Input;

type Check = fn(&Input) -> Vec<Finding>;

/// Checks of the tables themselves.
const TABLE_CHECKS: [Check; 6] = [
    wrapped::wrapped,
    spikes::spikes,
    frozen::frozen,
    clocks::clocks,
    quantisation::quantisation,
    saturation::saturation,
];
/// Checks of the motion. It is wrong if the tables are.
const MOTION_CHECKS: [Check; 8] = [
    units::degrees,
    order::order,
    effort_sign::unsigned,
    effort_sign::reversed,
    effort_scale::gain,
    velocity::velocity,
    command_lag::command_lag,
    excitation::excitation,
];

/// All findings about `recording`, most severe first. The motion is not checked if its positions or times are wrong, because
/// all further findings would have this cause.
pub fn check_joints(recording: &JointRecording) -> Vec<Finding> {
    let input = Input::new(recording);
    let run = |checks: &[Check]| checks.iter().flat_map(|check| check(&input)).collect::<Vec<Finding>>();
    let mut findings = run(&TABLE_CHECKS);
    if findings.iter().all(|finding| finding.severity != Severity::Error) {
        findings.extend(run(&MOTION_CHECKS));
    }
    findings.sort_by_key(|finding| finding.severity);
    findings
}
