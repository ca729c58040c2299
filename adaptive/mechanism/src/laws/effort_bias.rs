//! Offset of the effort: reading = truth + bias.

use super::law::{Applies, JointLaw, JointScales, Scale, Spec, signed, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "effort_bias",
    summary: "offset of the effort",
    source: "calibration of force sensors",
    applies: Applies::MeasuredEffort,
    params: &[signed("bias", Unit::Effort, Scale::Effort)],
    sentence: "The effort of joint {joint} is recorded with an offset of {bias}",
    experiment: "record the effort of the unloaded joint at rest, and move it in both directions",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![0.02 * scales.effort]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    bias: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [bias] = take(values);
        Self { bias }
    }

    fn correct(&self, reading: T) -> T {
        reading - self.bias
    }
}
