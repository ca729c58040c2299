//! Play between drive and joint.

use super::law::{Applies, JointLaw, JointScales, ParamSpec, Scale, Spec, positive, take};
use crate::units::Unit;
use trundle_model::Real;

/// Largest play, as a share of the range of motion. Plays of gears are below a degree or two.
const MAX_GAP: f64 = 0.1;
/// Smallest starting value, as a share of the range of motion.
const MIN_GAP: f64 = 0.002;
/// Ratio of plays that a fit can tell apart: the times of impacts are those of the next one otherwise.
const STEP: f64 = 1.15;

pub(super) const SPEC: Spec = Spec {
    effect: "joint_backlash",
    summary: "play between drive and joint",
    source: "Nordin and Gutman, Automatica 2002",
    applies: Applies::Driven,
    params: &[ParamSpec { bounds: [0.0, MAX_GAP], ..positive("gap", Unit::Position, Scale::Position) }],
    sentence: "Drive and joint {joint} have a play of {gap} in all",
    experiment: "reverse the joint under small loads, with an encoder on each side of the gear",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    // The times of impacts depend on the play, so that a fit has many optima.
    (0..8).map(|k| vec![MIN_GAP * 1.6f64.powi(k) * scales.span()]).collect()
}

/// Values from the smallest to the largest play, by [`STEP`].
pub(crate) fn plays(scales: &JointScales) -> Vec<Vec<f64>> {
    let gaps = std::iter::successors(Some(MIN_GAP), |gap| Some(gap * STEP));
    gaps.take_while(|gap| *gap < MAX_GAP).map(|gap| vec![gap * scales.span()]).collect()
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    gap: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [gap] = take(values);
        Self { gap }
    }

    fn gap(&self) -> Option<T> {
        Some(self.gap)
    }
}
