//! Drag that grows with the square of the velocity.

use super::law::{Applies, JointLaw, JointSample, JointScales, Scale, Spec, positive, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "air_drag",
    summary: "drag that grows with the square of the velocity",
    source: "Batchelor, An Introduction to Fluid Dynamics, 1967",
    applies: Applies::Always,
    params: &[positive("coefficient", Unit::Drag, Scale::Drag)],
    sentence: "Drag of {coefficient} per squared velocity acts on joint {joint}",
    experiment: "move the joint at its highest speeds as well as slowly",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![0.1 * scales.effort / (scales.velocity * scales.velocity)]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    coefficient: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [coefficient] = take(values);
        Self { coefficient }
    }

    fn effort(&self, at: &JointSample<T>) -> T {
        -(self.coefficient * (at.v.abs() * at.v))
    }
}
