//! Contact beyond a position.

use super::law::{
    Applies, JointLaw, JointSample, JointScales, ParamSpec, Scale, Spec, positive, signed, take,
};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "joint_stop",
    summary: "contact beyond a position",
    source: "linear spring contact, without damping; Gilardi and Sharf, Mech. Mach. Theory 2002",
    applies: Applies::Always,
    params: &[
        ParamSpec { is_limit: true, ..signed("position", Unit::Position, Scale::Position) },
        positive("stiffness", Unit::Stiffness, Scale::Stiffness),
        ParamSpec { is_choice: true, ..signed("side", Unit::One, Scale::One) },
    ],
    sentence: "Joint {joint} meets a stop at {position} of stiffness {stiffness}",
    experiment: "move the joint slowly against the supposed stop",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    let [low, high] = scales.range;
    let stiffness = 10.0 * scales.effort / scales.span();
    let at = |share: f64| low + share * (high - low);
    vec![
        vec![at(0.9), stiffness, 1.0],
        vec![at(0.75), stiffness, 1.0],
        vec![at(0.1), stiffness, -1.0],
        vec![at(0.25), stiffness, -1.0],
    ]
}

/// Possible positions of a stop with some values: contact over more than half of the range is a spring.
pub(crate) fn stop_positions(scales: &JointScales, values: &[f64]) -> [f64; 2] {
    let [_, _, side] = take(values);
    let [low, high] = scales.range;
    let middle = f64::midpoint(low, high);
    if side > 0.0 { [middle, high] } else { [low, middle] }
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    position: T,
    stiffness: T,
    side: f64,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [position, stiffness, side] = take(values);
        Self { position, stiffness, side: side.re() }
    }

    fn effort(&self, at: &JointSample<T>) -> T {
        let depth = (-self.position + at.q) * self.side;
        if depth.re() > 0.0 { -(self.stiffness * depth * self.side) } else { T::zero() }
    }
}
