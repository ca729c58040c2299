//! Check for wrapped angles.

use std::f64::consts::TAU;

use super::input::Input;
use super::merge::{Found, merged};
use crate::check::{Finding, Severity};

/// Largest deviation of a jump from a full turn, relative to it. Motion between two samples is part of the jump.
const TOLERANCE: f64 = 0.1;
/// Smallest jump relative to the other changes between samples: a motor that makes most of a turn between samples jumps
/// all the time.
const MIN_JUMP_RATIO: f64 = 10.0;

/// Checks for jumps by a full turn.
pub(super) fn wrapped(input: &Input) -> Vec<Finding> {
    if !input.may_be_hinge() {
        return vec![];
    }
    let mut found = Vec::new();
    for (joint, episode) in input.joints.iter().flat_map(|joint| input.raw.iter().map(move |e| (joint, e))) {
        let Some((t, q)) = episode.joint_stream("q", joint) else { continue };
        let steps: Vec<f64> = q.windows(2).map(|pair| pair[1] - pair[0]).collect();
        for (turn, unit) in [(TAU, "2 pi"), (360.0, "360 degrees")] {
            let is_jump = |step: f64| (step.abs() / turn - 1.0).abs() < TOLERANCE;
            let jumps: Vec<usize> = (0..steps.len()).filter(|&k| is_jump(steps[k])).collect();
            let others =
                steps.iter().filter(|step| !is_jump(**step)).fold(0.0, |a: f64, step| a.max(step.abs()));
            let Some(&first) = jumps.first().filter(|_| others * MIN_JUMP_RATIO < turn) else { continue };
            let sentence = format!(
                "the position of {joint} jumps by about {unit} {} times, first from {:.3} to {:.3} at t = {:.2} s: the \
                 angle is wrapped",
                jumps.len(),
                q[first],
                q[first + 1],
                t[first]
            );
            let remedy =
                format!("unwrap q_{joint} (numpy.unwrap), so that positions continue over a full turn");
            let finding =
                Finding::new("angles", Severity::Error, sentence, &remedy).in_episode(&episode.name);
            found.push(Found { size: jumps.len() as f64, joint: joint.clone(), finding });
        }
    }
    merged(found)
}
