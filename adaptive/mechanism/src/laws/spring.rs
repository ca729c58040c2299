//! A spring between a joint and its parent: a cable, a balancer.

use super::law::{Applies, JointLaw, JointSample, JointScales, Scale, Spec, signed, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "joint_spring",
    summary: "a spring on a joint",
    source: "Hooke",
    applies: Applies::Always,
    params: &[
        signed("stiffness", Unit::Stiffness, Scale::Stiffness),
        signed("rest", Unit::Position, Scale::Position),
    ],
    sentence: "A spring of {stiffness} acts on joint {joint}",
    experiment: "hold the joint at several positions over its whole range",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![0.1 * scales.effort / scales.span(), f64::midpoint(scales.range[0], scales.range[1])]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    stiffness: T,
    rest: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [stiffness, rest] = take(values);
        Self { stiffness, rest }
    }

    fn effort(&self, at: &JointSample<T>) -> T {
        -(self.stiffness * (-self.rest + at.q))
    }
}
