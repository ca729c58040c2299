//! First-order lag of the reading behind the effort.

use super::law::{Applies, JointLaw, JointScales, Scale, Spec, positive, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "effort_lag",
    summary: "first-order lag of the effort reading",
    source: "first-order low-pass filter",
    applies: Applies::MeasuredEffort,
    params: &[positive("time_constant", Unit::Time, Scale::Time)],
    sentence: "The effort of joint {joint} is recorded with a lag of {time_constant}",
    experiment: "move the joint with fast reversals at two frequencies",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![0.25 * scales.resolution]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    time_constant: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [time_constant] = take(values);
        Self { time_constant }
    }

    fn lag(&self) -> Option<T> {
        Some(-self.time_constant)
    }
}
